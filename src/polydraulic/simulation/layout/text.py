"""A machine's layout -> the kernels of its step, as one readable Python text.

The text follows from names, joints, which coordinates are declared, drives, numbers of knots, and circuits; no number of a parameter is
in it, so that machines that differ in numbers alone share it, and what has been compiled.
"""

import ast
from collections.abc import Hashable, Mapping, Sequence
from functools import partial
from importlib.resources import files

from polydraulic.flow.lanes import LANES
from polydraulic.flow.layout.model import STORING
from polydraulic.flow.layout.text_module import kept_text
from polydraulic.machine.circuits.series.text import SERIES_IMPORTS, series_text
from polydraulic.machine.tree.motion_text import MOTION_IMPORTS, motion_text
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.expand import WIDTH, Rows, expanded
from polydraulic.simulation.layout.lane_rows import lane_lists, lane_rows
from polydraulic.simulation.layout.page_lists import page_lists
from polydraulic.simulation.layout.tree import function_of, tree_of

_PAGES = ("joints", "step", "loop", "points", "energy", "forces")
# pages of flows, by what circuits get
_FLOWS = {
    "exact": ("flow", "flow_exact"),
    "networks": ("flow_inputs", "flow_networks"),
    "pressure": ("flow_inputs", "flow_pressure"),
    "residual": ("flow", "flow_inputs", "flow_residual"),
    "iterative": ("flow_iterative",),
    "lookup": ("flow_lookup",),
    "stiff": ("flow_stiff",),
    "tlm": ("flow_tlm",),
}
_EXACT = ("exact", "tlm", "residual")  # that solve circuits of any length exactly, at each step or at the first
# of flows that keep nothing from step to step
_LANES = {
    "exact": ("lanes", "lanes_circuits", "crossover"),
    "networks": ("lanes", "lanes_networks"),
    "pressure": ("lanes", "lanes_networks"),
    "residual": ("lanes", "lanes_networks"),
}
_EFFECT_PAGES = {"stops": "NONE_STICKING", "stiction": "ANY_STICKING", "spools": "ANY_VALVE_EFFECT"}  # before "step"
_IMPORTS = (
    "from typing import NamedTuple",
    "import numpy as np",
    "from polydraulic._kernel import driver, kernel",
    "from polydraulic.flow.interface import NOT_CONVERGED, OK, OUT_OF_DOMAIN",
    "from polydraulic.flow.layout.network_parts import PassedNetworks, ValveNetworks, entering, leaving, network_value, or_less, root_drop",
    "from polydraulic.flow.iterative import Sweeps, iterative_1, iterative_2",
    "from polydraulic.flow.stiff import Volumes, stiff_1, stiff_2",
    "from polydraulic.flow.tlm import TlmLines, draw_onward, pump_end",
    "from polydraulic.machine.feed import Bypass, Feed, draw",
    "from polydraulic.flow.lookup import FlowTable1, FlowTable2, lookup_1, lookup_2",
    "from polydraulic.machine.actuator import Triangle, friction_torque",
    "from polydraulic.machine.circuits.crossover.nodes import CrossoverOrifice",
    "from polydraulic.machine.circuits.series.check import UNPROVED",
    "from polydraulic.machine.drives import Motor, Ram, Rocker, drive_cylinder, drive_four_bar, drive_motor, drive_ram",
    "from polydraulic.machine.hose import LineStep, line_step, ports, rest_outlet",
    "from polydraulic.machine.joints import passes_stop, turned_joint",
    "from polydraulic.machine.pilot import PilotStep, pilot_step",
    "from polydraulic.flow.lanes import LANES, at",
    "from polydraulic.machine.pump import Circuit, Pump",
    "from polydraulic.machine.circuits.series.short import series_1, series_1_at, series_1_limited, series_2, series_2_at, series_2_limited",
    "from polydraulic.machine.circuits.series.torque_limit import LIMIT_PASSES, Limited, limit_begin_1, limit_begin_2, limit_pass_1, limit_pass_2",
    "from polydraulic.simulation.lane_blocks import Kept, LaneBlock, keep_final, keep_range, keep_row",
    "from polydraulic.flow.pressure import PressureNetwork",
    "from polydraulic.flow.residual import ResidualNetwork, corrected",
    "from polydraulic.machine.valve import Orifices, orifice_flow",
    "from polydraulic.networks.model.table import NetworkTable",
    "from polydraulic.parameters.schema import Friction, Stops",
    "from polydraulic.simulation.layout.seen import goes_beyond",
    "from polydraulic.simulation.steps import DIVERGED, FASTEST",
)
_LONG_IMPORTS = ("from polydraulic.machine.circuits.series.passes import limited_power",)
_CROSS_IMPORTS = (
    "from polydraulic.machine.circuits.crossover.circuit import crossed_3, crossed_4, crossover_3, crossover_4, joined_3, joined_4, joined_bracketed",
    "from polydraulic.machine.circuits.crossover.circuit import joined_on, joined_ports_3, joined_ports_4",
    "from polydraulic.machine.circuits.crossover.check import joined_deliver, joined_end",
    "from polydraulic.machine.circuits.crossover.nodes import JoinedFlows, JoinedPumps",
    "from polydraulic.machine.circuits.crossover.passes import FEW_LANES, PACKED_PASSES, JoinedPath, Joining, joined_begin, joined_pass",
    "from polydraulic.machine.circuits.crossover.passes import joined_path",
)
_EFFECT_IMPORTS = (
    "from polydraulic.machine.actuator import dry_friction, sliding_torque, viscous_torque",
    "from polydraulic.machine.play import actuator_rate, felt_torque, followed, jet, pushed_back, taken_up",
)


def layout_text(machine: LayoutMachine, *, flow: str = "exact", force: bool = False) -> str:
    """Source of the kernels of a machine's layout; machines that differ in numbers alone have the same.

    Parameters
    ----------
    machine : LayoutMachine
    flow : str
        What circuits get; see `flow.layout.model.LayoutFlow.kernels`.
    force : bool
        Whether a force at the tip is among the inputs; without one it costs nothing.
    """
    key = layout_of(machine), flow, force
    if key not in _written:
        _written[key] = kept_text(repr(key), partial(_text, machine, flow, force))
    return _written[key]


def layout_of(machine: LayoutMachine) -> Hashable:
    """All of a machine that its text depends on."""
    links = tuple(
        (link.name, link.parent, link.joint, link.axis, link.mass > 0.0, *map(tuple, (link.at, link.cg, link.inertia)))
        for link in machine.links
    )
    functions = tuple((f.name, f.moves, f.actuator, len(f.valve.knots), f.effects.declared) for f in machine.functions)
    crossovers = tuple((x.name, x.giving, x.taking) for x in machine.crossovers)
    return links, functions, tuple((c.name, c.kind, c.functions) for c in machine.circuits), machine.tip[0], crossovers


_written: dict[Hashable, str] = {}


def _text(machine: LayoutMachine, flow: str, force: bool) -> str:
    stages = (*_FLOWS[flow], *_PAGES, *_LANES.get(flow, ()))
    pages = {
        name: (files(__package__) / "pages" / f"{name}.py.txt").read_text(encoding="utf-8")
        for name in ("values", "valve", *_EFFECT_PAGES, *stages)
    }
    tip = function_of(machine, machine.tip[0])
    motion = motion_text(tree_of(machine), points=[tip])
    lengths = sorted({len(f.valve.knots) for f in machine.functions if flow != "networks"})
    longer = sorted({len(c.functions) for c in machine.circuits if flow in _EXACT and len(c.functions) > 2})
    effects = _EFFECT_IMPORTS if any(f.effects.declared for f in machine.functions) else ()
    more = (*SERIES_IMPORTS, *_LONG_IMPORTS) if longer else ()
    crossing = _CROSS_IMPORTS if machine.crossovers else ()
    imports = joined_imports([*_IMPORTS, *MOTION_IMPORTS, *more, *crossing, *effects])
    circuits = {n: series_text(n) for n in longer}
    masses = fields_of(motion, "Mass")
    passes = {n: [*fields_of(text, f"Passed{n}"), *fields_of(text, f"Path{n}")] for n, text in circuits.items()}
    rows = lane_rows(machine, len(masses), passes, force)
    lists = page_lists(machine, tip, force, flow) | lane_lists(machine, rows, masses, passes)
    n_record = len(columns_of(machine, stores_oil=flow in STORING).columns)
    first, rest = pages["values"].split("\n\n\nclass State", 1)
    parts = [
        f'"""One step of a machine with the functions {", ".join(machine.names)}; written out from its layout."""',
        "\n".join(imports),
        f"N_FUNCTION, N_RECORD = {len(machine.names)}, {n_record}",
        f"N_ROW, STEPS_ROW, UNSETTLED_ROW, MET_ROW = {rows.n_row}, {rows.steps * LANES}, {rows.unsettled * LANES}, {rows.met * LANES}",
        f"STILL_ROW, OUTSIDE_ROW, BEYOND_ROW = {rows.still * LANES}, {rows.outside * LANES}, {rows.beyond * LANES}",
        f"BEYOND_LOG_ROW = {rows.beyond_log * LANES}",
        expanded(first, lists),
        "Joints = Functions",
        motion,
        *circuits.values(),
        *(expanded(pages["valve"], *valve_letters(n)) for n in lengths),
        expanded("class State" + rest, lists),
        *(expanded(pages[name], lists) for name in _with_effects(stages, lists)),
    ]
    return "\n\n\n".join(part.strip() for part in parts) + "\n"


def _with_effects(stages: Sequence[str], lists: Mapping[str, Rows]) -> list[str]:
    """Pages in their order, with those that the machine's effects need."""
    effects = [page for page, needed in _EFFECT_PAGES.items() if lists[needed]]
    place = stages.index("step")
    return [*stages[:place], *effects, *stages[place:]]


def valve_letters(n: int) -> tuple[dict[str, Rows], dict[str, str]]:
    """Lists and letters of a page about a valve with `n` knots."""

    def numbered(start: int, end: int) -> Rows:
        return [{"I": str(k)} for k in range(start, end)]

    lists = {"SEGMENTS": numbered(0, n - 1), "KNOTS": numbered(1, n), "INNER_KNOTS": numbered(1, n - 1)}
    return lists, {"K": str(n), "LAST": str(n - 1)}


def joined_imports(imports: Sequence[str]) -> list[str]:
    """Lines that import the same, each name once."""
    names: dict[str, set[str]] = {}
    for line in imports:
        if line.startswith("from "):
            module, _, listed = line.removeprefix("from ").partition(" import ")
            names.setdefault(module, set()).update(listed.split(", "))
    plain = sorted({line for line in imports if line.startswith("import ")})
    return [*plain, *(_import(module, sorted(of)) for module, of in sorted(names.items()))]


def _import(module: str, names: Sequence[str]) -> str:
    line = f"from {module} import {', '.join(names)}"
    return line if len(line) <= WIDTH else f"from {module} import (\n    " + ",\n    ".join(names) + ",\n)"


def fields_of(text: str, name: str) -> list[str]:
    """Fields of a named tuple that a text defines, in their order."""
    found = next(node for node in ast.parse(text).body if isinstance(node, ast.ClassDef) and node.name == name)
    return [
        node.target.id for node in found.body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    ]
