"""What an identification found, an `Identification`, in lines of text."""

from typing import Any

import numpy as np

from polydraulic.display import amount
from polydraulic.identification.equations.free_numbers import CURVES
from polydraulic.pages.text import text_table

VALVE_HEADS = ("valve", "rows", "knots", "travel seen", "q_in, of the pump", "q_out, of the pump")
WINDOW_HEADS = ("sensor", "before", "after")
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
    """Texts under `NUMBER_HEADS`: single numbers, and those of curves that were not fitted as curves."""
    before = {n.path: (n.value, n.quantity.unit) for n in found.before.numbers}
    units_now = {n.path: n.quantity.unit for n in found.machine.numbers}
    fitted = {
        f"functions.{name}.valve.{key}"
        for c in found.circuits.values()
        for name in c.valves
        for key in ("knots", *CURVES)
    }
    rows = []
    for path, new in found.changes.items():
        if path in fitted:
            continue
        many = not isinstance(new.value, float)
        values, errors = (new.value, new.uncertainty) if many else ((new.value,), (new.uncertainty,))
        for place, (value, error) in enumerate(zip(values, errors, strict=True)):
            if path not in before and not many:  # an effect that was not declared
                rows.append([path, "none", *(amount(v, units_now[path], units) for v in (value, error))])
                continue
            old, unit = before[f"{path}[{place}]" if many else path]
            if value != old or 0.0 < error < float("inf"):
                at = _at_knot(found.machine, path, place, units) if many else ""
                rows.append([path + at, *(amount(v, unit, units) for v in (old, value, error))])
    return rows


def _at_knot(machine: Any, path: str, place: int, units: str) -> str:
    """Where a number of a curve stands."""
    knots = machine.function(path.split(".")[1]).valve.knots
    return f" at {amount(knots[place], 'm', units)}"


def window_rows(found: Any, units: str) -> list[list[str]]:
    """Texts under `WINDOW_HEADS`: what is left of sensors in windows that were simulated."""
    unit = {name: found.table.unit(name) for name in found.runs.noise}
    return [
        [name, *(amount(v, unit[name], units, digits=3) for v in (found.runs.before[name], now))]
        for name, now in found.runs.noise.items()
    ]


def lines_of(found: Any, units: str) -> list[str]:
    """What was found, in lines."""
    lines = [f"identified from {found.source}, {len(found.table)} rows"]
    if found.circuits:
        lines += ["flows, of which every fifth block of time was held out to choose knots and state errors:"]
        lines += text_table(VALVE_HEADS, valve_rows(found, units))
    if found.runs is not None:
        lines += [
            f"runs of {found.runs.windows} windows of {found.runs.seconds:g} s against sensors, what is left (robust standard deviation):"
        ]
        lines += text_table(WINDOW_HEADS, window_rows(found, units))
    if numbers := number_rows(found, units):
        lines += text_table(NUMBER_HEADS, numbers)
    return [*lines, *found.remarks, *found.kept]
