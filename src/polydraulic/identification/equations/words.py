"""What an identification found, an `Identification`, in lines of text."""

from typing import Any

import numpy as np

from polydraulic.display import amount
from polydraulic.pages.text import text_table

VALVE_HEADS = ("valve", "rows", "knots", "travel seen", "q_in, of the pump", "q_out, of the pump")
NUMBER_HEADS = ("number", "before", "found", "standard error")


def valve_rows(found: Any, units: str) -> list[list[str]]:
    """Texts under `VALVE_HEADS`: what is left of flows on blocks of time held out."""
    rows = []
    for name, circuit in found.circuits.items():
        pump = found.machine.circuit(name).pump.flow
        for function, v in circuit.valves.items():
            left = [f"{value / pump:.2%}" if np.isfinite(value) else "-" for value in (v.q_in_left, v.q_out_left)]
            rows.append(
                [
                    function,
                    str(v.rows),
                    str(len(v.curves.knots)),
                    f"{amount(v.seen[0], 'm', units)} to {amount(v.seen[1], 'm', units)}",
                    *left,
                ]
            )
    return rows


def number_rows(found: Any, units: str) -> list[list[str]]:
    """Texts under `NUMBER_HEADS`: single numbers."""
    before = {n.path: (n.value, n.quantity.unit) for n in found.before.numbers}
    rows = []
    for path, new in found.changes.items():
        if path in before and isinstance(new.value, float) and isinstance(new.uncertainty, float):
            old, unit = before[path]
            rows.append([path, *(amount(v, unit, units) for v in (old, new.value, new.uncertainty))])
    return rows


def lines_of(found: Any, units: str) -> list[str]:
    """What was found, in lines."""
    lines = [
        f"identified from {found.source}, {len(found.table)} rows; every fifth block of time held out to choose knots and state errors:"
    ]
    if found.circuits:
        lines += text_table(VALVE_HEADS, valve_rows(found, units))
    if numbers := number_rows(found, units):
        lines += text_table(NUMBER_HEADS, numbers)
    return [*lines, *found.remarks, *found.kept]
