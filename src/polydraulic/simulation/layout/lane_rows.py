"""Rows of a block of machines side by side: those of a recorded step, then what the stages of a step hand on to each other."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from polydraulic.flow.lanes import LANES
from polydraulic.machine.circuits.crossover.passes import JoinedPath, Joining
from polydraulic.machine.circuits.series.torque_limit import Limited
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import (
    CIRCUIT,
    FLOWS,
    MORE_STATE,
    STATE,
    columns_of,
    cross_name,
    gap_name,
    has,
)
from polydraulic.simulation.layout.expand import Rows
from polydraulic.simulation.layout.page_lists import crossover_rows

_SCRATCH = (
    "seen_in", "seen_out", "inlet", "bypass", "outlet", "voltage", "lever_a", "lever_b", "bias", "weight", "old_angle", "old_rate",
    "acceleration",
)  # fmt: skip


_LIMITED = [field for field in Limited._fields if field != "still"]
_JOINING = [field for field in Joining._fields if field != "still"]


class LaneRows(NamedTuple):
    """Numbers of rows.

    Attributes
    ----------
    groups : dict
        Row of each function, in their order, by what the rows hold.
    mass : list of int
    passed : dict
        Rows for the passes of a circuit, by its name and theirs: fields of its passes and path; r_i and rest_i of what lies behind valve i, or
        of all for 0.
    limited : list of int
        How far the flows of a circuit of one or two valves are known whose pump has a torque limit: scratch of one circuit after the other.
    joining, joined_path : list of int
        The same of circuits that a crossover joins, and what resists their flow; none without.
    still : int
        Whether they have settled.
    status : dict
        Row for the status of a circuit's flows, by its name.
    force : list of int
        Rows of the force at the tip, if there is one.
    steps, unsettled, met : int
        Steps made; steps whose flows are not to be trusted; whether a stop was met.
    outside, beyond : int
        Whether inputs are outside the domain of the flow model; steps in which they were.
    beyond_log : int
        Steps beyond the log that a machine was identified from.
    n_row : int
    """

    groups: dict[str, list[int]]
    mass: list[int]
    passed: dict[str, dict[str, int]]
    limited: list[int]
    joining: list[int]
    joined_path: list[int]
    still: int
    status: dict[str, int]
    force: list[int]
    steps: int
    unsettled: int
    met: int
    outside: int
    beyond: int
    beyond_log: int
    n_row: int


def lane_rows(
    machine: LayoutMachine, n_mass: int, passes: Mapping[int, Sequence[str]], force: bool = False
) -> LaneRows:
    """Give every value a row.

    Parameters
    ----------
    machine : LayoutMachine
    n_mass : int
        Entries of the mass matrix that are not zero by structure.
    passes : mapping
        Fields of the passes of a circuit, then of its path, by the number of its valves, where there are passes.
    force : bool
        Whether there is a force at the tip.
    """
    columns = columns_of(machine)
    quantities = [q for q, _ in (*STATE, *MORE_STATE, *FLOWS) if any(has(f, q) for f in machine.functions)]
    groups = {q: [columns.place[f"{f.name}.{q}"] for f in machine.functions if has(f, q)] for q in quantities}
    end = len(columns.columns)

    def rows(n: int) -> list[int]:
        nonlocal end
        end += n
        return list(range(end - n, end))

    groups |= {name: rows(len(machine.names)) for name in _SCRATCH}
    mass = rows(n_mass)
    passed = {}
    for c in machine.circuits:
        n = len(c.functions)
        if n in passes:
            fields = [*passes[n], *(f"{word}_{i}" for i in range(n + 1) for word in ("r", "rest"))]
            passed[c.name] = dict(zip(fields, rows(len(fields)), strict=True))
    limited, still = rows(len(_LIMITED)), rows(1)[0]
    crosses = bool(machine.crossovers)
    joining, joined_path = rows(len(_JOINING) * crosses), rows(len(JoinedPath._fields) * crosses)
    status = {c.name: rows(1)[0] for c in machine.circuits}
    pushes = rows(3) if force else []
    steps, unsettled, met, outside, beyond, beyond_log = rows(6)
    counts = (steps, unsettled, met, outside, beyond, beyond_log)
    return LaneRows(groups, mass, passed, limited, joining, joined_path, still, status, pushes, *counts, end)


def lane_lists(
    machine: LayoutMachine, rows: LaneRows, masses: Sequence[str], passes: Mapping[int, Sequence[str]]
) -> dict[str, Rows]:
    """Lists of the page of lanes; P, B, R and STATUS are places of rows in the flat array of a block.

    Parameters
    ----------
    machine : LayoutMachine
    rows : LaneRows
    masses : sequence of str
        Fields of the mass matrix.
    passes : mapping
        As for `lane_rows`.
    """
    place, names = columns_of(machine).place, machine.names
    lists: dict[str, Rows] = {
        "GROUPS": [{"G": group, "T": _kind(group)} for group in rows.groups],
        "FORCE_ROWS": [{"P": len(names) + k, "R": row * LANES} for k, row in enumerate(rows.force)],
        "MASS_ROWS": [{"M": field, "P": row * LANES} for field, row in zip(masses, rows.mass, strict=True)],
        "FUNCTION_ROWS": [
            {"F": f, "B": inlet * LANES, "P": bypass * LANES}
            for f, inlet, bypass in zip(names, rows.groups["inlet"], rows.groups["bypass"], strict=True)
        ],
        "CIRCUIT_ROWS": [
            {
                "C": c.name,
                "N": str(len(c.functions)),
                "P": place[f"{c.name}.p_pump"] * LANES,
                "STATUS": rows.status[c.name] * LANES,
            }
            for c in machine.circuits
        ],
        "LIMITED_ROWS": _numbered("X", _LIMITED, rows.limited),
        "JOINING_ROWS": _numbered("X", _JOINING, rows.joining) if rows.joining else [],
        "JOINED_PATH_ROWS": _numbered("X", JoinedPath._fields, rows.joined_path) if rows.joined_path else [],
        "CROSS_ROWS": [
            {**row, "R": place[cross_name(str(row["G"]))] * LANES, "STATUS_G": rows.status[str(row["G"])] * LANES}
            for row in crossover_rows(machine)
        ],
    }
    lists["CIRCUIT_WORD_ROWS"] = [
        {"C": c.name, "W": word, "R": place[f"{c.name}.{word}"] * LANES}
        for c in machine.circuits
        for word, _ in CIRCUIT
    ]
    lists["BETWEEN_ROWS"] = [
        {"C": c.name, "I": str(k), "R": place[gap_name(c.name, k, len(c.functions))] * LANES}
        for c in machine.circuits
        for k in range(1, len(c.functions))
    ]
    circuits = [(c, len(c.functions), {"C": c.name, "N": str(len(c.functions))}) for c in machine.circuits]
    lists["SHORT_CIRCUITS"] = [
        {**named, "STATUS": rows.status[c.name] * LANES} for c, n, named in circuits if n not in passes
    ]
    lists["LONG_CIRCUITS"] = [
        {
            **named,
            "T": f"Passed{n}",
            "U": f"Path{n}",
            "STATUS": rows.status[c.name] * LANES,
            "STILL": rows.passed[c.name]["still"] * LANES,
        }
        for c, n, named in circuits
        if n in passes
    ]
    lists |= {
        f"ROWS_OF_{group}": [
            {"F": f.name, "P": row * LANES}
            for f, row in zip([f for f in machine.functions if has(f, group)], of, strict=True)
        ]
        for group, of in rows.groups.items()
    }
    for c, n, _ in circuits:
        valves, gaps = [str(k) for k in range(1, n + 1)], [str(k) for k in range(1, n)]
        words = [word for word, _ in CIRCUIT]
        found = [
            *(place[f"{f}.q_in"] for f in c.functions),
            *(place[gap_name(c.name, k, n)] for k in range(1, n)),
            *(place[f"{c.name}.{word}"] for word in words),
        ]
        lists[f"INLET_ROWS_OF_{c.name}"] = _numbered("I", valves, found[:n])
        lists[f"GAP_ROWS_OF_{c.name}"] = _numbered("I", gaps, found[n : 2 * n - 1])
        lists[f"WORD_ROWS_OF_{c.name}"] = _numbered("W", words, found[2 * n - 1 :])
        if n in passes:
            ports = [rows.groups["seen_in"][names.index(f)] for f in c.functions]
            lists |= _pass_lists(c.name, n, rows.passed[c.name], passes[n], ports)
    return lists


def _pass_lists(
    name: str, n: int, of: Mapping[str, int], fields: Sequence[str], ports: Sequence[int]
) -> dict[str, Rows]:
    """Lists of the passes of a circuit of n valves, whose rows `of` are named; ports are rows of pressures."""

    def at(**letters: str | int) -> dict[str, str | int]:
        return {letter: (of[row] if isinstance(row, str) else row) * LANES for letter, row in letters.items()}

    def valve(i: int) -> dict[str, str | int]:
        return at(A=f"a_{i}", P=ports[i - 1], R=f"r_{i}", S=f"rest_{i}")

    def passed(i: int) -> dict[str, str | int]:
        return at(Q=f"w_{i - 1}" if i > 1 else "q_pump", W=f"w_{i}", D=f"dw_{i}") | valve(i)

    n_path, inner = 2 * n, range(1, n)
    found: dict[str, Rows] = {
        "MOVED_ROWS": _numbered("X", fields[: -n_path - 1], [of[x] for x in fields[: -n_path - 1]]),
        "PATH_ROWS": _numbered("X", fields[-n_path:], [of[x] for x in fields[-n_path:]]),
        "TANK": [at(B=f"b_{n}", R=f"r_{n}", S=f"rest_{n}")],
        "BACKWARDS": [
            {"I": str(i)} | at(W=f"w_{i}", B=f"b_{i}", X=f"r_{i}", Y=f"rest_{i}") | valve(i + 1)
            for i in reversed(inner)
        ],
        "PUMP": [at(Q="q_pump", Y="least", E="dq", V="r_0", X="rest_0") | valve(1)],
        "FIRST": [passed(1)],
        "FORWARDS": [{"I": str(i)} | passed(i) for i in inner if i > 1],
        "SETTLED": [at(Q="q_pump", E="dq", L="largest")],
        "CHANGES": [at(D=f"dw_{i}") for i in inner],
    }
    return {f"{key}_OF_{name}": rows for key, rows in found.items()}


def _numbered(letter: str, values: Sequence[str], rows: Sequence[int]) -> Rows:
    """Values of a letter, each with its row R."""
    return [{letter: value, "R": row * LANES} for value, row in zip(values, rows, strict=True)]


def _kind(group: str) -> str:
    """Name of the named tuple that a group of rows holds."""
    return group.title().replace("_", "") if group in dict(MORE_STATE) else "Functions"
