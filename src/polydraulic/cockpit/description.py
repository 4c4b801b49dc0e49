"""What a page is told of a machine once: functions, columns, drawing, pumps, patterns."""

from typing import Any

import numpy as np

from polydraulic.cockpit.cab import DT, Cab
from polydraulic.cockpit.coordination import coordinated_axes
from polydraulic.cockpit.drawn_machine import drawing_data
from polydraulic.cockpit.protocol import FRAMES
from polydraulic.cockpit.tipping import chassis_data
from polydraulic.control.lever_patterns import STICKS
from polydraulic.display import as_shown, shown_unit
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.simulation.input_check import full_lever

_DRAWN = 300  # places of a path


def machine_description(cab: Cab, shadow: str | None = None, *, study: bool = False) -> dict[str, Any]:
    """``/machine.json``: SI, with what people read next to it.

    Parameters
    ----------
    cab : Cab
    shadow : str, optional
        Flow model of its shadow.
    study : bool
        Whether a study says what is to be done.
    """
    machine, columns = cab.machine, cab.view.columns
    functions = []
    for f in machine.functions:
        joint = machine.link(f.moves).joint
        functions.append(
            {
                "name": f.name,
                "label": f.name.replace("_", " "),
                "kind": joint if f.actuator != "motor" else "motor",
                "joint": joint,
                "low": f.stops.low,
                "high": f.stops.high,
                "full": full_lever(f),
                "travel": f.valve.knots[-1],
                "position": f"{f.name}.{'position' if joint == 'prismatic' else 'angle'}",
            }
        )
    return {
        "machine": cab.name,
        "title": machine.title,
        "flow": cab.flow,
        "functions": functions,
        "columns": [{"name": c.name, "unit": c.unit} for c in columns],
        "display": {c.name: _display(c.unit) for c in columns},
        "drawing": drawing_data(layout_drawing(machine)),
        "circuits": [
            {
                "name": c.name,
                "functions": list(c.functions),
                "relief": c.pump.relief,
                "flow": c.pump.flow,
                "torque_limit": c.pump.torque_limit_start if c.pump.torque_limit_enabled else None,
            }
            for c in machine.circuits
        ],
        "crossovers": [{"name": x.name, "giving": x.giving, "taking": x.taking} for x in machine.crossovers],
        "patterns": {
            name: {
                axis.function: {
                    "axis": STICKS.index(axis.stick),
                    "sign": axis.sign,
                    "positive": axis.positive,
                    "negative": axis.negative,
                }
                for axis in pattern.axes
            }
            for name, pattern in cab.patterns.items()
        },
        "chassis": chassis_data(machine.chassis),
        "coordinated": coordinated_axes(cab.coordination, cab.uncoordinated),
        "exercises": [
            {"name": e.name, "title": e.title, "kind": e.kind, "tolerance": e.tolerance, "path": _thinned(e.path)}
            for e in cab.exercises.values()
        ],
        "faults": [{"name": fault.name, "title": fault.title} for fault in cab.faults.values()],
        "most_payload": cab.most_payload,
        "shadow": shadow is not None,
        "study": study,
        "shadow_flow": shadow,
        "rate": FRAMES,
        "dt": DT,
    }


def _thinned(path: np.ndarray) -> list[list[float]]:
    """At most so many places of a path as a line needs."""
    every = max(len(path) // _DRAWN, 1)
    found: list[list[float]] = np.round(path[::every], 4).tolist()
    return found


def _display(unit: str) -> dict[str, Any]:
    """Unit that people read, and shown = factor x + offset."""
    if unit == "W":
        return {"unit": "kW", "factor": 1e-3, "offset": 0.0}
    offset = float(as_shown(0.0, unit))
    return {"unit": shown_unit(unit), "factor": float(as_shown(1.0, unit)) - offset, "offset": offset}
