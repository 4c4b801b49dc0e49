"""A model as straight-line code, in LLVM's own text: a region is found by branches, its network is arithmetic without a loop or a table.

Operations and their order are those of `table.evaluate`, from which the nested polynomials are recorded, and nothing is fused or
left out, so that the bits are the same. Sigmoids that read the same slots, as those of perceptrons do, are computed eight at a time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from struct import pack
from typing import Any

from polydraulic.networks.model.model import Model
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, SIGMOID, SINGLE, TRIPLE
from polydraulic.networks.model.partition import Partition, Split
from polydraulic.networks.model.table import Network, double, single, triple, used_slots

ENTRY = "answer"  # double answer(ptr): the output for the inputs that stand there
_SIDE_BY_SIDE = 8
_POLYNOMIALS: dict[int, Callable[..., Any]] = {
    kind: getattr(kernel, "py_func", kernel) for kind, kernel in ((SINGLE, single), (DOUBLE, double), (TRIPLE, triple))
}


def network_text(model: Model) -> str:
    """Text of a module with one function, `ENTRY`, which no inputs of any kind make fail."""
    leaves = [_network(f"network_{k}", network) for k, network in enumerate(model.networks)]
    return "\n".join([*leaves, _function(ENTRY, _choice(model.partition, _Names(), "begin"))])


class _Names:
    """Names of values and places in a function."""

    def __init__(self) -> None:
        self._count = 0

    def new(self) -> str:
        self._count += 1
        return f"v{self._count}"


class _Code:
    """Statements of a function in the order in which they run."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._names = _Names()

    def value(self, kind: str, text: str) -> "_Value":
        """The value of an operation, which gets a name."""
        name = f"%{self._names.new()}"
        self.lines.append(f"{name} = {text}")
        return _Value(self, kind, name)


@dataclass(frozen=True)
class _Value:
    """A number, or several side by side; arithmetic with it is written down."""

    code: _Code
    kind: str
    name: str

    def _with(self, operation: str, other: "_Value") -> "_Value":
        return self.code.value(self.kind, f"{operation} {self.kind} {self.name}, {other.name}")

    def __add__(self, other: "_Value") -> "_Value":
        return self._with("fadd", other)

    def __sub__(self, other: "_Value") -> "_Value":
        return self._with("fsub", other)

    def __mul__(self, other: "_Value") -> "_Value":
        return self._with("fmul", other)

    def __truediv__(self, other: "_Value") -> "_Value":
        return self._with("fdiv", other)

    def clamped(self, low: "_Value", high: "_Value") -> "_Value":
        """``min(max(x, low), high)`` as Python has it: the first of two that are equal, or not comparable."""
        return self._unless("ogt", low)._unless("olt", high)

    def _unless(self, comparison: str, other: "_Value") -> "_Value":
        condition = self.kind.replace("double", "i1")
        other_wins = self.code.value(condition, f"fcmp {comparison} {self.kind} {other.name}, {self.name}")
        chosen = f"select {condition} {other_wins.name}, {self.kind} {other.name}, {self.kind} {self.name}"
        return self.code.value(self.kind, chosen)

    def bits(self, kind: str) -> "_Value":
        """The same bits as another kind of number."""
        return self.code.value(kind, f"bitcast {self.kind} {self.name} to {kind}")


def _network(name: str, network: Network) -> str:
    """A function that evaluates one network."""
    code = _Code()
    inputs, nodes = used_slots(network)
    slots = {i: _input(code, network, i) for i in inputs}
    for group in _groups(network, nodes):
        first = network.nodes[group[0]]
        read = [slots[slot] for slot in first.inputs]
        if first.kind == SIGMOID and len(group) > 1:
            values = _sigmoids(code, [network.nodes[k].coef for k in group], read)
        else:
            values = [_node(code, first.kind, first.coef, read)]
        slots |= {network.n_inputs + k: value for k, value in zip(group, values, strict=True)}
    last = slots[network.n_inputs + nodes[-1]] if nodes else _number(code, 0.0)
    mean, scale, low, high = (
        _number(code, y) for y in (network.y_mean, network.y_scale, network.y_low, network.y_high)
    )
    result = (mean + scale * last).clamped(low, high)
    return _function(name, [*code.lines, f"ret double {result.name}"], "internal ")


def _groups(network: Network, nodes: Sequence[int]) -> list[list[int]]:
    """Nodes in order; sigmoids that follow each other and read the same slots stand together."""
    groups: list[list[int]] = []
    for k in nodes:
        before = network.nodes[groups[-1][0]] if groups else None
        alike = before is not None and network.nodes[k].kind == before.kind == SIGMOID
        if (
            before is not None
            and alike
            and network.nodes[k].inputs == before.inputs
            and len(groups[-1]) < _SIDE_BY_SIDE
        ):
            groups[-1].append(k)
        else:
            groups.append([k])
    return groups


def _input(code: _Code, network: Network, i: int) -> _Value:
    """A normalized input, which is moved into the domain first."""
    place = code.value("ptr", f"getelementptr double, ptr %x, i64 {i}")
    low, high, mean = (_number(code, x[i]) for x in (network.x_low, network.x_high, network.x_mean))
    gain = _number(code, 1.0 / network.x_scale[i])
    return (code.value("double", f"load double, ptr {place.name}").clamped(low, high) - mean) * gain


def _node(code: _Code, kind: int, coef: Sequence[float], read: Sequence[_Value]) -> _Value:
    c = [_number(code, value) for value in coef]
    if kind in _POLYNOMIALS:
        value: _Value = _POLYNOMIALS[kind](*read, *c)
        return value
    if kind == LINEAR:
        return _sum(c[0] * read[0], c[1:], read[1:])
    total = _sum(c[0], c[1:], read)
    return _sigmoid(total) if kind == SIGMOID else total.clamped(_number(code, 0.0), _number(code, 1.0))


def _sum(total: _Value, coef: Sequence[_Value], read: Sequence[_Value]) -> _Value:
    for c, value in zip(coef, read, strict=True):
        total = total + c * value
    return total


def _sigmoids(code: _Code, coefs: Sequence[Sequence[float]], read: Sequence[_Value]) -> list[_Value]:
    """Sigmoids of the same slots, side by side."""
    kind = f"<{len(coefs)} x double>"
    c = [_numbers(code, values) for values in zip(*coefs, strict=True)]
    alike = []
    for value in read:
        first = code.value(kind, f"insertelement {kind} poison, double {value.name}, i64 0")
        alike.append(
            code.value(kind, f"shufflevector {kind} {first.name}, {kind} poison, <{len(coefs)} x i32> zeroinitializer")
        )
    found = _sigmoid(_sum(c[0], c[1:], alike))
    return [code.value("double", f"extractelement {kind} {found.name}, i64 {k}") for k in range(len(coefs))]


def _sigmoid(h: _Value) -> _Value:
    """``1 / (1 + exp(-h))``, operation by operation that of `elementary.exp`."""

    def number(value: float) -> _Value:
        return _Value(h.code, h.kind, _constant(h.kind, value))

    x = h.code.value(h.kind, f"fneg {h.kind} {h.name}").clamped(number(-700.0), number(700.0))
    rounded = x * number(1.4426950408889634) + number(6755399441055744.0)
    k = rounded - number(6755399441055744.0)
    high, low = x - k * number(6.93147180369123816490e-01), k * number(1.90821492927058770002e-10)
    r = high - low
    z = r * r
    nested = number(4.13813679705723846039e-08)
    for value in (
        -1.65339022054652515390e-06,
        6.61375632143793436117e-05,
        -2.77777777770155933842e-03,
        1.66666666666666019037e-01,
    ):
        nested = number(value) + z * nested
    c = r - z * nested
    y = number(1.0) - ((low - (r * c) / (number(2.0) - c)) - high)
    # k stands in the lowest bits of `rounded`: 2^k is those bits, and the bias of the exponent, moved to its place
    whole = h.kind.replace("double", "i64")
    biased = h.code.value(whole, f"add {whole} {rounded.bits(whole).name}, {_constant(whole, 1023)}")
    power = h.code.value(whole, f"shl {whole} {biased.name}, {_constant(whole, 52)}").bits(h.kind)
    return number(1.0) / (number(1.0) + y * power)


def _choice(part: Partition, names: _Names, label: str) -> list[str]:
    """Statements that find the region, one branch for each split, and return what its network gives."""
    if not isinstance(part, Split):
        return [f"{label}:", f"%of_{label} = tail call double @network_{part}(ptr %x)", f"ret double %of_{label}"]
    below, above = names.new(), names.new()
    return [
        f"{label}:",
        f"%place_{label} = getelementptr double, ptr %x, i64 {part.axis}",
        f"%at_{label} = load double, ptr %place_{label}",
        f"%above_{label} = fcmp ogt double %at_{label}, {_literal(part.at)}",
        f"br i1 %above_{label}, label %{above}, label %{below}",
        *_choice(part.below, names, below),
        *_choice(part.above, names, above),
    ]


def _function(name: str, lines: Sequence[str], linkage: str = "") -> str:
    return "\n".join([f"define {linkage}double @{name}(ptr %x) nounwind {{", *lines, "}"])


def _number(code: _Code, value: float) -> _Value:
    return _Value(code, "double", _literal(value))


def _numbers(code: _Code, values: Sequence[float]) -> _Value:
    listed = ", ".join(f"double {_literal(value)}" for value in values)
    return _Value(code, f"<{len(values)} x double>", f"<{listed}>")


def _constant(kind: str, value: float) -> str:
    """A number as a constant of a kind, once or side by side."""
    text = str(value) if "i64" in kind else _literal(value)
    if not kind.startswith("<"):
        return text
    count, _, element = kind.strip("<>").partition(" x ")
    return f"<{', '.join([f'{element} {text}'] * int(count))}>"


def _literal(value: float) -> str:
    """The bits of a number."""
    return f"0x{pack('>d', value).hex().upper()}"
