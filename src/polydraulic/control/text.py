"""A machine's layout -> the kernels of its coordinated controller, as one readable Python text.

It stands on the text of the step (`simulation.layout.text`), whose circuits and actuators it uses, and like that one holds no number.
"""

from collections.abc import Mapping
from importlib.resources import files
from itertools import accumulate
from types import ModuleType
from typing import Any

from polydraulic.flow.layout.text_module import loaded
from polydraulic.machine.stability.body import N_LINK
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.expand import expanded
from polydraulic.simulation.layout.page_lists import page_lists
from polydraulic.simulation.layout.text import joined_imports
from polydraulic.simulation.layout.tree import function_of
from polydraulic.simulation.stepping.packed import unpack_text

_IMPORTS = (
    "from typing import NamedTuple",
    "import numpy as np",
    "from polydraulic._kernel import driver, kernel",
    "from polydraulic.control.arm import Arm, arm_pose, arm_rates",
    "from polydraulic.control.servo import Servo, outside_band, slew_share, slewed, stop_share",
    "from polydraulic.flow.layout.network_parts import leaving, root_drop",
    "from polydraulic.machine.drives import drive_cylinder, drive_four_bar, drive_motor, drive_ram",
)
_TIPPING = (
    "from math import sqrt",
    "from polydraulic.machine.stability.body import Body, edge_of, stand",
    "from polydraulic.machine.stability.vectors import Vector",
)
_STEP = ("N_FUNCTION", "Functions", "Plant", "Valves", "flow_step", "turns")
_CONTROLLER = '''class Controller(NamedTuple):
    """All numbers that a call reads."""

    valves: Valves
    plant: Plant
    servo: Servo
    arm: Arm
    for E in GUARDED:
        body: Body
'''
INVERTED = ("exact", "networks")  # kernels of flow models whose valves are inverted
_SETTINGS = {
    "TURNS": 12,  # trials for a spool
    "CLOSE": 2e-3,  # of flow or travel: near enough
    "NEAR": 0.03,  # of full travel: how far from the last travel the next trial is
    "ENOUGH": 0.995,  # share of the wanted flow that counts as all of it
    "STILL": 2e-3,  # share of a joint's speed at full flow below which nobody moves it
    "RESERVED": 0.95,  # share of a short pump's flow that is shared out, before the servos
    "RECOVERY": 0.3,  # 1/s: how fast a share grows again
    "HIGHEST_ROOT": 1e4,  # Pa^0.5: of a pressure that no line has
    "FAR": 1e9,  # m: of an edge that no machine has
    "SWUNG": 2.0,  # largest deceleration of an arm that swings on its oil, in those of its stop
    "HALVINGS": 8,  # of the share that keeps a machine from tipping
    "REFUSED": 0.05,  # share below which motion towards a tip is refused: valves close, and the load swings itself to rest
    "RESUMED": 0.25,  # share above which it goes on
}
# arrays of one number per function in `live`; then what is of another length
_BY_FUNCTION = (
    "REFERENCE", "RATE", "TRAVEL", "SPOOL", "INTEGRAL", "LOAD", "TORQUE", "LEVER_A", "LEVER_B", "P_IN", "P_OUT", "K_OUT", "INFLOW", "RUNS",
    "WANTED", "REACHED", "SCALE", "FOUND",
)  # fmt: skip


def live_places(machine: LayoutMachine, *, guarded: bool) -> dict[str, int]:
    """Where what begins in the array that a controller changes, `guarded` against tipping or not; ``RING`` is the last."""
    n = len(machine.names)
    sizes = dict.fromkeys(_BY_FUNCTION, n) | {
        "VELOCITY": 4,
        "POSE": 4,
        "SHARE": 1,
        "FLOWING": 1,
        "STARTED": 1,
        "PLACE": 1,
        "COLUMNS": 2 * n,
    }
    if guarded:
        sizes |= {"HELD": 1, "KEPT": 1, "MOTION": 3 * n, "LINKS": N_LINK * (n + 1)}
    starts = [0, *accumulate(sizes.values())]
    return dict(zip([*sizes, "RING"], starts, strict=True))


def controller_module(machine: LayoutMachine, step: ModuleType, parts: Mapping[str, Any], kernels: str) -> ModuleType:
    """Module of a machine's controller.

    Parameters
    ----------
    machine : LayoutMachine
    step : module
        Of its kernels.
    parts : mapping from name to named tuple
        ``valves``, ``plant``, ``servo``, ``arm``, and ``body`` of one that keeps its machine from tipping; of which types alone matter.
    kernels : str
        What circuits get, one of `INVERTED`.
    """
    guarded = "body" in parts
    constants: dict[str, float] = (
        live_places(machine, guarded=guarded) | {"N_CIRCUIT": len(machine.circuits)} | _SETTINGS
    )
    lengths = sorted({len(f.valve.knots) for f in machine.functions})
    of_step = [*_STEP, *(f"orifices_{k}" for k in lengths if kernels == "exact")]
    lists = page_lists(machine, function_of(machine, machine.tip[0]), False)
    lists["GUARDED"] = [{"E": ""}] if guarded else []
    pages = [
        (files(__package__) / "pages" / f"{page}.py.txt").read_text("utf-8")
        for page in (f"outlets_{kernels}", *(["tipping"] if guarded else []), "controller")
    ]
    text = [
        f'"""Coordinated control of a machine with the functions {", ".join(machine.names)}; written out from its layout."""',
        "\n".join(joined_imports([*_IMPORTS, *(_TIPPING if guarded else ())])),
        f"from {step.__name__} import {', '.join(sorted(of_step))}",
        "\n".join(f"{name} = {value}" for name, value in constants.items()),
        unpack_text(parts),
        expanded(_CONTROLLER, lists),
        *(expanded(page, lists) for page in pages),
    ]
    return loaded("\n\n\n".join(part.strip() for part in text) + "\n")
