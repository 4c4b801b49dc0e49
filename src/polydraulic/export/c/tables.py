"""Networks as tables in C, and the functions that read them: what a model of many regions is exported as.

Straight-line code of hundreds of networks is megabytes of text, which compilers take minutes for; tables of their numbers are a fraction of
it and compile at once. The order of operations is that of `network`, from the same texts, so that both give the same bits.
"""

from collections.abc import Iterator, Sequence
from importlib.resources import files
from itertools import accumulate
from string import Template

from polydraulic.export.c.network import helpers, nested, nested_slopes, offset, output_limits, times_exponents
from polydraulic.export.c.text import Real, block_comment, listed, literal, rounded_down
from polydraulic.export.model_bundle import Bundle
from polydraulic.networks.model.nodes import DOUBLE, KIND_NAMES, LINEAR, RAMP, SIGMOID, SINGLE, TRIPLE, terms
from polydraulic.networks.model.partition import flatten
from polydraulic.networks.model.table import Network, used_slots

_WIDTH = 120  # of lines
_POLYNOMIALS = (SINGLE, DOUBLE, TRIPLE)
_SLOTS = ("a", "b", "d")
_FUNCTIONS = ("one", "two", "three", "linear", "sigmoid", "ramp")  # of kinds; single and double mean precisions in C


def first_networks(whole: Bundle) -> list[int]:
    """Number of each output's first network in the tables, and how many there are."""
    return [0, *accumulate(len(model.networks) for model in whole.models)]


def regions(whole: Bundle) -> list[str]:
    """Expressions for the network of each output that answers, counted from its first one."""
    found, first = [], 0
    for model in whole.models:
        tree = flatten(model.partition)
        found.append(f"own_region({tree.root + first if tree.root >= 0 else tree.root}, {tree.depth}, x)")
        first += tree.axis.size
    return found


def table_helpers(whole: Bundle, real: Real) -> str:
    """Functions that those of `tables` call."""
    return helpers(whole.models, real, clamps=True)


def tables(whole: Bundle, real: Real) -> str:
    """The tables of all networks, and the functions ``own_value``, ``own_slopes_of`` and ``own_region``.

    Parameters
    ----------
    whole : Bundle
    real : Real

    Raises
    ------
    InputError
        If a number does not fit into a float.
    """
    networks = [network for model in whole.models for network in model.networks]
    kept = [used_slots(network) for network in networks]
    nodes = [network.nodes[k] for network, (_, used) in zip(networks, kept, strict=True) for k in used]
    for node in nodes:
        if node.kind in _POLYNOMIALS:
            _literals(times_exponents(node), real)  # refuses what their slopes could not hold
    kinds = sorted({node.kind for node in nodes}) or [LINEAR]
    rest = any(
        offset(network.x_mean[i], real)[1] for network, (used, _) in zip(networks, kept, strict=True) for i in used
    )
    shifted = "(clamp(x[place[k]], low[k], high[k]) - own_read_mean[i])"
    template = Template(files("polydraulic.export").joinpath("templates", "tables.c.txt").read_text(encoding="utf-8"))
    return template.substitute(
        tables="\n".join(_tables(whole, networks, kept, rest, real)),
        t=real.name,
        zero=literal(0.0, real),
        kinds="\n".join(_kind_functions(kind, real) for kind in kinds),
        values=_cases(kinds, "y = own_{}(c, from, n, slot);"),
        slopes=_cases(kinds, "own_{}_slopes(c, from, n, slot, y, partial);"),
        normalized=f"({shifted} - own_read_rest[i])" if rest else shifted,
        n=len(whole.inputs),
        n_slots=max(network.n_inputs + len(used) for network, (_, used) in zip(networks, kept, strict=True)),
        n_partials=max([1, *(len(node.inputs) for node in nodes)]),
    )


def _tables(
    whole: Bundle, networks: Sequence[Network], kept: Sequence[tuple[list[int], list[int]]], rest: bool, real: Real
) -> Iterator[str]:
    nodes = [(network, network.nodes[k]) for network, (_, used) in zip(networks, kept, strict=True) for k in used]
    read = [(network, i) for network, (used, _) in zip(networks, kept, strict=True) for i in used]
    offsets = [offset(network.x_mean[i], real) for network, i in read]
    slots = [_slots(network, used, k) for network, (_, used) in zip(networks, kept, strict=True) for k in used]
    yield _integers("own_net_read", [0, *accumulate(len(used) for used, _ in kept)])
    yield _integers("own_read_input", [i for _, i in read])
    yield _numbers("own_read_mean", [first for first, _ in offsets], real)
    if rest:
        yield _numbers("own_read_rest", [second for _, second in offsets], real)
    yield _numbers("own_read_gain", [1.0 / network.x_scale[i] for network, i in read], real)
    yield _integers("own_net_node", [0, *accumulate(len(used) for _, used in kept)])
    if len({node.kind for _, node in nodes}) > 1:
        yield "/* Kinds: " + ", ".join(f"{kind} {name}" for kind, name in enumerate(KIND_NAMES)) + ". */"
        yield _integers("own_node_kind", [node.kind for _, node in nodes])
    yield _integers("own_node_from", [0, *accumulate(map(len, slots))])
    yield _integers("own_node_slot", [slot for row in slots for slot in row])
    yield _integers("own_node_coef", list(accumulate((len(node.coef) for _, node in nodes), initial=0))[:-1])
    yield _coefficients(whole, networks, kept, real)
    yield _numbers("own_y_mean", [network.y_mean for network in networks], real)
    yield _numbers("own_y_scale", [network.y_scale if network.nodes else 0.0 for network in networks], real)
    for what, ends in zip(
        ("y_low", "y_high"), zip(*(output_limits(n, real) for n in networks), strict=True), strict=True
    ):
        yield _numbers(f"own_{what}", ends, real)
    axis: list[int] = []
    at: list[float] = []
    below: list[int] = []
    above: list[int] = []
    first = 0
    for model, place in zip(whole.models, whole.places, strict=True):
        tree = flatten(model.partition)
        axis += [place[i] for i in tree.axis.tolist()]
        at += [rounded_down(value, real) for value in tree.at.tolist()]
        for ways, own in ((below, tree.below), (above, tree.above)):
            ways += [way + first if way >= 0 else way for way in own.tolist()]
        first += tree.axis.size
    yield _integers("own_split_axis", axis)
    yield _numbers("own_split_at", at, real)
    yield _integers("own_split_below", below)
    yield _integers("own_split_above", above)


def _slots(network: Network, used: list[int], k: int) -> list[int]:
    """Slots that node `k` reads, where nodes that nobody reads have none."""
    n = network.n_inputs
    return [slot if slot < n else n + used.index(slot - n) for slot in network.nodes[k].inputs]


def _coefficients(
    whole: Bundle, networks: Sequence[Network], kept: Sequence[tuple[list[int], list[int]]], real: Real
) -> str:
    """One line for each node, under the output and the number of its network."""
    lines, count = [], 0
    outputs = [block_comment([model.output.name])[3:-3].strip(" *\n") for model in whole.models]
    names = [f"{name}, {r}" for name, m in zip(outputs, whole.models, strict=True) for r in range(len(m.networks))]
    for name, network, (_, used) in zip(names, networks, kept, strict=True):
        lines.append(f"    /* {name} */")
        for k in used:
            count += len(network.nodes[k].coef)
            lines.append(f"    {', '.join(_literals(network.nodes[k].coef, real))},")
    if not count:
        return _numbers("own_coef", [], real)
    return "\n".join([f"static const {real.name} own_coef[{count}] = {{", *lines, "};"])


def _kind_functions(kind: int, real: Real) -> str:
    """Value of a kind of node, and its slopes, from its coefficients c and from the slots that it reads."""
    t, own, one, zero = real.name, _FUNCTIONS[kind], literal(1.0, real), literal(0.0, real)
    reads = f"const {t} c[], const int from[], int n, const {t} slot[]"
    if kind in _POLYNOMIALS:
        v, size = _SLOTS[: kind + 1], len(terms(kind, kind + 1))
        c = [f"c[{i}]" for i in range(size)]
        powers = [max(exponents) for exponents in terms(kind, kind + 1)]
        several = [f"({literal(float(e), real)} * {text})" for e, text in zip(powers, c, strict=True)]
        start = [f"const {t} {a} = slot[from[{i}]];" for i, a in enumerate(v)]
        value = [*start, "(void)n;", f"return {nested(kind, c, v)};"]
        found = nested_slopes(kind, c, several, v)
        slopes = [*start, "(void)n;", "(void)y;", *(f"partial[{i}] = {text};" for i, text in enumerate(found))]
    else:
        first, shift = ("c[0] * slot[from[0]]", "i") if kind == LINEAR else ("c[0] + c[1] * slot[from[0]]", "i + 1")
        loop = ["for (i = 1; i < n; ++i) {", f"    h += c[{shift}] * slot[from[i]];", "}"]
        value = ["int i;", f"{t} h = {first};", *loop, f"return {'h' if kind == LINEAR else f'{KIND_NAMES[kind]}(h)'};"]
        slope = {
            LINEAR: "c[i]",
            SIGMOID: f"y * ({one} - y) * c[i + 1]",
            RAMP: f"((y > {zero}) && (y < {one})) ? c[i + 1] : {zero}",
        }[kind]
        unused = ["(void)from;", "(void)slot;", *(["(void)y;"] if kind == LINEAR else [])]
        slopes = ["int i;", *unused, "for (i = 0; i < n; ++i) {", f"    partial[i] = {slope};", "}"]
    return f"""static {t} own_{own}({reads})
{_block(value)}
static void own_{own}_slopes({reads}, {t} y, {t} partial[])
{_block(slopes)}"""


def _block(statements: Sequence[str]) -> str:
    return "\n".join(["{", *(f"    {line}" for line in statements), "}", ""])


def _cases(kinds: Sequence[int], statement: str) -> str:
    """A switch over the kinds of nodes, the last case for all that is left; of one kind, its statement alone."""
    statements = [statement.format(_FUNCTIONS[kind]) for kind in kinds]
    if len(kinds) == 1:
        return f"    {statements[0]}"
    heads = [*(f"case {kind}:" for kind in kinds[:-1]), "default:"]
    cases = [f"    {head}\n        {text}\n        break;" for head, text in zip(heads, statements, strict=True)]
    return "\n".join(["    switch (own_node_kind[own_node]) {", *cases, "    }"])


def _literals(values: Sequence[float], real: Real) -> list[str]:
    return [literal(value, real) for value in values]


def _integers(name: str, values: Sequence[int]) -> str:
    return _array(f"static const int {name}", [str(value) for value in values] or ["0"])


def _numbers(name: str, values: Sequence[float], real: Real) -> str:
    return _array(f"static const {real.name} {name}", _literals(values or [0.0], real))


def _array(start: str, texts: Sequence[str]) -> str:
    return f"{start}[{len(texts)}] = {{\n{listed(texts, _WIDTH)}\n}};"
