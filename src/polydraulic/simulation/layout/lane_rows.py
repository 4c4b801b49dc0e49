"""Rows of a block of machines side by side: those of a recorded step, then what the stages of a step hand on to each other."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from polydraulic.flow.lanes import LANES
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


class LaneRows(NamedTuple):
    """Numbers of rows.

    Attributes
    ----------
    groups : dict
        Row of each function, in their order, by what the rows hold.
    mass : list of int
    passed : dict
        Rows for the passes of a circuit, by its name.
    status : dict
        Row for the status of a circuit's flows, by its name.
    force : list of int
        Rows of the force at the tip, if there is one.
    steps, unsettled, met : int
        Steps made; steps whose flows are not to be trusted; whether a stop was met.
    n_row : int
    """

    groups: dict[str, list[int]]
    mass: list[int]
    passed: dict[str, list[int]]
    status: dict[str, int]
    force: list[int]
    steps: int
    unsettled: int
    met: int
    n_row: int


def lane_rows(machine: LayoutMachine, n_mass: int, n_passed: Mapping[int, int], force: bool = False) -> LaneRows:
    """Give every value a row.

    Parameters
    ----------
    machine : LayoutMachine
    n_mass : int
        Entries of the mass matrix that are not zero by structure.
    n_passed : mapping
        Numbers that a pass of a circuit hands on, by the number of its valves, where there are passes.
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
    passed = {c.name: rows(n_passed[len(c.functions)]) for c in machine.circuits if len(c.functions) in n_passed}
    status = {c.name: rows(1)[0] for c in machine.circuits}
    pushes = rows(3) if force else []
    steps, unsettled, met = rows(3)
    return LaneRows(groups, mass, passed, status, pushes, steps, unsettled, met, end)


def lane_lists(
    machine: LayoutMachine, rows: LaneRows, masses: Sequence[str], passed: Mapping[int, Sequence[str]]
) -> dict[str, Rows]:
    """Lists of the page of lanes; P, B, R and STATUS are places of rows in the flat array of a block.

    Parameters
    ----------
    machine : LayoutMachine
    rows : LaneRows
    masses : sequence of str
        Fields of the mass matrix.
    passed : mapping
        Fields of the passes of a circuit, by the number of its valves.
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
        "CROSS_ROWS": [{**row, "R": place[cross_name(str(row["G"]))] * LANES} for row in crossover_rows(machine)],
        "SHORT_CIRCUITS": [
            {"C": c.name, "N": str(len(c.functions))} for c in machine.circuits if len(c.functions) not in passed
        ],
        "LONG_CIRCUITS": [
            {"C": c.name, "N": str(len(c.functions)), "T": f"Passed{len(c.functions)}"}
            for c in machine.circuits
            if len(c.functions) in passed
        ],
    }
    lists |= {
        f"ROWS_OF_{group}": [
            {"F": f.name, "P": row * LANES}
            for f, row in zip([f for f in machine.functions if has(f, group)], of, strict=True)
        ]
        for group, of in rows.groups.items()
    }
    for c in machine.circuits:
        n = len(c.functions)
        lists[f"INLET_ROWS_OF_{c.name}"] = [
            {"I": str(k), "R": place[f"{f}.q_in"] * LANES} for k, f in enumerate(c.functions, 1)
        ]
        lists[f"WORD_ROWS_OF_{c.name}"] = [{"W": word, "R": place[f"{c.name}.{word}"] * LANES} for word, _ in CIRCUIT]
        lists[f"GAP_ROWS_OF_{c.name}"] = [
            {"I": str(k), "R": place[gap_name(c.name, k, n)] * LANES} for k in range(1, n)
        ]
        if n in passed:
            lists[f"PASSED_ROWS_OF_{c.name}"] = [
                {"X": field, "R": row * LANES} for field, row in zip(passed[n], rows.passed[c.name], strict=True)
            ]
    return lists


def _kind(group: str) -> str:
    """Name of the named tuple that a group of rows holds."""
    return group.title().replace("_", "") if group in dict(MORE_STATE) else "Functions"
