"""A machine's layout -> its equations in continuous time, and the methods that integrate them, as one readable Python text.

It stands on the text of the step (`simulation.layout.text`), whose kernels it imports, and like that one holds no number.
"""

from collections.abc import Hashable
from importlib.resources import files
from types import ModuleType

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.expand import Rows, expanded
from polydraulic.simulation.layout.module import layout_module, loaded
from polydraulic.simulation.layout.page_lists import page_lists
from polydraulic.simulation.layout.text import layout_of
from polydraulic.simulation.layout.tree import function_of

_PAGES = ("right_hand_side", "runge_kutta", "slow", "switching")
_IMPORTS = """from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.flow.interface import NOT_CONVERGED
from polydraulic.machine.pilot import spool_target
from polydraulic.simulation.solvers.line_rates import held_back, line_changes, line_moves, line_rates, within_bounds
from polydraulic.simulation.solvers.stop_conditions import BLINK, CREEP, between_stops, joint_changes, rests, stands, strikes"""
_SLOW = ("p_a", "p_b", "angle", "rate")  # all of a state that is integrated: spools are known
# of the text of the step
_STEP = (
    "N_FUNCTION", "Flows", "Force", "Functions", "Held", "JointsAfter", "Plant", "Position", "State", "Step", "Valves", "exact_step",
    "from_vector", "net_torque", "position", "pushed", "read_force", "read_voltages", "reasonable", "record", "seen_pressures",
    "solve_motion", "stopped", "times",
)  # fmt: skip


def methods_module(machine: LayoutMachine, *, force: bool = False) -> ModuleType:
    """Module of the methods for a machine's layout, with a force at the tip or without; see `methods_text`."""
    return loaded(methods_text(machine, force=force))


def methods_text(machine: LayoutMachine, *, force: bool = False) -> str:
    """Source of the methods for a machine's layout; machines that differ in numbers alone have the same.

    Parameters
    ----------
    machine : LayoutMachine
    force : bool
        Whether a force at the tip is among the inputs.
    """
    key = layout_of(machine), force
    if key not in _written:
        _written[key] = _text(machine, force)
    return _written[key]


_written: dict[Hashable, str] = {}


def _text(machine: LayoutMachine, force: bool) -> str:
    step = layout_module(machine, force=force).__name__
    lists = page_lists(machine, function_of(machine, machine.tip[0]), force) | _lists(machine)
    pages = [(files(__package__) / "pages" / f"{name}.py.txt").read_text(encoding="utf-8") for name in _PAGES]
    parts = [
        f'"""A machine with the functions {", ".join(machine.names)} in continuous time; written out from its layout."""',
        f"{_IMPORTS}\nfrom {step} import (\n" + "".join(f"    {name},\n" for name in sorted(_STEP)) + ")",
        *(expanded(page, lists) for page in pages),
    ]
    return "\n\n\n".join(part.strip() for part in parts) + "\n"


def _lists(machine: LayoutMachine) -> dict[str, Rows]:
    """Lists of these pages: places of quantities in a vector of all but the spools, of flows over relief valves."""
    names, n = machine.names, len(machine.names)
    slow = {q: range(k * n, (k + 1) * n) for k, q in enumerate(_SLOW)}
    lists: dict[str, Rows] = {
        "SLOW_QUANTITIES": [{"Q": q} for q in _SLOW],
        "SLOW_PLACES": [{"Q": q, "F": f, "P": p} for q in _SLOW for f, p in zip(names, slow[q], strict=True)],
        "LINE_PLACES": [{"Q": q, "F": f, "P": p} for q in _SLOW[:2] for f, p in zip(names, slow[q], strict=True)],
        "ANGLE_PLACES": [{"F": f, "P": p, "R": r} for f, p, r in zip(names, slow["angle"], slow["rate"], strict=True)],
        "RELIEFS": [{"C": c.name, "P": k} for k, c in enumerate(machine.circuits)],
    }
    lists |= {f"SLOW_PLACES_OF_{q}": [{"P": p} for p in slow[q]] for q in _SLOW}
    return lists
