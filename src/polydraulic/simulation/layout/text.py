"""A machine's layout -> the kernels of its step, as one readable Python text.

The text follows from names, joints, which coordinates are declared, drives, numbers of knots, and circuits; no number of a parameter is
in it, so that machines that differ in numbers alone share it, and what has been compiled.
"""

from importlib.resources import files

from polydraulic.machine.circuits.series_text import IMPORTS as SERIES_IMPORTS
from polydraulic.machine.circuits.series_text import series_text
from polydraulic.machine.drives import Motor, Ram, Rocker
from polydraulic.machine.actuator import Triangle
from polydraulic.machine.tree.motion_text import MOTION_IMPORTS, motion_text
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import CIRCUIT, STATE, columns_of, gap_name
from polydraulic.simulation.layout.expand import Rows, expanded
from polydraulic.simulation.layout.tree import tree_of

_PAGES = ("values", "flow", "joints", "step", "loop")
_CLASSES = {"motor": Motor, "ram": Ram, "cylinder": Triangle, "four_bar": Rocker}
_IMPORTS = (
    "from typing import NamedTuple",
    "import numpy as np",
    "from polydraulic._kernel import driver, kernel",
    "from polydraulic.flow.interface import NOT_CONVERGED, OK",
    "from polydraulic.machine.actuator import Triangle, friction_torque",
    "from polydraulic.machine.drives import Motor, Ram, Rocker, drive_cylinder, drive_four_bar, drive_motor, drive_ram",
    "from polydraulic.machine.hose import LineStep, line_step, ports",
    "from polydraulic.machine.joints import passes_stop, turned_joint",
    "from polydraulic.machine.pilot import PilotStep, pilot_step",
    "from polydraulic.machine.pump import Circuit, Pump",
    "from polydraulic.machine.series_short import Series1, Series2, series_1, series_2",
    "from polydraulic.machine.valve import Orifices",
    "from polydraulic.parameters.schema import Friction, Stops",
    "from polydraulic.simulation.loop import FASTEST, rest_outlet",
)
UNSETTLED = 2  # status of a circuit whose flows could not be certified
DIVERGED = 4  # status of a step after which a rate is no longer reasonable


def layout_text(machine: LayoutMachine) -> str:
    """Source of the kernels of a machine's layout."""
    pages = {name: (files(__package__) / "pages" / f"{name}.py.txt").read_text(encoding="utf-8") for name in (*_PAGES, "valve")}
    lists = _lists(machine)
    lengths = sorted({len(f.valve.knots) for f in machine.functions})
    longer = sorted({len(c.functions) for c in machine.circuits if len(c.functions) > 2})
    imports = sorted(dict.fromkeys([*_IMPORTS, *MOTION_IMPORTS, *(SERIES_IMPORTS if longer else ())]))
    first, rest = pages["values"].split("\n\n\nclass State", 1)
    parts = [
        f'"""One step of a machine with the functions {", ".join(machine.names)}; written out from its layout."""',
        "\n".join(imports),
        f"UNSETTLED, DIVERGED = {UNSETTLED}, {DIVERGED}",
        expanded(first, lists),
        "Joints = Functions",
        motion_text(tree_of(machine)),
        *(series_text(n) for n in longer),
        *(expanded(pages["valve"], _knots(n), {"K": str(n), "LAST": str(n - 1)}) for n in lengths),
        expanded("class State" + rest, lists),
        *(expanded(pages[name], lists) for name in _PAGES[1:]),
    ]
    return "\n\n\n".join(part.strip() for part in parts) + "\n"


def _knots(n: int) -> dict[str, Rows]:
    def numbered(start: int, end: int) -> Rows:
        return [{"I": str(k)} for k in range(start, end)]

    return {"SEGMENTS": numbered(0, n - 1), "KNOTS": numbered(1, n), "INNER_KNOTS": numbered(1, n - 1)}


def _lists(machine: LayoutMachine) -> dict[str, Rows]:
    """The lists that pages loop over; letters: F function, J its number, C circuit, I place in it, N length, P place in a row."""
    place = columns_of(machine).place
    circuit_of = {f: (c.name, k) for c in machine.circuits for k, f in enumerate(c.functions, 1)}
    gaps = [(c.name, k, len(c.functions)) for c in machine.circuits for k in range(1, len(c.functions))]
    lists: dict[str, Rows] = {
        "FUNCTIONS": [
            {"F": f.name, "J": number, "D": f.actuator, "A": _CLASSES[f.actuator].__name__, "K": str(len(f.valve.knots)),
             "C": circuit_of[f.name][0], "I": str(circuit_of[f.name][1])}
            for number, f in enumerate(machine.functions)
        ],
        "CIRCUITS": [{"C": c.name, "N": str(len(c.functions))} for c in machine.circuits],
        "GAPS": [{"C": c, "I": str(k)} for c, k, _ in gaps],
        "QUANTITIES": [{"Q": quantity} for quantity, _ in STATE],
        "STATE_PLACES": [{"Q": q, "F": f, "P": place[f"{f}.{q}"]} for q, _ in STATE for f in machine.names],
        "INLET_PLACES": [{"F": f, "P": place[f"{f}.q_in"]} for f in machine.names],
        "OUTLET_PLACES": [{"F": f, "P": place[f"{f}.q_out"]} for f in machine.names],
        "CIRCUIT_PLACES": [{"C": c.name, "W": q, "P": place[f"{c.name}.{q}"]} for c in machine.circuits for q, _ in CIRCUIT],
        "GAP_PLACES": [{"C": c, "I": str(k), "P": place[gap_name(c, k, n)]} for c, k, n in gaps],
    }  # fmt: skip
    for c in machine.circuits:
        lists[f"FUNCTIONS_OF_{c.name}"] = [{"F": f} for f in c.functions]
    for quantity, _ in STATE:
        lists[f"PLACES_OF_{quantity}"] = [{"P": place[f"{f}.{quantity}"]} for f in machine.names]
    return lists
