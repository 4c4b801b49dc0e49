"""Kernels of a step that says how far the machine is from tipping, as one text on top of that of the step: what is exported."""

from importlib.resources import files
from types import ModuleType
from typing import Any

from polydraulic.flow.layout.text_module import loaded
from polydraulic.machine.stability.watched import watched_room
from polydraulic.machine.stability.whole_body import body_of
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.expand import expanded
from polydraulic.simulation.layout.page_lists import page_lists
from polydraulic.simulation.layout.prepare import ReadyMachine
from polydraulic.simulation.layout.text import joined_imports
from polydraulic.simulation.layout.tree import function_of

SLOPE = ("slope.pitch", "slope.roll")  # rad, inputs
_IMPORTS = (
    "from typing import NamedTuple",
    "import numpy as np",
    "from polydraulic._kernel import kernel",
    "from polydraulic.machine.stability.body import Body",
    "from polydraulic.machine.stability.vectors import Vector",
    "from polydraulic.machine.stability.watched import calm_blows, watch",
    "from polydraulic.simulation.steps import DIVERGED",
)
_STEP = (
    "N_FUNCTION", "N_RECORD", "Force", "Plant", "State", "Valves", "acting", "at_rest", "from_vector", "machine_step", "read_force",
    "read_voltages", "reasonable", "record", "record_tip",
)  # fmt: skip


def watched_module(machine: LayoutMachine, ready: ReadyMachine, *, force: bool) -> ModuleType:
    """Module of a step with margins: ``watched_start``, ``watched_advance``.

    Parameters
    ----------
    machine : LayoutMachine
    ready : ReadyMachine
        Of it.
    force : bool
        Whether a force at the tip is among the inputs, between voltages and slope.
    """
    first = len(machine.names) + (3 if force else 0)
    page = (files(__package__) / "watched.py.txt").read_text("utf-8")
    text = [
        f'"""One step with margins against tipping of a machine with the functions {", ".join(machine.names)}; written out from its layout."""',
        "\n".join(joined_imports(_IMPORTS)),
        f"from {ready.module.__name__} import {', '.join(_STEP)}",
        f"PITCH, ROLL = {first}, {first + 1}",
        expanded(page, page_lists(machine, function_of(machine, machine.tip[0]), force)),
    ]
    return loaded("\n\n\n".join(part.strip() for part in text) + "\n")


def watched_numbers(machine: LayoutMachine, ready: ReadyMachine, module: ModuleType, start: Any) -> Any:
    """All numbers of `watched_module`; `start` is the state there as a named tuple.

    Raises
    ------
    InputError
        A machine without a chassis.
    """
    return module.Prepared(ready.valves, ready.plant, start, body_of(machine), ready.n_memory)


def n_room(machine: LayoutMachine) -> int:
    """Numbers behind those of the flow model that margins need."""
    return len(watched_room(machine))
