"""A model as formula: plain text, a SymPy expression, LaTeX, and the source of a Python function.

The first three are for reading and algebra and round what they print or compute; the Python source nests polynomials
as the package and the C code do, and gives the same bits.
"""

import builtins
import keyword
import re
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from math import comb, inf, prod
from typing import TYPE_CHECKING, Any

from polydraulic.errors import InputError
from polydraulic.export.c.network import bounded, polynomial
from polydraulic.export.c.text import literal, one_line
from polydraulic.networks.model.model import Model, Variable, describe
from polydraulic.networks.model.nodes import KIND_NAMES, RAMP, SIGMOID, terms
from polydraulic.networks.model.table import Network, Node

if TYPE_CHECKING:
    import sympy

_LARGEST = 1000  # an expanded polynomial may have this many terms
_LOSS = Fraction(1, 10**9)  # and may lose this share of the output's scale to rounding
_ROUNDING = Fraction(1, 2**53)
_DIGITS = 17  # SymPy writes code with as many digits as a number has; fewer do not read back exactly
_TERMS_A_LINE = 4
_LATEX_BENT = {SIGMOID: "1 / (1 + \\exp(-({})))", RAMP: "\\min(\\max({},\\, 0),\\, 1)"}

# The sigmoid of `networks.table` with the exponential of `elementary`, operation by operation.
_PYTHON_SIGMOID = """
    from math import ldexp

    def sigmoid(h):
        limited = min(max(-h, -700.0), 700.0)
        k = (limited * 1.4426950408889634 + 6755399441055744.0) - 6755399441055744.0
        high = limited - k * 6.93147180369123816490e-01
        low = k * 1.90821492927058770002e-10
        r = high - low
        z = r * r
        c = r - z * (1.66666666666666019037e-01 + z * (-2.77777777770155933842e-03
            + z * (6.61375632143793436117e-05 + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))))
        return 1.0 / (1.0 + ldexp(1.0 - ((low - (r * c) / (2.0 - c)) - high), int(k)))
""".splitlines()[1:]
_PYTHON_RAMP = ["    def ramp(h):", "        return min(max(h, 0.0), 1.0)"]


def to_text(model: Model) -> str:
    """Equations of `model` in words, by region, one line per node.

    Parameters
    ----------
    model : Model

    Returns
    -------
    str
        Numbers with six digits; n1, n2, ... are the normalized inputs, z1, z2, ... the nodes, y is the output.
    """
    lines = [f"y = {model.output} from {', '.join(map(str, model.inputs))}"]
    lines.append("Inputs outside the domain are moved to its border.")
    for network, box in zip(model.networks, model.region_boxes(), strict=True):
        limits = zip(model.inputs, network.x_low, network.x_high, strict=True)
        lines += ["", f"{_where(model.inputs, box.tolist())}:"] if len(model.networks) > 1 else [""]
        lines += [f"domain of {v.name}: {low:.6g} to {high:.6g} {v.unit}".rstrip() for v, low, high in limits]
        lines += describe(network, model.inputs)
        if bounded(network):
            lines.append(f"y is clamped to {network.y_low:.6g} to {network.y_high:.6g} {model.output.unit}".rstrip())
    return "\n".join(map(one_line, lines)) + "\n"


def to_sympy(model: Model, *, clamp: bool = False, expanded: bool = False) -> "sympy.Expr":
    """`model` as a SymPy expression in the raw inputs.

    Parameters
    ----------
    model : Model
    clamp : bool
        Move inputs into the domain and the output into its bounds, by Min and Max. Without it the expression equals
        the model inside domain and bounds, and goes on as a polynomial outside.
    expanded : bool
        Multiply out to one polynomial in the inputs; otherwise nodes stay nested.

    Returns
    -------
    sympy.Expr
        Symbols carry the names of the inputs; a Piecewise where there are regions. Numbers have 17 digits, so that
        `lambdify` keeps them exactly; ``.n(6)`` shortens them.

    Raises
    ------
    InputError
        If SymPy is missing, two inputs have one name, or the expanded polynomial would be too long or too inaccurate.
    """
    try:
        import sympy
        from sympy.core.parameters import distribute
    except ImportError as error:
        raise InputError("to_sympy needs SymPy: pip install polydraulic[export]") from error
    names = [variable.name for variable in model.inputs]
    if len(set(names)) < len(names):
        raise InputError(f"the inputs are named {names}: symbols need different names")
    symbols = [sympy.Symbol(name) for name in names]
    cases, number = [], partial(sympy.Float, dps=_DIGITS)
    bent = {SIGMOID: lambda h: 1 / (1 + sympy.exp(-h)), RAMP: lambda h: _clamped(sympy, h, 0.0, 1.0)}
    with distribute(False):  # a gain multiplied into (x - mean) would cost digits
        for network, box in zip(model.networks, model.region_boxes(), strict=True):
            limits = zip(symbols, network.x_low, network.x_high, strict=True)
            x = [_clamped(sympy, *limit) for limit in limits] if clamp else symbols
            y = _expanded(sympy, network, x) if expanded else _value(network, x, number, bent)
            if clamp and bounded(network):
                y = _clamped(sympy, y, network.y_low, network.y_high)
            cases.append((y, _condition(sympy, box.tolist(), symbols)))
        return sympy.Piecewise(*cases[:-1], (cases[-1][0], True))


def to_latex(model: Model, *, digits: int = 6) -> str:
    """`model` as LaTeX for display mathematics; needs amsmath.

    Parameters
    ----------
    model : Model
    digits : int
        Digits of the numbers, 1 to 17.

    Returns
    -------
    str
        An ``aligned`` environment: normalizers with domain and unit, nodes, unitizer; for regions one in each row of
        ``cases``. A hat marks a normalized input. Inputs outside the domain are to be moved to its border first.

    Raises
    ------
    InputError
        If `digits` is out of range.
    """
    if not 1 <= digits <= 17:
        raise InputError(f"digits = {digits!r}: must be 1 to 17")
    names = _latex_names([*model.inputs, model.output])
    blocks = [_aligned(model, network, names, digits) for network in model.networks]
    if len(blocks) == 1:
        return f"{blocks[0]}\n"
    rows = []
    for block, box in zip(blocks, model.region_boxes(), strict=True):
        ends = zip(names[:-1], box.tolist(), strict=True)
        limits = [_latex_interval(name, low, high, digits) for name, (low, high) in ends]
        rows.append(f"{block} & {', '.join(filter(None, limits))}")
    inner = " \\\\[2ex]\n".join(rows)
    return f"{names[-1]} = \\begin{{cases}}\n{inner}\n\\end{{cases}}\n"


def to_python(model: Model, name: str) -> str:
    """Source of a Python function that evaluates `model` and needs nothing else.

    Parameters
    ----------
    model : Model
    name : str
        Name of the function.

    Returns
    -------
    str
        The function takes the inputs as numbers, or as one sequence, and returns the bits of `Model.predict`. Inputs
        must be finite; this is not checked.

    Raises
    ------
    InputError
        If `name` cannot name a function.
    """
    if not name.isidentifier() or keyword.iskeyword(name) or hasattr(builtins, name):
        raise InputError(f"name = {name!r}: must be a Python identifier that is neither a keyword nor built in")
    low, high = model.domain().T
    doc = [f"{model.output} from", ""]
    doc += [f"x{i}: {v}, domain {low[i]:g} to {high[i]:g}" for i, v in enumerate(model.inputs)]
    doc += ["", "Inputs outside the domain are moved to its border."]
    text = "\n    ".join(one_line(line).replace("\\", "\\\\").replace('"', '\\"') for line in doc)
    unpacked = ", ".join(f"x{i}" for i in range(len(model.inputs)))
    unpacked += "," if len(model.inputs) == 1 else ""
    lines = [
        f"def {name}(*inputs):",
        f'    """{text}\n    """',
        '    if len(inputs) == 1 and hasattr(inputs[0], "__len__"):',
        "        inputs = inputs[0]",
        f"    {unpacked} = map(float, inputs)",
    ]
    kinds = {node.kind for network in model.networks for node in network.nodes}
    lines += [*(_PYTHON_SIGMOID if SIGMOID in kinds else []), *(_PYTHON_RAMP if RAMP in kinds else [])]
    for k, (network, box) in enumerate(zip(model.networks, model.region_boxes(), strict=True)):
        last = k == len(model.networks) - 1
        if len(model.networks) > 1:
            lines.append(f"    # {one_line(_where(model.inputs, box.tolist()))}")
        lines += [] if last else [f"    if {_python_condition(box.tolist())}:"]
        lines += [("    " if last else "        ") + line for line in _python_body(network)]
    return re.sub(r"[ ]+\n", "\n", "\n".join(lines)) + "\n"


def _value(network: Network, x: Sequence[Any], number: Callable[[float], Any], bent: dict[int, Any]) -> Any:
    """Output of `network` before its bounds, in whatever algebra `x`, `number` and, by kind, what is `bent` live in."""
    slots = [
        (value - number(mean)) * number(1.0 / scale)
        for value, mean, scale in zip(x, network.x_mean, network.x_scale, strict=True)
    ]
    for node in network.nodes:
        value = sum(number(c) * prod(slots[i] ** e for i, e in factors) for c, factors in _factors(node))
        slots.append(bent[node.kind](value) if node.kind in bent else value)
    return number(network.y_mean) + (number(network.y_scale) * slots[-1] if network.nodes else 0)


def _factors(node: Node) -> list[tuple[float, list[tuple[int, int]]]]:
    """Terms of a node that are not zero: coefficient, and slot and exponent of each factor."""
    exponents = terms(node.kind, len(node.inputs))
    return [
        (c, [(slot, e) for slot, e in zip(node.inputs, powers, strict=True) if e])
        for c, powers in zip(node.coef, exponents, strict=True)
        if c
    ]


def _clamped(sympy: Any, value: Any, low: float, high: float) -> Any:
    # Unevaluated: to ask whether a whole network exceeds a number can take SymPy seconds.
    raised = sympy.Max(value, sympy.Float(low, _DIGITS), evaluate=False)
    return sympy.Min(raised, sympy.Float(high, _DIGITS), evaluate=False)


def _condition(sympy: Any, box: list[list[float]], symbols: Sequence[Any]) -> Any:
    parts = []
    for symbol, (low, high) in zip(symbols, box, strict=True):
        parts += [symbol > sympy.Float(low, _DIGITS)] if low > -inf else []
        parts += [symbol <= sympy.Float(high, _DIGITS)] if high < inf else []
    return sympy.And(*parts)


def _expanded(sympy: Any, network: Network, x: Sequence[Any]) -> Any:
    """One polynomial in `x`; multiplied out with exact fractions, rounded once."""
    if bent := [KIND_NAMES[node.kind] for node in network.nodes if node.kind in (SIGMOID, RAMP)]:
        raise InputError(f"a network with {bent[0]} nodes is not a polynomial: leave out expanded=True")
    degrees = [1] * network.n_inputs
    needed = [{i} for i in range(network.n_inputs)]
    for node in network.nodes:
        degrees.append(max((sum(e * degrees[slot] for slot, e in factors) for _, factors in _factors(node)), default=0))
        needed.append(set().union(*(needed[slot] for slot in node.inputs)))
    used = needed[-1] if network.nodes else set()
    if comb(len(used) + degrees[-1], degrees[-1]) > _LARGEST:
        raise InputError(
            f"a polynomial of degree {degrees[-1]} in {len(used)} inputs may have more than {_LARGEST} terms: "
            "leave out expanded=True"
        )
    ring, *generators = sympy.ring([f"x{i}" for i in range(len(x))], sympy.QQ)

    def exact(value: float) -> Any:
        return ring(sympy.QQ(*value.as_integer_ratio()))

    parts = [
        (Fraction(int(c.numerator), int(c.denominator)), powers)
        for powers, c in ring(_value(network, generators, exact, {})).terms()
    ]
    reach = [
        max(abs(Fraction(low)), abs(Fraction(high))) for low, high in zip(network.x_low, network.x_high, strict=True)
    ]
    largest = sum(abs(c) * prod(r**e for r, e in zip(reach, powers, strict=True)) for c, powers in parts)
    if largest * _ROUNDING > _LOSS * Fraction(max(abs(network.y_mean), abs(network.y_scale))):
        raise InputError("terms of the expanded polynomial cancel and would lose its digits: leave out expanded=True")
    return sympy.Add(
        *(
            sympy.Float(sympy.Rational(c.numerator, c.denominator), _DIGITS)
            * sympy.Mul(*(v**e for v, e in zip(x, powers, strict=True)))
            for c, powers in parts
        )
    )


def _where(inputs: Sequence[Variable], box: list[list[float]]) -> str:
    """A region in words: ``where 0 < x <= 1 and p > 2``."""
    parts = []
    for variable, (low, high) in zip(inputs, box, strict=True):
        if low > -inf and high < inf:
            parts.append(f"{low:g} < {variable.name} <= {high:g}")
        elif low > -inf:
            parts.append(f"{variable.name} > {low:g}")
        elif high < inf:
            parts.append(f"{variable.name} <= {high:g}")
    return f"where {' and '.join(parts)}" if parts else "everywhere"


def _python_condition(box: list[list[float]]) -> str:
    parts = []
    for i, (low, high) in enumerate(box):
        if low > -inf or high < inf:
            left = f"{literal(low)} < " if low > -inf else ""
            right = f" <= {literal(high)}" if high < inf else ""
            parts.append(f"{left}x{i}{right}")
    return " and ".join(parts)


def _python_body(network: Network) -> list[str]:
    """Statements that return the output; the same nesting and the same clamps as in C."""

    def clamped(value: str, low: float, high: float) -> str:
        return (
            f"{literal(low)} if {value} < {literal(low)} else {literal(high)} if {value} > {literal(high)} else {value}"
        )

    names = [f"n{i}" for i in range(network.n_inputs)]
    lines = []
    for i in sorted({slot for node in network.nodes for slot in node.inputs if slot < network.n_inputs}):
        inside = clamped(f"x{i}", network.x_low[i], network.x_high[i])
        lines.append(f"n{i} = (({inside}) - {literal(network.x_mean[i])}) * {literal(1.0 / network.x_scale[i])}")
    for number, node in enumerate(network.nodes):
        lines.append(f"z{number} = {polynomial(node, names)}  # {KIND_NAMES[node.kind]}")
        names.append(f"z{number}")
    y = literal(network.y_mean)
    if network.nodes:
        y = f"{y} + {literal(network.y_scale)} * {names[-1]}"
    if not bounded(network):
        return [*lines, f"return {y}"]
    return [*lines, f"y = {y}", f"return {clamped('y', network.y_low, network.y_high)}"]


def _aligned(model: Model, network: Network, names: Sequence[str], digits: int) -> str:
    letter = next((c for c in "zwvuts" if not any(name.startswith(c) for name in names)), "\\zeta")
    slots, lines = [_hat(name) for name in names[:-1]], []
    for i, variable in enumerate(model.inputs):
        shift = _latex_sum([f"{names[i]}", _latex_number(-network.x_mean[i], digits)])
        low, high = (_latex_number(v, digits) for v in (network.x_low[i], network.x_high[i]))
        domain = f"{names[i]} \\in [{low},\\, {high}]{_latex_unit(variable)}"
        lines.append(f"{slots[i]} &= \\frac{{{shift}}}{{{_latex_number(network.x_scale[i], digits)}}} && {domain}")
    for number, node in enumerate(network.nodes, start=1):
        slots.append(f"{letter}_{{{number}}}")
        parts = [
            "\\,".join([_latex_number(c, digits), *(slots[i] + (f"^{{{e}}}" if e > 1 else "") for i, e in factors)])
            for c, factors in _factors(node)
        ] or ["0"]
        parts = [_LATEX_BENT[node.kind].format(_latex_sum(parts))] if node.kind in _LATEX_BENT else parts
        for start in range(0, len(parts), _TERMS_A_LINE):
            rest = _latex_sum(parts[start : start + _TERMS_A_LINE])
            signed = f"- {rest[1:]}" if rest.startswith("-") else f"+ {rest}"
            left, right = (f"&\\quad {signed}", "") if start else (f"{slots[-1]} &= {rest}", KIND_NAMES[node.kind])
            lines.append(f"{left} &&" + (f" \\text{{{right}}}" if right else ""))
    parts = [_latex_number(network.y_mean, digits)]
    parts += [f"{_latex_number(network.y_scale, digits)}\\,{slots[-1]}"] if network.nodes else []
    y = _latex_sum(parts)
    if bounded(network):
        low, high = (_latex_number(v, digits) for v in (network.y_low, network.y_high))
        y = f"\\min(\\max({y},\\, {low}),\\, {high})"
    lines.append(f"{names[-1]} &= {y} &&{_latex_unit(model.output)}")
    return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"


def _latex_interval(name: str, low: float, high: float, digits: int) -> str:
    left = f"{_latex_number(low, digits)} < " if low > -inf else ""
    right = f" \\le {_latex_number(high, digits)}" if high < inf else ""
    return f"{left}{name}{right}" if left or right else ""


def _latex_sum(parts: Sequence[str]) -> str:
    """Terms joined by their signs."""
    return " ".join([parts[0], *(f"- {part[1:]}" if part.startswith("-") else f"+ {part}" for part in parts[1:])])


def _latex_number(value: float, digits: int) -> str:
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    return f"{mantissa} \\times 10^{{{int(exponent)}}}" if exponent else mantissa


def _latex_names(variables: Sequence[Variable]) -> list[str]:
    """Names as symbols with subscripts; whole words if two of them would look the same."""
    names = [_latex_name(one_line(variable.name)) for variable in variables]
    if len(set(names)) == len(names):
        return names
    return [f"\\text{{{_escaped(one_line(variable.name))}}}" for variable in variables]


def _latex_name(name: str) -> str:
    found = re.fullmatch(r"([A-Za-z]+)[_.]?([A-Za-z0-9_.]*)", name)
    if not found:
        return f"\\text{{{_escaped(name)}}}"
    base, index = (
        part if len(part) < 2 or part.isdigit() else f"\\mathrm{{{_escaped(part)}}}" for part in found.groups()
    )
    return f"{base}_{{{index}}}" if index else base


def _hat(name: str) -> str:
    """The normalized variable: a hat over the symbol, not over its index."""
    base, mark, index = name.partition("_{")
    return f"\\hat{{{base}}}{mark}{index}" if len(base) == 1 else f"\\widehat{{{name}}}"


def _latex_unit(variable: Variable) -> str:
    return f"\\ \\text{{{_escaped(one_line(variable.unit))}}}" if variable.unit else ""


def _escaped(text: str) -> str:
    special = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    return "".join(special.get(c, f"\\{c}" if c in "&%$#_{}" else c) for c in text)
