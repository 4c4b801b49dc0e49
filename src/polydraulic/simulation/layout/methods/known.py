"""What methods that know the inputs in advance share: spools and forces as curves, the parts of a run, and its rows."""

from collections.abc import Callable, Iterator, Sequence
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import SimulationError
from polydraulic.flow.layout.model import LayoutFlow, exact_flow
from polydraulic.parameters.deviations import TimedFault
from polydraulic.parameters.faults import FaultyPart, faulty_parts
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.loads import DIRECTIONS
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.events import EventLog, new_log
from polydraulic.simulation.layout.columns import columns_of, has
from polydraulic.simulation.layout.methods.event_log import N_KIND, EventLimits, event_limits, listed_events
from polydraulic.simulation.layout.methods.text import methods_module, pushed_functions
from polydraulic.simulation.layout.prepare import prepare_layout, start_vector
from polydraulic.simulation.layout.tree import tree_of
from polydraulic.simulation.solvers.lagging_spools import curve_at
from polydraulic.simulation.solvers.spools import SHORTEST, KnownInput, SpoolMotion, known_force, known_motion


class KnownPart(NamedTuple):
    """Part of a run with one payload, ready to be integrated.

    Attributes
    ----------
    machine : LayoutMachine
        With its payload.
    module, step : module
        Of the methods for its layout, and of its step.
    valves, plant
        Numbers of its kernels, for dt = 1 s.
    slopes
        Numbers for slopes of the motion; None where no method that solves with slopes serves.
    motion : SpoolMotion
        Inputs of the whole run.
    start, end : float, s
    """

    machine: LayoutMachine
    module: ModuleType
    step: ModuleType
    valves: Any
    plant: Any
    slopes: Any
    motion: SpoolMotion
    start: float
    end: float


class Watch(NamedTuple):
    """Events found so far, and the flags of the conditions at the end of the last step and of this one."""

    log: EventLog
    limits: EventLimits
    had: np.ndarray
    flags: np.ndarray


class Reached(NamedTuple):
    """Where a solver has got to: rows that are filled, the state behind the spools, and why it went no further."""

    row: int
    y: np.ndarray
    failure: str = ""


# From a part, the state behind the spools at its start, the tolerance, all times and rows of the run, how many rows are filled, events, and
# counts, to which its own are added
Integrate = Callable[[KnownPart, np.ndarray, float, np.ndarray, np.ndarray, int, Watch, dict[str, int]], Reached]


class KnownRun(NamedTuple):
    """Rows of a run, what is said of it, and each part with the number of its first row and one past its last."""

    rows: np.ndarray
    info: dict[str, object]
    parts: list[tuple[KnownPart, int, int]]


def run_known(
    machine: LayoutMachine, scenario: Scenario, faults: Sequence[TimedFault], time: np.ndarray, rtol: float, method: str,
    integrate: Integrate, flow_of: Callable[[LayoutMachine], LayoutFlow] = exact_flow,
) -> KnownRun:  # fmt: skip
    """Integrate a scenario to a tolerance.

    Parameters
    ----------
    machine : LayoutMachine
        With the scenario's changes.
    scenario : Scenario
    faults : sequence of TimedFault
    time : (n_time,) array, s
        Where the solution is wanted, from 0 on.
    rtol : float
    method : str
        Name of it.
    integrate : function
    flow_of : function
        From the machine of a part, without its payload, to its flow model.

    Raises
    ------
    SimulationError
        If the run diverges, or the solver fails.
    """
    columns, n = columns_of(machine), len(machine.names)
    x0, rows, counts = start_vector(machine), np.empty((len(time), len(columns.columns))), dict[str, int]()
    n_flag = N_KIND * n + len(machine.circuits) + len(machine.crossovers)
    flags, doubtful = np.zeros((2, n_flag), dtype=np.int64), np.zeros(2, dtype=np.int64)
    watch, parts = Watch(new_log(), event_limits(machine), *flags), []
    rows[0, : columns.n_state] = x0
    row, y = 1, np.append(x0[n : 5 * n], np.zeros(len(pushed_functions(machine))))
    for part in known_parts(machine, scenario, max(float(time[-1]), SHORTEST), faults, flow_of):
        first, watch = row if part.start > 0.0 else 0, watch._replace(limits=event_limits(part.machine))
        row, y, failure = integrate(part, y, rtol, time, rows, row, watch, counts)
        if failure:
            reached = float(time[min(row, len(time) - 1)])
            raise SimulationError(f"{scenario.name} with method {method!r}: {failure} before t = {reached:g} s")
        for place, f in enumerate(machine.functions):
            if has(f, "driven"):
                there = curve_at(part.motion.starts, part.motion.driven, place, time[first:row])
                rows[first:row, columns.place[f"{f.name}.driven"]] = there
        forces = np.ascontiguousarray(scenario.loads.forces(time[first:row]))
        part.module.fill_flows(part.valves, part.plant, forces, rows[first:row], doubtful)
        parts.append((part, first, row))
    counts |= {"rows_not_converged": int(doubtful[0]), "rows_out_of_domain": int(doubtful[1])}
    return KnownRun(rows, {**counts, **listed_events(watch.log, machine, scenario.locked)}, parts)


def known_parts(
    machine: LayoutMachine, scenario: Scenario, t_end: float, faults: Sequence[TimedFault] = (),
    flow_of: Callable[[LayoutMachine], LayoutFlow] = exact_flow,
) -> Iterator[KnownPart]:  # fmt: skip
    """Parts of a run between changes of the payload and of what faults leave of the machine."""
    payload, force, parts = scenario.loads.payload, bool(scenario.loads.force), faulty_parts(machine, faults, t_end)
    loaded = payload is not None or any(part.payload for part in parts)
    masses = {0.0: 0.0} | (dict(zip(payload.time, payload.mass, strict=True)) if payload else {})
    machines = {part.begin: part for part in parts}
    times = sorted({*masses, *machines})
    motion = known_motion(known_inputs(parts, scenario), t_end, times)
    # of two corners at the same time one stays: it is where the machine changes
    begins = [float(motion.starts[np.abs(motion.starts - t).argmin()]) for t in times]
    mass, now = 0.0, parts[0]
    for t, start, end in zip(times, begins, [*begins[1:], t_end], strict=True):
        mass, now = masses.get(t, mass), machines.get(t, now)
        if end > start:
            whole = with_payload(now.machine, mass + now.payload) if loaded else now.machine
            flow = flow_of(now.machine)
            ready = prepare_layout(whole, 1.0, scenario.locked, force=force, flow=flow, continuous=True)
            module = methods_module(whole, flow=flow.kernels, force=force)
            exact = flow.kernels == "exact"
            valves = ready.valves if exact else module.Valves(ready.valves, np.zeros(flow.n_memory))
            slopes = module.prepare_slopes(tree_of(whole), whole.gravity) if hasattr(module, "prepare_slopes") else None
            yield KnownPart(whole, module, ready.module, valves, ready.plant, slopes, motion, start, end)


def known_inputs(parts: Sequence[FaultyPart], scenario: Scenario) -> list[KnownInput]:
    """Spools of all functions, then the force at the tip if the scenario has one."""
    found = []
    for place, f in enumerate(parts[0].machine.functions):
        signal = Constant() if f.name in scenario.locked else scenario.voltage.get(f.name, Constant())
        later = [(part.begin, part.machine.functions[place].pilot) for part in parts[1:]]
        lags = [
            (part.begin, 0.5 * width)
            for part in parts
            if (width := part.machine.functions[place].effects.hysteresis) is not None
        ]
        found.append(KnownInput(signal, f.pilot, f.valve.knots[-1], f.valve.knots[:-1], later, lags))
    if scenario.loads.force:
        found += [known_force(scenario.loads.force.get(direction, Constant())) for direction in DIRECTIONS]
    return found


def first_piece(motion: SpoolMotion, t: float) -> int:
    """Number of the piece of the inputs that begins at, or holds, a time."""
    last = len(motion.coefficients) - 1
    return min(max(int(np.searchsorted(motion.starts, t + 1e-12, side="right")) - 1, 0), last)


def breaks_of(part: KnownPart) -> np.ndarray:
    """Times in a part at which something in the inputs has a corner, its end the last."""
    breaks = part.motion.breaks
    inside = breaks[(breaks > part.start) & (breaks < part.end)]
    return np.append(inside, part.end)


def sizes(n: int, pushed: int = 0) -> np.ndarray:
    """Size of line pressures A and B, positions and rates of `n` functions, and of what sets spools back, which sets absolute tolerances."""
    return np.append(np.repeat([1e6, 1e6, 1.0, 1.0], n), np.full(pushed, 1e-2))
