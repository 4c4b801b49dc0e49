"""Text of what is done with a mass matrix: products, kinetic energy, and a solution in which joints may be held.

The solution is a factorisation L D L' written out for the entries that the tree has, from its tips to its root, so that branches stay
apart. D holds blocks of up to three joints, which are inverted by their cofactors: each block takes one division.
"""

from collections.abc import Sequence
from itertools import pairwise

from polydraulic.machine.tree.equations import entry_name
from polydraulic.machine.tree.statements import body, call, returned
from polydraulic.machine.tree.terms import ZERO, Recorder, Term

_BLOCK = 3
Entries = dict[tuple[int, int], Term]


def mass_text(names: Sequence[str], places: Sequence[tuple[int, int]]) -> str:
    """The named tuple of a mass matrix.

    Parameters
    ----------
    names : sequence of str
        Of the joints.
    places : sequence of (int, int)
        Entries of the upper triangle that are not zero by structure.
    """
    lines = [
        "class Mass(NamedTuple):",
        '    """Mass matrix, its upper triangle without what is zero by structure: kg m2, kg m and kg."""',
        "",
    ]
    for i, j in places:
        comment = names[i] if i == j else f"{names[i]}, {names[j]}"
        lines.append(f"    {entry_name(i, j, len(names))}: float  # {comment}")
    return "\n".join(lines)


def times_text(names: Sequence[str], places: Sequence[tuple[int, int]]) -> str:
    """Kernels `times` and `kinetic`."""
    terms = Recorder()
    entries = _mirrored({(i, j): terms.leaf(f"mass.{entry_name(i, j, len(names))}", f"m{i}_{j}") for i, j in places})
    v = [terms.leaf(f"v.{name}", f"v_{name}") for name in names]
    rows = [
        sum((entries[i, j] * v[j] for j in range(len(names)) if (i, j) in entries), ZERO) for i in range(len(names))
    ]
    rates = " + ".join(f"momentum.{name} * rate.{name}" for name in names)
    return "\n".join(
        [
            "@kernel",
            "def times(mass, v):",
            '    """M v: momentum of rates, torque of accelerations."""',
            body(rows, lambda texts: call("Joints", texts)),
            "",
            "",
            "@kernel",
            "def kinetic(mass, rate):",
            '    """Kinetic energy in J."""',
            "    momentum = times(mass, rate)",
            returned(f"0.5 * ({rates})") if len(names) < 4 else _long_sum(rates),
        ]
    )


def _long_sum(text: str) -> str:
    lines = text.replace(" + ", "\n        + ")
    return f"    twice = (\n        {lines}\n    )\n    return 0.5 * twice"


def solve_text(names: Sequence[str], places: Sequence[tuple[int, int]]) -> str:
    """Kernel `solve_motion`."""
    n, terms = len(names), Recorder()
    lines = [
        "@kernel",
        "def solve_motion(mass, held, right):",
        '    """Solve M v = right for the joints that are free; held ones get 0."""',
    ]
    entries: Entries = {}
    for i, j in places:
        name = entry_name(i, j, n)
        held = f"held.{names[i]}" if i == j else f"(held.{names[i]} or held.{names[j]})"
        lines.append(f"    {name} = {1.0 if i == j else 0.0} if {held} else mass.{name}")
        entries[i, j] = terms.leaf(name, name)
    rights = []
    for i, name in enumerate(names):
        lines.append(f"    r{i + 1} = 0.0 if held.{name} else right.{name}")
        rights.append(terms.leaf(f"r{i + 1}", f"r{i + 1}"))
    solution = _solution(_mirrored(entries), rights, names, terms)
    return "\n".join([*lines, body(solution, lambda texts: call("Joints", texts))])


def _mirrored(entries: Entries) -> Entries:
    return entries | {(j, i): term for (i, j), term in entries.items()}


def _solution(m: Entries, right: list[Term], names: Sequence[str], terms: Recorder) -> list[Term]:
    """Joints are eliminated by blocks from the last one on, and found from the first one on."""
    found: list[Term] = [ZERO] * len(right)
    parts = []
    for block in _blocks(len(right)):
        cofactors, scale = _inverse(m, block, names, terms)
        alone = _divided([right[k] for k in block], cofactors, scale, [f"{names[j]}_alone" for j in block])
        levers: dict[int, list[Term]] = {}
        for i in range(block[0]):
            coupling = [m.get((i, k), ZERO) for k in block]
            levers[i] = _divided(coupling, cofactors, scale, [f"{names[j]}_by_{names[i]}" for j in block])
            right[i] = (right[i] - _dot(coupling, alone)).named(f"{names[i]}_right")
        for i in range(block[0]):
            for j in range(i, block[0]):
                less = _dot(levers[i], [m.get((k, j), ZERO) for k in block])
                value = (m.get((i, j), ZERO) - less).named(f"left{i + 1}{j + 1}")
                m |= {(i, j): value, (j, i): value}
        parts.append((block, alone, levers))
    for block, alone, levers in reversed(parts):
        for p, j in enumerate(block):
            less = _dot([lever[p] for lever in levers.values()], [found[i] for i in levers])
            found[j] = (alone[p] - less).named(f"{names[j]}_found")
    return found


def _divided(row: Sequence[Term], cofactors: list[list[Term]], scale: Term, labels: Sequence[str]) -> list[Term]:
    """A row times the inverse of a block; the division is under way while the products are summed."""
    return [(_dot(row, column) * scale).named(label) for column, label in zip(cofactors, labels, strict=True)]


def _blocks(n: int) -> list[range]:
    """Blocks of at most three joints, alike in size, the last joints first."""
    count = -(-n // _BLOCK)
    ends = [n * k // count for k in range(count + 1)]
    return [range(start, end) for start, end in pairwise(ends)][::-1]


def _dot(a: Sequence[Term], b: Sequence[Term]) -> Term:
    return sum((x * y for x, y in zip(a, b, strict=True)), ZERO)


def _inverse(m: Entries, block: range, names: Sequence[str], terms: Recorder) -> tuple[list[list[Term]], Term]:
    """Cofactors of a block, and one over its determinant."""
    n = len(block)
    rows = [[m.get((i, j), ZERO) for j in block] for i in block]
    cofactors = [[_cofactor(rows, i, j).named(f"c{block[i] + 1}{block[j] + 1}") for j in range(n)] for i in range(n)]
    scale = terms.reciprocal(_dot(rows[0], cofactors[0]))
    return cofactors, scale.named("scale_" + "_".join(names[k] for k in block))


def _cofactor(rows: list[list[Term]], i: int, j: int) -> Term:
    n = len(rows)
    if n == 1:
        return Term(1.0, None)
    a, b = ([k % n for k in range(line + 1, line + n)] for line in (i, j))
    if n == 2:
        return rows[a[0]][b[0]] * (1.0 if i == j else -1.0)
    return rows[a[0]][b[0]] * rows[a[1]][b[1]] - rows[a[0]][b[1]] * rows[a[1]][b[0]]
