"""A machine of any layout and a step size -> the named tuples of numbers that its kernels read."""

from collections.abc import Collection
from math import isfinite
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, exact_layout
from polydraulic.machine.drives import prepare_drive
from polydraulic.machine.hose import prepare_line
from polydraulic.machine.pilot import prepare_pilot
from polydraulic.machine.pump import limited_pump
from polydraulic.parameters.layout.schema import COORDINATES, Crossover, LayoutMachine, MachineFunction
from polydraulic.simulation.layout.module import layout_module
from polydraulic.simulation.layout.tree import tree_of


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

    Raises
    ------
    InputError
        If `dt` is not a positive time, or a function is locked that the machine does not have.
    """
    if not (isfinite(dt) and dt > 0.0):
        raise InputError(f"dt = {dt} s: the time step must be positive and finite, for example 0.005")
    unknown = [name for name in locked if name not in machine.names]
    if unknown:
        raise InputError(f"locked: {unknown[0]!r} is not a function of the machine; there are {list(machine.names)}")
    flow = exact_layout(machine) if flow is None else flow
    module = layout_module(machine, flow=flow.kernels, force=force)
    parts = {f.name: _part(module, f, machine, dt) for f in machine.functions}
    plant = module.Plant(
        dt=dt,
        **parts,
        motion=module.prepare_motion(tree_of(machine), machine.gravity),
        locked=module.Held(*(name in locked for name in machine.names)),
        tip=module.Point(*(machine.tip[1].get(c, 0.0) for c in COORDINATES)),
    )
    return ReadyMachine(module, valves_of(machine, module, flow), plant, start_vector(machine), flow.n_memory)


def valves_of(machine: LayoutMachine, module: ModuleType, flow: LayoutFlow) -> Any:
    """Orifice tables, or what a flow model has in their place, and pumps."""
    tables = flow.kernels != "networks"
    parts = flow.parts | {f"valve_{f.name}": _tables(module, f) for f in machine.functions if tables}
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
    return np.array([*rest, *(s.p_a for s in starts), *(s.p_b for s in starts), *(s.angle for s in starts), *rest])


def _part(module: ModuleType, f: MachineFunction, machine: LayoutMachine, dt: float) -> Any:
    pilot = prepare_pilot(f.pilot, f.valve.knots[-1], dt)
    line = prepare_line(f.line, machine.tank, dt)
    drive = prepare_drive(f, machine.link(f.moves))
    return getattr(module, f"Part_{f.name}")(pilot, line, drive, f.friction, f.stops)


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
