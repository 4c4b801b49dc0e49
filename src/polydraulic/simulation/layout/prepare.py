"""A machine of any layout and a step size -> the named tuples of numbers that its kernels read."""

from collections.abc import Collection
from math import exp, floor, log1p, log10
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, exact_flow
from polydraulic.machine.drives import Motor, prepare_drive
from polydraulic.machine.hose import prepare_line
from polydraulic.machine.pilot import prepare_pilot
from polydraulic.machine.play import prepare_shift
from polydraulic.machine.pump import limited_pump
from polydraulic.parameters.layout.parts import COORDINATES, Crossover, MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import MORE_STATE, has
from polydraulic.simulation.layout.module import layout_module
from polydraulic.simulation.layout.tree import tree_of
from polydraulic.simulation.steps import check_time_step


class ReadyMachine(NamedTuple):
    """A machine's kernels, and the numbers that they read."""

    module: ModuleType
    valves: Any
    plant: Any
    start: np.ndarray  # (5 n_function,) state
    n_memory: int  # floats that the flow model keeps or uses as scratch


def prepare_layout(
    machine: LayoutMachine,
    dt: float,
    locked: Collection[str] = (),
    *,
    force: bool = False,
    flow: LayoutFlow | None = None,
    in_tables: bool = False,
    continuous: bool = False,
) -> ReadyMachine:
    """Precompute all of a machine that does not change during a run.

    Parameters
    ----------
    machine : LayoutMachine
    dt : float, s
    locked : collection of str
        Functions whose joints are held.
    force : bool
        Whether a force at the tip is among the inputs.
    flow : LayoutFlow, optional
        Flow model of this machine; the exact one if not given.
    in_tables : bool
        Whether networks are wanted in tables, which leave as C, and not as compiled kernels read them.
    continuous : bool
        Whether rates are wanted, which are what a step of 1 s would change; no flow force is too large for them.

    Raises
    ------
    InputError
        If `dt` is not a positive time, or a function is locked that the machine does not have.
    """
    check_time_step(dt)
    unknown = [name for name in locked if name not in machine.names]
    if unknown:
        raise InputError(f"locked: {unknown[0]!r} is not a function of the machine; there are {list(machine.names)}")
    flow = exact_flow(machine) if flow is None else flow
    pushed = [f.name for f in machine.functions if f.effects.flow_force is not None]
    if pushed and flow.kernels == "networks":
        raise InputError(
            f"functions.{pushed[0]}.valve.flow_force: flow {flow.name!r} does not know the inlets whose jets push; use 'exact'"
        )
    module = layout_module(machine, flow=flow.kernels, force=force)
    parts = {f.name: _part(module, f, machine, dt, continuous) for f in machine.functions}
    plant = module.Plant(
        dt=dt,
        **parts,
        motion=module.prepare_motion(tree_of(machine), machine.gravity),
        locked=module.Held(*(name in locked for name in machine.names)),
        tip=module.Point(*(machine.tip[1].get(c, 0.0) for c in COORDINATES)),
    )
    valves = valves_of(machine, module, flow, in_tables=in_tables)
    return ReadyMachine(module, valves, plant, start_vector(machine), flow.n_memory)


def valves_of(machine: LayoutMachine, module: ModuleType, flow: LayoutFlow, *, in_tables: bool = False) -> Any:
    """Orifice tables, or what a flow model has in their place, and pumps."""
    tables = flow.kernels != "networks"
    parts = dict(flow.parts if in_tables else flow.running_parts)
    parts |= {f"valve_{f.name}": _tables(module, f) for f in machine.functions if tables}
    pumps = {
        f"pump_{c.name}": limited_pump(c.pump.flow, c.pump.relief, machine.tank.return_pressure, c.pump)
        for c in machine.circuits
    }
    crossovers = {f"cross_{x.name}": _crossover(module, x, machine) for x in machine.crossovers}
    return module.Valves(**parts, **pumps, **crossovers)


def start_vector(machine: LayoutMachine) -> np.ndarray:
    """State at the start: spools centred, joints at rest, positions and line pressures as in the parameter set."""
    starts = [f.initial for f in machine.functions]
    rest = [0.0] * len(starts)
    base = [*rest, *(s.p_a for s in starts), *(s.p_b for s in starts), *(s.angle for s in starts), *rest]
    more = [_begin(f, q, machine) for q, _ in MORE_STATE for f in machine.functions if has(f, q)]
    return np.array([*base, *more])


def start_from(machine: LayoutMachine, measured: np.ndarray) -> np.ndarray:
    """State of which sensors read spools, pressures at A and B, positions and rates; the rest is what effects need.

    Spools are where their pilots drive them, nothing pushes them back yet, and an actuator with play touches where its pressures push it.

    Parameters
    ----------
    machine : LayoutMachine
    measured : (5 n_function,) array, m, Pa, rad or m, rad/s or m/s
        Quantity by quantity, functions in their order.

    Returns
    -------
    (n_state,) array
        In the order of `columns_of`.
    """
    spool, p_a, p_b, *_ = measured.reshape(5, len(machine.functions)).tolist()
    more = []
    for quantity, _ in MORE_STATE:
        for f, travel, a, b in zip(machine.functions, spool, p_a, p_b, strict=True):
            if has(f, quantity):
                here = f._replace(initial=f.initial._replace(p_a=a, p_b=b))
                more.append(travel if quantity == "driven" else _begin(here, quantity, machine))
    return np.array([*measured, *more])


def _begin(f: MachineFunction, quantity: str, machine: LayoutMachine) -> float:
    """Centred spools; an actuator with play touches where its pressures push it."""
    if quantity != "gap":
        return 0.0
    drive, play = prepare_drive(f, machine.link(f.moves)), f.effects.backlash or 0.0
    area_a, area_b = (1.0, 1.0) if isinstance(drive, Motor) else (drive.area_a, drive.area_b)
    return 0.5 * play * float(np.sign(f.initial.p_a * area_a - f.initial.p_b * area_b))


def _part(module: ModuleType, f: MachineFunction, machine: LayoutMachine, dt: float, continuous: bool) -> Any:
    pilot = prepare_pilot(f.pilot, f.valve.knots[-1], dt)
    line = prepare_line(f.line, machine.tank, dt)
    drive = prepare_drive(f, machine.link(f.moves))
    more = {"half_play": 0.5 * f.effects.backlash} if f.effects.backlash is not None else {}
    more |= {"half_width": 0.5 * f.effects.hysteresis} if f.effects.hysteresis is not None else {}
    if f.effects.flow_force is not None:
        more["shift"] = prepare_shift(f.effects.flow_force) if continuous else flow_force_shift(f, machine, dt)
        more["lag"] = f.pilot.time_constant
    return getattr(module, f"Part_{f.name}")(pilot, line, drive, f.friction, f.stops, **more)


def _tables(module: ModuleType, f: MachineFunction) -> Any:
    knots = f.valve.knots
    curves = (_segments(module, curve, knots) for curve in f.valve[1:])
    return getattr(module, f"ValveTables_{len(knots)}")(*knots[1:], *curves)


def _segments(module: ModuleType, values: tuple[float, ...], knots: tuple[float, ...]) -> Any:
    n = len(knots)
    slopes = [(values[i + 1] - values[i]) / (knots[i + 1] - knots[i]) for i in range(n - 1)]
    return getattr(module, f"Segments_{n}")(*values[:-1], *slopes)


def _crossover(module: ModuleType, x: Crossover, machine: LayoutMachine) -> Any:
    knots = machine.function(machine.circuit(x.taking).functions[-1]).valve.knots
    made = getattr(module, f"Crossover_{x.name}")
    return made(_segments(module, x.valve.conductance, knots), x.valve.opening_pressure)


def flow_force_shift(f: MachineFunction, machine: LayoutMachine, dt: float) -> float:
    """Shift of a function's spool for each m3/s sqrt(Pa) of conductance times drop.

    The force of a step acts in the next one. With the shift's slope s over the travel and d = exp(-dt / time constant) an error of the
    travel becomes d - (1 - d) s times itself in a step, which keeps its sign up to s = d / (1 - d).

    Raises
    ------
    InputError
        If a force may change faster than that at the largest pressures.
    """
    shift, slope = _shift_and_slope(f, machine)
    decay = exp(-dt / f.pilot.time_constant)
    most = decay / (1.0 - decay)
    if slope > most:
        forced = [g for g in machine.functions if g.effects.flow_force is not None]
        longest = min(g.pilot.time_constant * log1p(1.0 / _shift_and_slope(g, machine)[1]) for g in forced)
        digit = 10.0 ** (floor(log10(longest)) - 1)
        raise InputError(
            f"functions.{f.name}.valve.flow_force: at the largest pressures the force shifts the spool by {slope:.3g} times its own motion, "
            f"and steps of {dt:g} s can follow {most:.3g} times with this pilot; use dt = {floor(longest / digit) * digit:.2g} s "
            "or less, which all functions can follow, or check spring_rate and the valve's curves"
        )
    return shift


def _shift_and_slope(f: MachineFunction, machine: LayoutMachine) -> tuple[float, float]:
    assert f.effects.flow_force is not None
    shift, knots = prepare_shift(f.effects.flow_force), np.array(f.valve.knots)

    def steepest(values: tuple[float, ...]) -> float:
        return float(np.abs(np.diff(values) / np.diff(knots)).max())

    outlet = max(steepest(f.valve.outlet_positive), steepest(f.valve.outlet_negative))
    relief = max(c.pump.relief for c in machine.circuits)  # circuits may be joined
    inside = relief - machine.tank.floor, f.line.relief - machine.tank.return_pressure
    return shift, shift * (steepest(f.valve.inlet) * inside[0] + outlet * inside[1]) + 1e-300
