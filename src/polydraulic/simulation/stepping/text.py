"""A machine's layout -> the drivers that move it step by step, as one readable Python text.

It stands on the text of the step (`simulation.layout.text`), whose kernels it imports, and like that one holds no number.
"""

from collections.abc import Mapping, Sequence
from importlib.resources import files
from types import ModuleType
from typing import Any, NamedTuple

from polydraulic.flow.lanes import LANES
from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.flow.layout.text_module import loaded
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import columns_of, cross_name
from polydraulic.simulation.layout.expand import Rows, expanded
from polydraulic.simulation.layout.methods.event_log import N_KIND
from polydraulic.simulation.layout.page_lists import page_lists
from polydraulic.simulation.layout.text import joined_imports
from polydraulic.simulation.layout.tree import function_of
from polydraulic.simulation.stepping.packed import unpack_text

_IMPORTS = (
    "import numpy as np",
    "from polydraulic._kernel import driver, kernel",
    "from polydraulic.flow.interface import NOT_CONVERGED, OUT_OF_DOMAIN",
    "from polydraulic.simulation.layout.methods.event_log import fill_flags",
    "from polydraulic.simulation.layout.seen import goes_beyond",
    "from polydraulic.simulation.stepping.marks import BEYOND, CHANGES, DONE, FLAGS, LOST, NOTED, OUTSIDE, REFUSED, STATUS, STEPS, STOP, UNSETTLED, WHICH",
)
# of the text of the step
_STEP = (
    "N_FUNCTION", "N_RECORD", "State", "at_rest", "from_vector", "machine_step", "read_force", "read_voltages", "reasonable",
    "record", "record_tip", "seen_pressures",
)  # fmt: skip
_LANE_IMPORTS = (
    "import numpy as np",
    "from polydraulic._kernel import driver, kernel",
    "from polydraulic.flow.lanes import LANES, at",
    "from polydraulic.simulation.lane_blocks import LaneBlock",
    "from polydraulic.simulation.stepping.marks import Again, Levered",
)
_LANES = (
    "BEYOND_LOG_ROW", "BEYOND_ROW", "N_FUNCTION", "OUTSIDE_ROW", "STEPS_ROW", "UNSETTLED_ROW", "Functions", "flow_stage", "get_angle",
    "get_rate", "hose_stage", "input_stage", "lane_beyond", "motion_stage", "outlet_stage", "pilot_stage", "position_stage", "put_angle", "put_rate", "reasonable", "see_stage", "stop_stage", "turns",
)  # fmt: skip
# of a block, behind those of the step and its scratch: whether a machine has not diverged, place of its tip
MORE_ROWS = 4
PORTS = ("p_in", "p_out")


class Places(NamedTuple):
    """Where what begins in the array of a machine: first its recorded row, the tip's place and the pressures at ports.

    Attributes
    ----------
    n_record, n_out : int
        Columns that runs record, and with tip and ports.
    given, taken : int
        Levers, then the force; what of them reaches the machine in a step.
    before : int
        The recorded row of the step before.
    opened : int
        Flows over relief valves and through crossovers.
    memory : int
        What the flow model keeps, or uses as scratch.
    n_flag : int
        Conditions of events.
    """

    n_record: int
    n_out: int
    given: int
    taken: int
    before: int
    opened: int
    memory: int
    n_flag: int


def places_of(machine: LayoutMachine, *, force: bool, stores_oil: bool = False) -> Places:
    """Places in the array of a machine, with a force at the tip or without, of a flow model that follows oil before the valves or does not."""
    n, n_record = len(machine.names), len(columns_of(machine, stores_oil=stores_oil).columns)
    n_input, watched = n + (3 if force else 0), len(machine.circuits) + len(machine.crossovers)
    n_out = n_record + 3 + len(PORTS) * n
    taken = n_out + n_input
    before = taken + n_input
    opened = before + n_record
    return Places(n_record, n_out, n_out, taken, before, opened, opened + watched, N_KIND * n + watched)


def single_module(
    machine: LayoutMachine, step: ModuleType, parts: Mapping[str, Any], *, force: bool, stores_oil: bool = False
) -> ModuleType:
    """Module of the drivers of a single machine.

    Parameters
    ----------
    machine : LayoutMachine
    step : module
        Of its kernels.
    parts : mapping from name to named tuple
        ``valves``, ``plant`` and ``hand``, of which types alone matter.
    force : bool
        Whether a force at the tip is among the inputs.
    stores_oil : bool
        Whether the flow model follows oil before the valves, and records it.
    """
    at = places_of(machine, force=force, stores_oil=stores_oil)
    constants = {"N_OUT": at.n_out, "GIVEN": at.given, "TAKEN": at.taken, "BEFORE": at.before, "OPENED": at.opened}
    constants |= {"MEMORY": at.memory, "N_FLAG": at.n_flag, "N_INPUT": at.taken - at.given}
    return loaded(_text(machine, step, parts, constants, "single", _IMPORTS, _STEP, _lists(machine, stores_oil)))


def lanes_module(
    machine: LayoutMachine, step: ModuleType, parts: Mapping[str, Any], *, force: bool, flow: LayoutFlow
) -> ModuleType:
    """Module of the driver of many machines side by side; arguments as for `single_module`, parts are ``valves`` and ``plant``."""
    tip, whole = function_of(machine, machine.tip[0]), rows_before(step, flow)
    constants = {"WHOLE_ROW": whole * LANES, "TIP_ROW": (whole + 1) * LANES}
    of_step = (*_LANES, f"place_{tip}")
    lists = page_lists(machine, tip, force, flow.kernels)
    return loaded(_text(machine, step, parts, constants, "lanes", _LANE_IMPORTS, of_step, lists))


def rows_before(step: ModuleType, flow: LayoutFlow) -> int:
    """Rows of a block before those that no step knows: its own, and its scratch."""
    return int(step.N_ROW) + -(-flow.n_memory // LANES)


def _text(
    machine: LayoutMachine, step: ModuleType, parts: Mapping[str, Any], constants: Mapping[str, int], page: str,
    imports: Sequence[str], of_step: Sequence[str], lists: Mapping[str, Rows],
) -> str:  # fmt: skip
    source = (files(__package__) / "pages" / f"{page}.py.txt").read_text("utf-8")
    text = [
        f'"""A machine with the functions {", ".join(machine.names)}, moved step by step; written out from its layout."""',
        "\n".join(joined_imports(imports)),
        f"from {step.__name__} import {', '.join(sorted(of_step))}",
        f"{', '.join(constants)} = {', '.join(map(str, constants.values()))}",
        unpack_text(parts),
        expanded(source, lists),
    ]
    return "\n\n\n".join(part.strip() for part in text) + "\n"


def _lists(machine: LayoutMachine, stores_oil: bool) -> dict[str, Rows]:
    """Lists of the pages: F function, J its number; K number of a flow that is watched; P and R places in a row."""
    n, columns = len(machine.names), columns_of(machine, stores_oil=stores_oil)
    first = len(columns.columns) + 3
    watched = [*(f"{c.name}.q_relief" for c in machine.circuits), *(cross_name(x.giving) for x in machine.crossovers)]
    return {
        "PORTS": [{"F": f, "P": first + j, "R": first + n + j} for j, f in enumerate(machine.names)],
        "WATCHED": [{"K": k, "P": columns.place[name]} for k, name in enumerate(watched)],
    }
