"""A run in which nothing but smooth motion happens, by each method: for orders of convergence."""

import numpy as np

from polydraulic import simulate
from polydraulic.flow import exact_flow
from polydraulic.flow.record import N_RECORD
from polydraulic.machine.plant import prepare
from polydraulic.machine.state import Links
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import LINKS
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.events import edges_of, new_log
from polydraulic.simulation.loop import run
from polydraulic.simulation.solvers.adaptive import DONE, RODAS
from polydraulic.simulation.solvers.rosenbrock import run_rosenbrock
from polydraulic.simulation.solvers.rosenbrock_step import new_work
from polydraulic.simulation.solvers.runge_kutta import run_runge_kutta
from polydraulic.simulation.solvers.spools import N_COEFFICIENT, SpoolMotion

# All valves stay on one segment of their tables after 0.8 s, and no line meets a bound: nothing but smooth motion.
VOLTS = (0.41, 0.3, 0.62)
SMOOTH = Scenario("smooth", 1.2, {link: Constant(v) for link, v in zip(LINKS, VOLTS, strict=True)})
START, LENGTH = 0.8, 0.4  # s


def angles(table):
    return np.column_stack([table[f"{link}.angle"] for link in LINKS])


def joint_errors(found, tight):
    """Largest error of each joint in degrees."""
    return np.degrees(np.abs(angles(found) - angles(tight)).max(axis=0))


def smooth_start(machine):
    """State of the smooth run at its start, from small steps."""
    begun = simulate(machine, "exact", SMOOTH, t_end=START, dt=1e-3, method="rk4")
    return np.array(
        [begun[f"{link}.{name}"][-1] for name in ("spool", "p_a", "p_b", "angle", "rate") for link in LINKS]
    )


def end_by_runge_kutta(machine, x0, n):
    tau = Links(*(getattr(machine, link).pilot.time_constant for link in LINKS))
    rows, voltage = np.empty((2, N_RECORD)), np.tile(VOLTS, (2 * n + 1, 1))
    counts, plant = np.zeros(2, dtype=np.int64), prepare(machine, 1.0)
    made = run_runge_kutta(exact_flow(machine), np.zeros(1), plant, tau, LENGTH / n, x0, voltage, n, rows, counts)
    assert made == n
    return rows[1, :15]


def end_by_the_loop(machine, x0, n):
    rows, counts = np.empty((2, N_RECORD)), np.zeros(2, dtype=np.int64)
    plant = prepare(machine, LENGTH / n)
    assert run(exact_flow(machine), np.zeros(1), plant, x0, np.tile(VOLTS, (n, 1)), n, rows, counts) == n
    return rows[1, :15]


def end_by_rosenbrock(machine, x0, rtol):
    """Spools fading from where they are to their commands, in closed form."""
    c = np.zeros((1, 3, N_COEFFICIENT))
    for link, name in enumerate(LINKS):
        pilot = getattr(machine, name).pilot
        target = pilot.gain * VOLTS[link]
        c[0, link, 0], c[0, link, 2], c[0, link, 7] = target, x0[link] - target, 1.0 / pilot.time_constant
    motion = SpoolMotion(np.array([0.0, LENGTH]), c, np.array([LENGTH]))
    rows, counts = np.empty((2, N_RECORD)), np.zeros(4, dtype=np.int64)
    status = run_rosenbrock(
        exact_flow(machine), np.zeros(1), prepare(machine, 1.0), RODAS, motion, x0, rtol, np.array([0.0, LENGTH]),
        rows, counts, new_log(), edges_of(machine), new_work(RODAS),
    )  # fmt: skip
    assert status == DONE
    return rows[1, :15], int(counts[0])


def order(end, truth, numbers):
    errors = [np.abs(end(n)[9:] - truth[9:]).max() for n in numbers]
    return -np.polyfit(np.log(numbers), np.log(errors), 1)[0]
