"""A machine's layout -> its equations in continuous time, and the methods that integrate them, as one readable Python text.

It stands on the text of the step (`simulation.layout.text`), whose kernels it imports, and like that one holds no number.
"""

from collections.abc import Hashable, Sequence
from importlib.resources import files
from types import ModuleType

from polydraulic.flow.layout.text_module import loaded
from polydraulic.machine.circuits.series.slopes_text import SERIES_SLOPES_IMPORTS, series_slopes_text
from polydraulic.machine.tree.equations import entry_name
from polydraulic.machine.tree.motion_slopes_text import MOTION_SLOPES_IMPORTS, motion_slopes_text
from polydraulic.parameters.layout.parts import Crossover, MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.expand import Rows, expanded
from polydraulic.simulation.layout.module import layout_module
from polydraulic.simulation.layout.page_lists import crossover_rows, page_lists
from polydraulic.simulation.layout.text import fields_of, joined_imports, layout_of, layout_text, valve_letters
from polydraulic.simulation.layout.tree import function_of, tree_of

_PAGES = ("right_hand_side", "runge_kutta")
# of methods that know the inputs in advance; of those that solve with slopes besides, which ask for exact circuits
_KNOWN_PAGES, _KNOWN_EFFECTS = ("slow", "switching"), {"valve.hysteresis", "valve.flow_force"}
_SLOPE_PAGES, _SLOPE_EFFECTS = ("jacobian", "rosenbrock"), {"valve.hysteresis"}
_IMPORTS = (
    "from math import sqrt",
    "from typing import NamedTuple",
    "import numpy as np",
    "from polydraulic._kernel import driver, kernel",
    "from polydraulic.flow.interface import NOT_CONVERGED, OK, OUT_OF_DOMAIN",
    "from polydraulic.machine.actuator import friction_slope",
    "from polydraulic.machine.circuits.series.short_slopes import Slopes1, Slopes2, series_1_slopes, series_2_slopes",
    "from polydraulic.machine.drives import drive_cylinder_slopes, drive_four_bar_slopes, drive_motor_slopes, drive_ram_slopes",
    "from polydraulic.machine.pilot import spool_target",
    "from polydraulic.machine.circuits.series.short import Series1, Series2",
    "from polydraulic.machine.valve import Orifices",
    "from polydraulic.simulation.events import EventLog",
    "from polydraulic.simulation.layout.methods.event_log import EventLimits, fill_flags, observe_flags",
    "from polydraulic.simulation.solvers.adaptive import DONE, MANY_AT_ONCE, MAX_STEPS, SMALLEST_STEP, TOO_FAST, TOO_MANY, TOO_SMALL",
    "from polydraulic.simulation.solvers.adaptive import Tableau",
    "from polydraulic.simulation.solvers.line_rates import held_back, line_changes, line_moves, line_rates, within_bounds",
    "from polydraulic.simulation.solvers.line_slopes import EliminatedOutlet, Hoses, eliminate_outlet, hoses_at, line_sides",
    "from polydraulic.simulation.solvers.line_slopes import outlet_change, outlet_root, torque_change",
    "from polydraulic.simulation.solvers.small_system import factorise_system, solve_system",
    "from polydraulic.simulation.solvers.spool_curves import along_curve, curve_of",
    "from polydraulic.simulation.solvers.spools import SpoolMotion, inputs_at",
    "from polydraulic.simulation.solvers.stop_conditions import BLINK, CREEP, between_stops, joint_changes, rests, stands, strikes",
)
_CROSSED_IMPORTS = (
    "from polydraulic.machine.circuits.crossover.circuit import Crossed3, Crossed4",
    "from polydraulic.machine.circuits.crossover.slopes import CrossedSlopes3, CrossedSlopes4, crossover_3_slopes, crossover_4_slopes",
)
_SLOW = ("p_a", "p_b", "angle", "rate")  # all of a state that is integrated: spools are known
# of the text of the step
_STEP = (
    "N_FUNCTION", "Flows", "Force", "Functions", "Held", "JointsAfter", "Plant", "Position", "Ports", "State", "Step",
    "from_vector", "net_torque", "position", "pushed", "read_force", "read_voltages", "reasonable", "record", "seen_pressures",
    "solve_motion", "stopped", "times", "turns",
)  # fmt: skip
# where a flow model takes the place of exact circuits
_MODELLED_STEP = ("Valves as ModelValves", "flow_step")
# where spools have hysteresis, and flow forces
_FOLLOWED = ("from polydraulic.machine.play import followed",)
_DRIVEN_STEP, _SHIFTED_STEP = ("Driven",), ("FlowShift", "flow_shifts", "inlets")


def methods_module(machine: LayoutMachine, *, flow: str = "exact", force: bool = False) -> ModuleType:
    """Module of the methods for a machine's layout, with a force at the tip or without; see `methods_text`."""
    return loaded(methods_text(machine, flow=flow, force=force))


def methods_text(machine: LayoutMachine, *, flow: str = "exact", force: bool = False) -> str:
    """Source of the methods for a machine's layout; machines that differ in numbers alone have the same.

    Parameters
    ----------
    machine : LayoutMachine
    flow : str
        What circuits get, exact or one of `flow.layout.model.FORGETTING`.
    force : bool
        Whether a force at the tip is among the inputs.
    """
    key = layout_of(machine), flow, force
    if key not in _written:
        _written[key] = _text(machine, flow, force)
    return _written[key]


_written: dict[Hashable, str] = {}


def _text(machine: LayoutMachine, flow: str, force: bool) -> str:
    step, tip = layout_text(machine, flow=flow, force=force), function_of(machine, machine.tip[0])
    lists = page_lists(machine, tip, force, flow) | _lists(machine, fields_of(step, "Mass"))
    exact = flow == "exact"
    lists |= {"EXACT": [{"E": ""}] if exact else [], "MODELLED": [] if exact else [{"E": ""}]}
    imports = [*_IMPORTS, *(_FOLLOWED if lists["ANY_DRIVEN"] else ())]
    of_step = [*_STEP, *(("Valves", "exact_step") if exact else _MODELLED_STEP)]
    of_step += [*(_DRIVEN_STEP if lists["ANY_DRIVEN"] else ()), *(_SHIFTED_STEP if lists["ANY_SHIFTED"] else ())]
    pages = [expanded(_page(name), lists) for name in _PAGES]
    declared = {key for f in machine.functions for key in f.effects.declared}
    if declared <= _KNOWN_EFFECTS:
        pushed = sorted({len(f.valve.knots) for f in pushed_functions(machine)})
        of_step += [f"ValveTables_{n}" for n in pushed]
        pages += [expanded(_page("valve_segments"), *valve_letters(n)) for n in pushed]
        pages += [expanded(_page(name), lists) for name in _KNOWN_PAGES]
    if exact and declared <= _SLOPE_EFFECTS:
        lengths = sorted({len(f.valve.knots) for f in machine.functions})
        longer = sorted({len(c.functions) for c in machine.circuits if len(c.functions) > 2})
        imports += [*MOTION_SLOPES_IMPORTS, *(SERIES_SLOPES_IMPORTS if longer else ())]
        imports += _CROSSED_IMPORTS if machine.crossovers else ()
        of_step += [f"{name}_{n}" for n in lengths for name in ("Segments", "ValveTables", "orifices")]
        of_step += [f"Series{n}" for n in longer]
        of_step += sorted({f"opened_{row['K']}" for row in crossover_rows(machine)})
        pages += [
            motion_slopes_text(tree_of(machine), tip if force else None),
            *(series_slopes_text(n) for n in longer),
            *(expanded(_page("valve_slopes"), *valve_letters(n)) for n in lengths),
            *(expanded(_page(name), lists) for name in _SLOPE_PAGES),
        ]
    parts = [
        f'"""A machine with the functions {", ".join(machine.names)} in continuous time; written out from its layout."""',
        "\n".join(joined_imports(imports)),
        f"from {layout_module(machine, flow=flow, force=force).__name__} import (\n    "
        + ",\n    ".join(sorted(of_step))
        + ",\n)",
        f"N_SLOW = {len(_SLOW) * len(machine.names) + len(lists['SETBACKS'])}",
        *pages,
    ]
    return "\n\n\n".join(part.strip() for part in parts) + "\n"


def pushed_functions(machine: LayoutMachine) -> list[MachineFunction]:
    """Functions whose spools flow forces push: what they are set back by stands behind the rest of a state."""
    return [f for f in machine.functions if f.effects.flow_force is not None]


def _joined(machine: LayoutMachine, x: Crossover) -> tuple[str, ...]:
    """Functions of both circuits that a crossover joins, the giving one's first."""
    return (*machine.circuit(x.giving).functions, *machine.circuit(x.taking).functions)


def _page(name: str) -> str:
    return (files(__package__) / "pages" / f"{name}.py.txt").read_text(encoding="utf-8")


def _lists(machine: LayoutMachine, masses: Sequence[str]) -> dict[str, Rows]:
    """Lists of these pages; P and R are places in a vector of all but the spools, or in a matrix of inlet pressures and rates.

    Parameters
    ----------
    machine : LayoutMachine
    masses : sequence of str
        Fields of the mass matrix.
    """
    names, n = machine.names, len(machine.names)
    slow = {q: range(k * n, (k + 1) * n) for k, q in enumerate(_SLOW)}
    by_field = {entry_name(i, j, n): (i, j) for i in range(n) for j in range(i, n)}
    entries = [(field, *by_field[field]) for field in masses]
    both = [*entries, *((field, j, i) for field, i, j in entries if i != j)]
    joined = {x.name: _joined(machine, x) for x in machine.crossovers}
    plain = {c.name: c.functions for c in machine.circuits if c.kind != "crossover"}
    fed = [(supply, f, k) for supply, of in (plain | joined).items() for k, f in enumerate(of, 1)]
    pairs: list[dict[str, str | int]] = [
        {"C": c, "F": f, "G": g, "I": str(k), "O": str(m), "P": names.index(f), "R": names.index(g)}
        for c, f, k in fed
        for other, g, m in fed
        if c == other
    ]
    lists: dict[str, Rows] = {
        "SLOW_QUANTITIES": [{"Q": q} for q in _SLOW],
        "SLOW_PLACES": [{"Q": q, "F": f, "P": p} for q in _SLOW for f, p in zip(names, slow[q], strict=True)],
        "LINE_PLACES": [{"Q": q, "F": f, "P": p} for q in _SLOW[:2] for f, p in zip(names, slow[q], strict=True)],
        "SETBACKS": [
            {"F": f.name, "P": 4 * n + k, "J": names.index(f.name)} for k, f in enumerate(pushed_functions(machine))
        ],
        "LINE_PAIRS": [{"F": f, "P": k, "R": n + k} for k, f in enumerate(names)],
        "ANGLE_PLACES": [{"F": f, "P": 2 * n + k, "R": 3 * n + k} for k, f in enumerate(names)],
        "RELIEFS": [{"C": c.name, "P": k} for k, c in enumerate(machine.circuits)],
        "CROSSINGS": [{"X": x.name, "P": k} for k, x in enumerate(machine.crossovers, len(machine.circuits))],
        "OPENINGS": [
            *({"O": c.name} for c in machine.circuits),
            *({"O": f"cross_{x.name}"} for x in machine.crossovers),
        ],
        "SUPPLIES": [
            *({"C": c, "S": f"Slopes{len(of)}"} for c, of in plain.items()),
            *({"C": x, "S": f"CrossedSlopes{len(of)}"} for x, of in joined.items()),
        ],
        "SLOPES": [{"C": c, "N": str(len(of)), "V": f"Series{len(of)}"} for c, of in plain.items()],
        "CROSSED_SLOPES": [
            {**row, "V": f"Crossed{row['N']}", "L": f"Series{len(machine.circuit(str(row['G'])).functions)}"}
            for row in crossover_rows(machine)
        ],
        "FED": [{"C": c, "F": f, "I": str(k)} for c, f, k in fed],
        "PAIRS": pairs,
        "OTHERS": [pair for pair in pairs if pair["F"] != pair["G"]],
        "ROWS": [{"F": f, "P": k, "R": n + k} for k, f in enumerate(names)],
        "MASS_PLACES": [{"M": field, "P": n + i, "R": n + j} for field, i, j in both],
        "MOTION_PAIRS": [{"F": f, "G": g, "J": i, "I": j} for i, f in enumerate(names) for j, g in enumerate(names)],
    }
    lists |= {f"SLOW_PLACES_OF_{q}": [{"P": p} for p in slow[q]] for q in _SLOW}
    for c in machine.circuits:
        knots = {f: len(machine.function(f).valve.knots) for f in c.functions}
        lists[f"VALVES_OF_{c.name}"] = [{"F": f, "K": str(k)} for f, k in knots.items()]
        lists[f"GAPS_OF_{c.name}"] = [{"I": str(k)} for k in range(1, len(c.functions))]
    return lists
