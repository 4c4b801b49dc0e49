"""What a page is told of a machine once: functions, columns, drawing, pumps, patterns."""

from typing import Any

from polydraulic.cockpit.cab import DT, Cab
from polydraulic.cockpit.drawn_machine import drawing_data
from polydraulic.cockpit.protocol import FRAMES
from polydraulic.display import as_shown, shown_unit
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.simulation.stepping.levers import full_lever


def machine_description(cab: Cab, name: str, flow: str) -> dict[str, Any]:
    """``/machine.json``: SI, with what people read next to it.

    Parameters
    ----------
    cab : Cab
    name : str
        Of the parameter set.
    flow : str
        Of the flow model.
    """
    machine = cab.machine
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
        "machine": name,
        "title": machine.title,
        "flow": flow,
        "functions": functions,
        "columns": [{"name": c.name, "unit": c.unit} for c in cab.columns],
        "display": {c.name: _display(c.unit) for c in cab.columns},
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
            name: {f: {"axis": axis.axis, "sign": axis.sign} for f, axis in axes.items()}
            for name, axes in cab.patterns.items()
        },
        "exercises": [],
        "faults": [],
        "shadow": False,
        "rate": FRAMES,
        "dt": DT,
    }


def _display(unit: str) -> dict[str, Any]:
    """Unit that people read, and shown = factor x + offset."""
    if unit == "W":
        return {"unit": "kW", "factor": 1e-3, "offset": 0.0}
    offset = float(as_shown(0.0, unit))
    return {"unit": shown_unit(unit), "factor": float(as_shown(1.0, unit)) - offset, "offset": offset}
