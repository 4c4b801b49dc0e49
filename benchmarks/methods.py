"""The Rosenbrock method next to the semi-implicit loop at equal accuracy, on every machine that comes with the package.

``python benchmarks/methods.py`` prints and asserts nothing. All machines do the work of the same random operator, who is known in advance; states
come out every 5 ms. Errors are against the reference solution: the largest joint error as a share of the joint's travel in
the run, and the largest rms error of a line pressure as a share of its range. Of each method the cheapest setting counts that keeps both below
the goal; times are those of the compiled loops, without naming columns, with the Rosenbrock method's preparation in Python.
"""

import time

import numpy as np

from polydraulic import load_machine
from polydraulic.flow import exact_flow
from polydraulic.parameters.load import function_names, machine_names
from polydraulic.parameters.scenario import random_operator
from polydraulic.parameters.schema import LINKS
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.methods import lsoda as layout_lsoda
from polydraulic.simulation.layout.methods import rosenbrock as layout_rosenbrock
from polydraulic.simulation.layout.methods.known import run_known
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.simulation.loop import run
from polydraulic.simulation.runs import arrange
from polydraulic.simulation.solvers import lsoda, rosenbrock
from polydraulic.thesis.timing import paired_times

RASTER, SECONDS = 5e-3, 20.0
JOINT_GOAL, PRESSURE_GOAL = 0.1, 0.5  # %
STEPS = (5e-3, 2.5e-3, 1.25e-3, 0.625e-3, 0.3125e-3)  # s
TOLERANCES = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
TIME = np.arange(round(SECONDS / RASTER) + 1) * RASTER


def older_calls(machine, scenario):
    """Runs of cat215b, whose methods are written by hand: of a step, of a tolerance, and the reference."""
    model = exact_flow(machine)

    def loop(dt):
        arranged = arrange(machine, model, scenario, dt=dt, every=round(RASTER / dt))
        return lambda: (run(*arranged), arranged.rows)[1]

    return (
        loop,
        lambda rtol: lambda: rosenbrock.integrate(machine, model, scenario, TIME, rtol)[0],
        lambda: lsoda.integrate(machine, model, scenario, TIME, 1e-9)[0],
    )


def layout_calls(machine, scenario):
    """The same of a machine of any layout."""

    def loop(dt):
        n = round(SECONDS / dt)
        ready, inputs = prepare_layout(machine, dt), step_inputs(machine, scenario, np.arange(n) * dt)
        rows, counts = np.empty((len(TIME), len(columns_of(machine).columns))), np.zeros(2, dtype=np.int64)
        arguments = (ready.valves, ready.plant, ready.start, inputs, round(RASTER / dt), rows, counts)
        return lambda: (ready.module.run(*arguments), rows)[1]

    def known(rtol, method):
        return run_known(machine, scenario, TIME, rtol, method.__name__, method.integrate).rows

    return loop, lambda rtol: lambda: known(rtol, layout_rosenbrock), lambda: known(1e-9, layout_lsoda)


def errors(rows, truth, n):
    """Largest joint error and largest pressure error in percent; a row begins with spools, pressures A and B, and positions."""
    off = rows[:, : 4 * n] - truth[:, : 4 * n]
    joints = np.abs(off[:, 3 * n :]).max(axis=0) / np.ptp(truth[:, 3 * n : 4 * n], axis=0)
    pressures = np.sqrt((off[:, n : 3 * n] ** 2).mean(axis=0)) / np.ptp(truth[:, n : 3 * n], axis=0)
    return 100.0 * joints.max(), 100.0 * pressures.max()


def cheapest(settings, call_of, truth, n):
    """The first setting that meets the goal, its call and its errors; the last one where none does."""
    for setting in settings:
        call = call_of(setting)
        off = errors(call(), truth, n)
        if off[0] <= JOINT_GOAL and off[1] <= PRESSURE_GOAL:
            break
    return setting, call, off


def main():
    begun = time.perf_counter()
    print(
        f"{SECONDS:g} s of a random operator, states every {1e3 * RASTER:g} ms; goal: joints within {JOINT_GOAL} % of travel, "
        f"pressures {PRESSURE_GOAL} % rms"
    )
    for name in ["cat215b", *(name for name in machine_names() if name != "cat215b")]:
        machine = load_machine(name)
        functions = function_names(machine)
        scenario = random_operator(1, SECONDS, functions=functions)
        loop, adaptive, reference = (older_calls if functions == LINKS else layout_calls)(machine, scenario)
        truth = reference().copy()
        dt, semi_implicit, off = cheapest(STEPS, loop, truth, len(functions))
        rtol, known, near = cheapest(TOLERANCES, adaptive, truth, len(functions))
        found = paired_times({"loop": semi_implicit, "rosenbrock": known}, base="loop", pairs=11)
        print(
            f"  {name:16s} semi-implicit {1e3 * dt:g} ms: {1e3 * found['loop'].seconds:8.2f} ms, joints {off[0]:.3g} %, pressures {off[1]:.3g} %; "
            f"rosenbrock {rtol:g}: {found['rosenbrock'].ratio} of its time, joints {near[0]:.3g} %, pressures {near[1]:.3g} %",
            flush=True,
        )
    print(f"\n{time.perf_counter() - begun:.0f} s in all")


if __name__ == "__main__":
    main()
