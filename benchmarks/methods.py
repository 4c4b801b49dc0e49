"""The Rosenbrock method next to the semi-implicit loop at equal accuracy, on every machine that comes with the package.

``python benchmarks/methods.py`` prints and asserts nothing. Each machine does its own scenario, and what a random operator does, whose hands are
never still for long; both are known in advance, and states come out every 5 ms. Errors are against the reference solution: the largest joint
error as a share of the joint's travel in the run, and the largest rms error of a line pressure as a share of its range. Of each
method the cheapest setting counts that keeps both below a goal; times are those of the compiled loops, without naming columns, with the
Rosenbrock method's preparation in Python.
"""

import time

import numpy as np

from polydraulic import load_machine
from polydraulic.parameters.load import machine_names
from polydraulic.parameters.scenario import load_scenario, random_operator, scenario_names
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.methods import lsoda, rosenbrock
from polydraulic.simulation.layout.methods.known import run_known
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.thesis.timing import paired_times

RASTER, SECONDS = 5e-3, 20.0
GOALS = ((0.1, 0.5), (0.01, 0.05))  # % of travel, % of a pressure's range
STEPS = tuple(RASTER / 2**k for k in range(8))  # s
TOLERANCES = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
LEAST = 0.01  # rad or m; the travel of a joint that moves less


def raster(scenario):
    """Times at which states come out."""
    return np.arange(round(scenario.duration / RASTER) + 1) * RASTER


def calls_of(machine, scenario):
    """Runs: of a step, of a tolerance, and the reference."""
    times = raster(scenario)

    def loop(dt):
        n = round(scenario.duration / dt)
        ready, inputs = prepare_layout(machine, dt), step_inputs(machine, scenario, np.arange(n) * dt)
        rows, counts = np.empty((len(times), len(columns_of(machine).columns))), np.zeros(2, dtype=np.int64)
        arguments = (
            ready.valves,
            np.zeros(ready.n_memory),
            ready.plant,
            ready.start,
            inputs,
            round(RASTER / dt),
            rows,
            counts,
        )
        return lambda: (ready.module.run(*arguments), rows)[1]

    def known(rtol, method):
        return run_known(machine, scenario, (), times, rtol, method.__name__, method.integrate).rows

    return loop, lambda rtol: lambda: known(rtol, rosenbrock), lambda: known(1e-9, lsoda)


def errors(rows, truth, n):
    """Largest joint error and largest pressure error in percent; a row begins with spools, pressures A and B, and positions."""
    off = rows[:, : 4 * n] - truth[:, : 4 * n]
    joints = np.abs(off[:, 3 * n :]).max(axis=0) / np.maximum(np.ptp(truth[:, 3 * n : 4 * n], axis=0), LEAST)
    pressures = np.sqrt((off[:, n : 3 * n] ** 2).mean(axis=0)) / np.ptp(truth[:, n : 3 * n], axis=0)
    return 100.0 * joints.max(), 100.0 * pressures.max()


def cheapest(settings, call_of, truth, n, goal):
    """The first setting that meets a goal, its call and its errors; the last one where none does."""
    for setting in settings:
        call = call_of(setting)
        off = errors(call(), truth, n)
        if off[0] <= goal[0] and off[1] <= goal[1]:
            break
    return setting, call, off


def said(off):
    """Errors in words."""
    return f"joints {off[0]:.2g} %, pressures {off[1]:.2g} %"


def compared(machine, scenario):
    """Print a line for each goal."""
    functions = machine.names
    loop, adaptive, reference = calls_of(machine, scenario)
    truth = reference().copy()
    for goal in GOALS:
        dt, semi_implicit, off = cheapest(STEPS, loop, truth, len(functions), goal)
        rtol, known, near = cheapest(TOLERANCES, adaptive, truth, len(functions), goal)
        found = paired_times({"loop": semi_implicit, "rosenbrock": known}, base="loop", pairs=11)
        print(
            f"    {scenario.name:12s} goal {goal[0]:g} %: semi-implicit {1e3 * dt:.3g} ms in {1e3 * found['loop'].seconds:.3g} ms ({said(off)}); "
            f"rosenbrock {rtol:g} in {found['rosenbrock'].ratio} of its time ({said(near)})",
            flush=True,
        )


def main():
    begun = time.perf_counter()
    print(f"states every {1e3 * RASTER:g} ms; goals: % of travel of joints, five times as much for pressures")
    for name in ["cat215b", *(name for name in machine_names() if name != "cat215b")]:
        machine = load_machine(name)
        functions = machine.names
        own = "task" if name == "cat215b" else scenario_names(name)[0]
        print(f"  {name}", flush=True)
        compared(machine, load_scenario(own, functions=functions))
        compared(machine, random_operator(1, SECONDS, functions=functions))
    print(f"\n{time.perf_counter() - begun:.0f} s in all")


if __name__ == "__main__":
    main()
