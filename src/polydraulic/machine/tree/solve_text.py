"""Text of what is done with a mass matrix: products, kinetic energy, and a solution in which joints may be held.

The solution is a factorisation L D L' written out for the entries that the tree has, from its tips to its root, so that branches stay
apart. D holds blocks of two joints: each block takes one division.
"""

from collections.abc import Sequence

from polydraulic.machine.tree.statements import body, call, returned
from polydraulic.machine.tree.terms import ZERO, Term, Terms

Entries = dict[tuple[int, int], Term]


def entry_name(i: int, j: int, n: int) -> str:
    """Name of the field of row i and column j, counted from 0, in a mass matrix of n joints."""
    return f"m{i + 1}{j + 1}" if n < 10 else f"m{i + 1}_{j + 1}"


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
    terms = Terms()
    entries = _mirrored({(i, j): terms.leaf(f"mass.{entry_name(i, j, len(names))}", f"m{i}_{j}") for i, j in places})
    v = [terms.leaf(f"v.{name}", f"v_{name}") for name in names]
    rows = [sum((entries[i, j] * v[j] for j in range(len(names)) if (i, j) in entries), ZERO) for i in range(len(names))]
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
    n, terms = len(names), Terms()
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


def _solution(m: Entries, right: list[Term], names: Sequence[str], terms: Terms) -> list[Term]:
    """Joints are eliminated by blocks from the last one on, and found from the first one on."""
    n = len(right)
    blocks = [tuple(range(max(end - 2, 0), end)) for end in range(n, 0, -2)]
    found: list[Term] = [ZERO] * n
    parts: list[tuple[tuple[int, ...], list[Term], dict[int, list[Term]]]] = []
    for block in blocks:
        inverse = _inverse(m, block, names, terms)
        alone = [
            sum((inverse[p][q] * right[k] for q, k in enumerate(block)), ZERO).named(f"{names[j]}_alone")
            for p, j in enumerate(block)
        ]
        rest = range(block[0])
        lever: dict[int, list[Term]] = {}
        for i in rest:
            coupling = [m.get((i, k), ZERO) for k in block]
            lever[i] = [
                sum((c * inverse[q][p] for q, c in enumerate(coupling)), ZERO).named(f"{names[j]}_by_{names[i]}")
                for p, j in enumerate(block)
            ]
            less = sum((c * a for c, a in zip(coupling, alone, strict=True)), ZERO)
            right[i] = (right[i] - less).named(f"{names[i]}_right")
        for i in rest:
            for j in range(i, block[0]):
                less = sum((lever[i][p] * m.get((k, j), ZERO) for p, k in enumerate(block)), ZERO)
                value = (m.get((i, j), ZERO) - less).named(f"{names[i]}_{names[j]}_left")
                m |= {(i, j): value, (j, i): value}
        parts.append((block, alone, lever))
    for block, alone, lever in reversed(parts):
        for p, j in enumerate(block):
            less = sum((levers[p] * found[i] for i, levers in lever.items()), ZERO)
            found[j] = (alone[p] - less).named(f"{names[j]}_found")
    return found


def _inverse(m: Entries, block: tuple[int, ...], names: Sequence[str], terms: Terms) -> list[list[Term]]:
    if len(block) == 1:
        return [[terms.reciprocal(m[block[0], block[0]]).named(f"inverse_{names[block[0]]}")]]
    a, b = block
    one, both, other = m[a, a], m.get((a, b), ZERO), m[b, b]
    scale = terms.reciprocal(one * other - both * both).named(f"scale_{names[a]}_{names[b]}")
    couple = -(both * scale).named(f"couple_{names[a]}_{names[b]}")
    return [
        [(other * scale).named(f"inverse_{names[a]}"), couple],
        [couple, (one * scale).named(f"inverse_{names[b]}")],
    ]
