"""Random states of machines of any layout, with all that methods for known inputs need, away from kinks."""

from typing import Any, NamedTuple

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.methods.known import sizes
from polydraulic.simulation.layout.methods.rosenbrock import step_scratch
from polydraulic.simulation.layout.methods.text import methods_module
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.tree import tree_of
from polydraulic.simulation.solvers.adaptive import Tableau


class AtRandom(NamedTuple):
    """A machine's methods, and a state: inputs and their rates, everything else, joints held, lines that are free."""

    machine: LayoutMachine
    module: Any
    valves: Any
    plant: Any
    known: np.ndarray
    known_rate: np.ndarray
    y: np.ndarray
    held: Any
    free: np.ndarray


def random_state(machine, rng, *, force=False, locked=()):
    """Joints within their stops, pressures within their bounds, spools off their knots."""
    ready, module = prepare_layout(machine, 1.0, locked, force=force), methods_module(machine, force=force)
    n = len(machine.names)
    spools = []
    for f in machine.functions:
        knots = np.array(f.valve.knots)
        place = rng.integers(len(knots) - 1)
        share = rng.uniform(0.1, 0.9)
        spools.append(rng.choice([-1.0, 1.0]) * (knots[place] + share * (knots[place + 1] - knots[place])))
    positions = [rng.uniform(max(f.stops.low, -2.0), min(f.stops.high, 2.0)) for f in machine.functions]
    most = rng.choice([0.2, 0.9])  # of the relief pressure: low enough that pumps feed what they can
    pressures = [rng.uniform(3e5, most * f.line.relief) for _ in "ab" for f in machine.functions]
    held = np.array([name in locked for name in machine.names])
    rates = rng.uniform(-0.3, 0.3, n) * ~held
    known, known_rate = np.array(spools), rng.uniform(-0.02, 0.02, n)
    if force:
        known = np.concatenate([known, rng.uniform(-1e4, 1e4, 3)])
        known_rate = np.concatenate([known_rate, rng.uniform(-1e4, 1e4, 3)])
    y = np.concatenate([pressures, positions, rates])
    free = np.where(rng.uniform(size=2 * n) < 0.1, 0.0, 1.0)
    return AtRandom(
        machine, module, ready.valves, ready.plant, known, known_rate, y, ready.module.Held(*map(bool, held)), free
    )


def rates_of(at, y=None, known=None):
    """Time derivative of the state behind the spools, and its parts."""
    f = np.empty(len(at.y))
    y, known = at.y if y is None else y, at.known if known is None else known
    r = at.module.evaluate_slow(at.valves, at.plant, at.held, at.free, known, y, f)
    return f, r


def kinks(at):
    """Which sides of kinks a state is on: which inlets and reliefs carry oil, which pumps are limited, which outlets have a drop."""
    _, r = rates_of(at)
    found = [q > 0.0 for q in r.flows.q_in] + [q > 0.0 for q in r.q_out]
    for c in at.machine.circuits:
        circuit = getattr(r.flows, f"circuit_{c.name}")
        found += [circuit.q_relief > 0.0, circuit.q_bypass > 0.0, circuit.p_pump > c.pump.torque_limit_start]
    found += [getattr(r.flows, f"cross_{x.name}") > 0.0 for x in at.machine.crossovers]
    return found


def differences(at):
    """Jacobian and drift by central differences; None where a kink is near."""
    units = 0.1 * sizes(len(at.machine.names))
    steps = 1e-4 * units * np.eye(len(at.y))
    near = [at._replace(y=at.y + side * step) for step in steps for side in (1.0, -1.0)]
    moved = [at._replace(known=at.known + side * 1e-5 * at.known_rate) for side in (1.0, -1.0)]
    if any(kinks(other) != kinks(at) for other in (*near, *moved)):
        return None
    columns = [
        (rates_of(at, at.y + step)[0] - rates_of(at, at.y - step)[0]) / (2e-4 * u)
        for step, u in zip(steps, units, strict=True)
    ]
    drift = (rates_of(moved[0])[0] - rates_of(moved[1])[0]) / 2e-5
    return np.array(columns).T, drift


def solved(at, e, right):
    """(e - J)^-1 (right + drift), through a Rosenbrock step of one stage."""
    n, h = len(at.machine.names), 1e-9
    tableau = Tableau(1.0 / (e * h), np.zeros((1, 1)), np.zeros((1, 1)), np.zeros(1), np.array([1.0 / h]))
    work = step_scratch(at.module, n, len(at.known), len(at.machine.circuits) + len(at.machine.crossovers))
    work.free[:], work.y[:] = at.free, at.y
    coefficients = np.zeros((len(at.known), 8))
    coefficients[:, 0], coefficients[:, 1] = at.known, at.known_rate
    r = at.module.evaluate_slow(at.valves, at.plant, at.held, at.free, at.known, at.y, work.f)
    work.f[:] = right
    slopes = at.module.prepare_slopes(tree_of(at.machine), at.machine.gravity)
    at.module.rosenbrock_step(at.valves, at.plant, slopes, at.held, tableau, coefficients, 0.0, 0.0, h, r, work, 1.0)
    return work.stages[0].copy()


def check_jacobian(machine, rng, n, **options):
    """The system that a step solves is that of the true Jacobian, at `n` states or more; returns at how many it was compared."""
    compared, size = 0, 0.1 * sizes(len(machine.names))
    for _ in range(n):
        at = random_state(machine, rng, **options)
        found = differences(at)
        if found is None:
            continue
        jacobian, drift = found
        still = np.concatenate([np.zeros(3 * len(at.held)), at.held]) > 0.5
        e, right = rng.choice([5.0, 250.0]), rng.normal(size=len(at.y)) * size
        right[still] = 0.0
        expected = np.linalg.solve(e * np.eye(len(at.y)) - jacobian, right + drift).reshape(4, -1)
        error = np.abs(solved(at, e, right).reshape(4, -1) - expected)
        assert (error.max(axis=1) < 1e-5 * np.abs(expected).max(axis=1)).all()  # of each quantity
        compared += 1
    return compared
