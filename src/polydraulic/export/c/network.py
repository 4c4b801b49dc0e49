"""A network as straight-line C: its value, and its value with exact slopes.

Polynomials are nested as in `networks.table.evaluate`, and numbers are written so that they read back exactly; a
compiler that keeps to C99 (no fused multiply-adds) gives the same bits as the package.
"""

from collections.abc import Sequence

from polydraulic.export.c.text import DOUBLE, FLOAT, Real, held_in, inner_ends, literal, rounded_down
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.nodes import DOUBLE as TWO
from polydraulic.networks.model.nodes import KIND_NAMES, LINEAR, RAMP, SIGMOID, SINGLE, terms
from polydraulic.networks.model.partition import Partition, Split
from polydraulic.networks.model.table import UNBOUNDED, Network, Node, used_slots

# `elementary.exp`, operation by operation: the same bits. The numbers for `float` are those of its classic expf.
_EXP = {
    DOUBLE: ("700.0", "1.4426950408889634", "6755399441055744.0", "6.93147180369123816490e-01", "1.90821492927058770002e-10",
             "1.66666666666666019037e-01 + z * (-2.77777777770155933842e-03 + z * (6.61375632143793436117e-05\n"
             "        + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08)))"),
    FLOAT: ("87.0f", "1.44269502f", "12582912.0f", "0.693145752f", "1.42860677e-06f",
            "1.66666254e-01f + z * -2.76673329e-03f"),
}  # fmt: skip


def helpers(models: Sequence[Model], real: Real, *, clamps: bool = False) -> str:
    """The functions that the networks of `models` call, `clamp` also if `clamps` says so; an unused one is a warning."""
    t, s = real.name, real.suffix
    networks = [network for model in models for network in model.networks]
    found = ""
    if clamps or any(used_slots(network)[0] or bounded(network) for network in networks):
        found += f"""static {t} clamp({t} v, {t} low, {t} high)
{{
    const {t} raised = (v < low) ? low : v;
    return (raised > high) ? high : raised;
}}

"""
    if any(network.nodes[place].kind == SIGMOID for network in networks for place in used_slots(network)[1]):
        limit, log2e, round_, high, low, c = _EXP[real]
        found += f"""static {t} sigmoid({t} h)
{{
    const {t} limited = clamp(-h, -{limit}, {limit});
    const {t} k = (limited * {log2e} + {round_}) - {round_};
    const {t} high = limited - k * {high};
    const {t} low = k * {low};
    const {t} r = high - low;
    const {t} z = r * r;
    const {t} c = r - z * ({c});
    return 1.0{s} / (1.0{s} + ldexp{s}(1.0{s} - ((low - (r * c) / (2.0{s} - c)) - high), (int)k));
}}

"""
    if any(network.nodes[place].kind == RAMP for network in networks for place in used_slots(network)[1]):
        found += f"""static {t} ramp({t} h)
{{
    return clamp(h, 0.0{s}, 1.0{s});
}}

"""
    return found


def value_function(name: str, network: Network, place: Sequence[int], n_input: int, where: str, real: Real) -> str:
    """``static REAL name(const REAL x[])``: the network's output."""
    lines = [f"/* {where} */", f"static {real.name} {name}(const {real.name} x[{n_input}])", "{"]
    body, last = _nodes(network, place, real)
    lines += body or ["    (void)x;"]
    y = _unitized(network, last, real)
    if bounded(network):
        y = f"clamp({y}, {', '.join(_literals(output_limits(network, real), real))})"
    return "\n".join([*lines, f"    return {y};", "}", ""])


def slopes_function(name: str, network: Network, place: Sequence[int], n_input: int, where: str, real: Real) -> str:
    """``static REAL name_slopes(const REAL x[], REAL dy[])``: output, and slopes by all inputs, carried backwards."""
    t, zero = real.name, literal(0.0, real)
    lines = [f"/* {where} */", f"static {t} {name}_slopes(const {t} x[{n_input}], {t} dy[{n_input}])", "{"]
    body, last = _nodes(network, place, real)
    lines += body or ["    (void)x;"]
    y = _unitized(network, last, real)
    names = _names(network)
    inputs, nodes = used_slots(network)
    lines += [f"    const {t} y = {y};"] if bounded(network) else []
    gains: dict[int, list[str]] = {}
    if network.nodes:
        scale = literal(network.y_scale, real)
        if bounded(network):
            low, high = _literals(output_limits(network, real), real)
            scale = f"((y < {low}) || (y > {high})) ? {zero} : {scale}"
        gains[network.n_inputs + len(network.nodes) - 1] = [scale]
    for k in reversed(nodes):
        slot = network.n_inputs + k
        lines.append(f"    const {t} g{k} = {' + '.join(gains[slot])};")
        node = network.nodes[k]
        for source, slope in zip(node.inputs, _slopes(node, names, names[slot], real), strict=True):
            gains.setdefault(source, []).append(f"g{k} * ({slope})")
    domain = input_limits(network, real)
    for i in inputs:
        low, high = _literals(domain[i], real)
        gain = literal(1.0 / network.x_scale[i], real)
        inside = f"(x[{place[i]}] < {low}) || (x[{place[i]}] > {high})"
        lines.append(f"    dy[{place[i]}] = ({inside}) ? {zero} : ({' + '.join(gains[i])}) * {gain};")
    lines += [f"    dy[{i}] = {zero};" for i in range(n_input) if i not in {place[j] for j in inputs}]
    if bounded(network):
        y = f"clamp(y, {', '.join(_literals(output_limits(network, real), real))})"
    return "\n".join([*lines, f"    return {y};", "}", ""])


def choice(partition: Partition, place: Sequence[int], real: Real, indent: str = "    ") -> list[str]:
    """Statements that return the number of the network that answers for x."""
    if not isinstance(partition, Split):
        return [f"{indent}return {partition};"]
    deeper = indent + "    "
    return [
        f"{indent}if (x[{place[partition.axis]}] > {literal(rounded_down(partition.at, real), real)}) {{",
        *choice(partition.above, place, real, deeper),
        f"{indent}}} else {{",
        *choice(partition.below, place, real, deeper),
        f"{indent}}}",
    ]


def bounded(network: Network) -> bool:
    """Whether the output is clamped."""
    return (network.y_low, network.y_high) != (-UNBOUNDED, UNBOUNDED)


def polynomial(node: Node, names: Sequence[str], real: Real = DOUBLE) -> str:
    """Value of a node in terms of the slots that it reads, in C and in Python."""
    return nested(node.kind, [literal(value, real) for value in node.coef], [names[slot] for slot in node.inputs])


def nested(kind: int, c: Sequence[str], v: Sequence[str]) -> str:
    """Value of a node from the texts of its coefficients and of what it reads, in the order of operations of the package."""
    if kind == LINEAR:
        return " + ".join(f"{a} * {b}" for a, b in zip(c, v, strict=True))
    if kind in (SIGMOID, RAMP):
        return f"{KIND_NAMES[kind]}({' + '.join([c[0], *(f'{a} * {b}' for a, b in zip(c[1:], v, strict=True))])})"
    if kind == SINGLE:
        a = v[0]
        return f"{c[0]} + {a} * ({c[1]} + {a} * ({c[2]} + {a} * {c[3]}))"
    if kind == TWO:
        a, b = v
        return (
            f"{c[0]} + {a} * ({c[1]} + {a} * ({c[3]} + {a} * {c[6]}) + {b} * {c[5]})"
            f" + {b} * ({c[2]} + {b} * ({c[4]} + {b} * {c[7]}))"
        )
    a, b, d = v
    return (
        f"{c[0]} + {a} * ({c[1]} + {a} * ({c[4]} + {a} * {c[11]}) + {b} * ({c[7]} + {d} * {c[10]}) + {d} * {c[8]})"
        f" + {b} * ({c[2]} + {b} * ({c[5]} + {b} * {c[12]}) + {d} * {c[9]})"
        f" + {d} * ({c[3]} + {d} * ({c[6]} + {d} * {c[13]}))"
    )


def nested_slopes(kind: int, c: Sequence[str], several: Sequence[str], v: Sequence[str]) -> list[str]:
    """Derivatives of a polynomial node by each of its inputs; `several` are its coefficients times their exponents."""

    def own_terms(a: str, square: int, cube: int) -> str:
        return f"{a} * ({several[square]} + {a} * {several[cube]})"

    if kind == SINGLE:
        return [f"{c[1]} + {own_terms(v[0], 2, 3)}"]
    if kind == TWO:
        a, b = v
        return [f"{c[1]} + {own_terms(a, 3, 6)} + {b} * {c[5]}", f"{c[2]} + {own_terms(b, 4, 7)} + {a} * {c[5]}"]
    a, b, d = v
    return [
        f"{c[1]} + {own_terms(a, 4, 11)} + {b} * ({c[7]} + {d} * {c[10]}) + {d} * {c[8]}",
        f"{c[2]} + {own_terms(b, 5, 12)} + {a} * ({c[7]} + {d} * {c[10]}) + {d} * {c[9]}",
        f"{c[3]} + {own_terms(d, 6, 13)} + {a} * ({c[8]} + {b} * {c[10]}) + {b} * {c[9]}",
    ]


def times_exponents(node: Node) -> list[float]:
    """Coefficients of a polynomial node, squares and cubes times 2 and 3: as they stand in its slopes."""
    exponents = terms(node.kind, len(node.inputs))
    return [max(1, *powers) * value for value, powers in zip(node.coef, exponents, strict=True)]


def _slopes(node: Node, names: Sequence[str], own: str, real: Real) -> list[str]:
    """Derivatives of a node by each of its inputs; `own` is the node's value."""
    c = [literal(value, real) for value in node.coef]
    if node.kind == LINEAR:
        return c
    if node.kind == SIGMOID:
        one = literal(1.0, real)
        return [f"{own} * ({one} - {own}) * {weight}" for weight in c[1:]]
    if node.kind == RAMP:
        zero, one = literal(0.0, real), literal(1.0, real)
        return [f"(({own} > {zero}) && ({own} < {one})) ? {weight} : {zero}" for weight in c[1:]]
    several = [literal(value, real) for value in times_exponents(node)]
    return nested_slopes(node.kind, c, several, [names[slot] for slot in node.inputs])


def _names(network: Network) -> list[str]:
    return [f"n{i}" for i in range(network.n_inputs)] + [f"z{k}" for k in range(len(network.nodes))]


def _nodes(network: Network, place: Sequence[int], real: Real) -> tuple[list[str], str]:
    """Statements for the normalized inputs and the nodes on which the output depends, and the name of the last node."""
    names, lines = _names(network), []
    inputs, nodes = used_slots(network)
    domain = input_limits(network, real)
    for i in inputs:
        ends = ", ".join(_literals(domain[i], real))
        mean, rest = offset(network.x_mean[i], real)
        gain = literal(1.0 / network.x_scale[i], real)
        shifted = f"clamp(x[{place[i]}], {ends}) - {literal(mean, real)}"
        if rest:
            shifted = f"({shifted}) - {literal(rest, real)}"
        lines.append(f"    const {real.name} n{i} = ({shifted}) * {gain};")
    for k in nodes:
        node = network.nodes[k]
        lines.append(f"    const {real.name} z{k} = {polynomial(node, names, real)}; /* {KIND_NAMES[node.kind]} */")
    return lines, names[-1]


def input_limits(network: Network, real: Real) -> list[tuple[float, float]]:
    """Domain in the code, by input."""
    return [inner_ends(low, high, real) for low, high in zip(network.x_low, network.x_high, strict=True)]


def output_limits(network: Network, real: Real) -> tuple[float, float]:
    """Bounds of the output in the code."""
    return inner_ends(network.y_low, network.y_high, real)


def _literals(values: Sequence[float], real: Real) -> list[str]:
    return [literal(value, real) for value in values]


def offset(mean: float, real: Real) -> tuple[float, float]:
    """Two numbers to subtract one after the other for `mean`: in single precision, inputs far from zero would else lose digits."""
    first = held_in(mean, real)
    rest = held_in(mean - first, real)
    return first, rest if abs(rest) >= real.smallest else 0.0  # what is smaller cannot be written


def _unitized(network: Network, last: str, real: Real) -> str:
    mean = literal(network.y_mean, real)
    return f"{mean} + {literal(network.y_scale, real)} * {last}" if network.nodes else mean
