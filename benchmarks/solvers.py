"""The package's methods against the solvers that one would pick instead, on the pick-and-place run, at equal accuracy.

Peers integrate the usual stiff form, in which each pump pressure, and the one between swing and stick valve, is a state behind a small
volume: C dP/dt = Q - Q_i - Q_e. All share the same compiled machine kernels. Two tasks: the whole run, whose input is known in
advance, and frames of 5 ms, each a start afresh with an input that nobody knew, held for the frame. Numbers of the machine are prepared
before the clock runs, for all; what is known of the inputs is found out while it runs. Errors are against a tight
solution of the stiff form: the largest joint error as a share of the joint's travel in the run, and the largest rms
error of a line pressure as a share of its range. SciPy's LSODA is always there; the other peers need the extra ``bench``, and
those that are missing are named at the beginning and at the end.

Prints medians of CPU time and ratios, asserts nothing.
"""

import argparse
from importlib.util import find_spec

import numba
import numpy as np
from scipy.integrate import solve_ivp

from polydraulic.parameters.faults import faulty_parts
from polydraulic.simulation.events import new_log
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.methods.event_log import N_KIND, event_limits
from polydraulic.simulation.layout.methods.known import Watch, known_inputs, known_parts
from polydraulic.simulation.layout.methods.rosenbrock import integrate
from polydraulic.simulation.layout.methods.text import methods_module
from polydraulic.simulation.layout.prepare import prepare_layout, start_vector
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.simulation.solvers.spools import SpoolMotion, known_motion
from polydraulic.thesis.excavator import LINKS, spool_of
from polydraulic.thesis.timing import paired_ratio, paired_times
from show import left_out
from stiff_form import (
    FRAME,
    HELD_VOLTS,
    MACHINE,
    N_FRAME,
    N_STIFF,
    READY,
    SCENARIO,
    TAU,
    TIME,
    UNITS,
    held,
    start,
    whole,
)

JOINT_GOAL, PRESSURE_GOAL = 0.1, 0.5  # %
N_RECORD, N_FLAG = len(columns_of(MACHINE).columns), N_KIND * len(LINKS) + len(MACHINE.circuits)
HOW = """the extra bench has them: pip install "polydraulic[bench]", here .venv/bin/pip install -e ".[bench]"
  (numbalsoda is built by a Fortran compiler: gfortran)"""


def spread(rows):
    """Travel of each joint and range of each line pressure in a run."""
    return np.ptp(rows[:, 9:12], axis=0), np.ptp(rows[:, 3:9], axis=0)


def in_si(rows):
    return rows * UNITS if rows.shape[1] == N_STIFF else rows


def errors(rows, truth):
    """Largest joint error and largest pressure error in percent."""
    rows, truth = in_si(rows), in_si(truth)
    travel, ranges = spread(truth)
    off = rows[:, :15] - truth[:, :15]
    joints = np.abs(off[:, 9:12]).max(axis=0) / travel
    pressures = np.sqrt((off[:, 3:9] ** 2).mean(axis=0)) / ranges
    return 100.0 * joints.max(), 100.0 * pressures.max()


# Methods of the package: the compiled drivers, without naming columns, as the peers.


def semi_implicit(dt, voltages_held):
    many = round(FRAME / dt)
    t = np.arange(N_FRAME * many) * dt
    voltage = np.repeat(HELD_VOLTS, many, axis=0) if voltages_held else step_inputs(MACHINE, SCENARIO, t)
    rows, counts = np.empty((N_FRAME + 1, N_RECORD)), np.zeros(2, dtype=np.int64)
    ready, memory = prepare_layout(MACHINE, dt), np.zeros(1)

    def call():
        ready.module.run(ready.valves, memory, ready.plant, ready.start, voltage, many, rows, counts)
        return rows

    return call


def runge_kutta(dt):
    many = round(FRAME / dt)
    voltage = step_inputs(MACHINE, SCENARIO, np.arange(2 * N_FRAME * many + 1) * (0.5 * dt))
    rows, counts = np.empty((N_FRAME + 1, N_RECORD)), np.zeros(2, dtype=np.int64)
    module = methods_module(MACHINE)

    def call():
        module.run_runge_kutta(READY.valves, READY.plant, TAU, dt, READY.start, voltage, many, rows, counts)
        return rows

    return call


def held_motion():
    """Spools under voltages that are held for each frame; nothing about later frames enters."""
    c = np.zeros((N_FRAME, 3, 8))
    x = np.zeros(3)
    gain = np.array([MACHINE.function(link).pilot.gain for link in LINKS])
    fade = np.exp(-FRAME / np.array(TAU))
    for k in range(N_FRAME):
        target = np.clip(gain * HELD_VOLTS[k], -spool_of(MACHINE).end, spool_of(MACHINE).end)
        c[k, :, 0], c[k, :, 2], c[k, :, 7] = target, x - target, 1.0 / np.array(TAU)
        x = target + (x - target) * fade
    return SpoolMotion(TIME, c, TIME[1:], c)


def rosenbrock(rtol, voltages_held):
    rows, x0, n = np.empty((N_FRAME + 1, N_RECORD)), start_vector(MACHINE), len(LINKS)
    (part,), limits = known_parts(MACHINE, SCENARIO, SCENARIO.duration), event_limits(MACHINE)
    given, unchanged = held_motion() if voltages_held else None, faulty_parts(MACHINE, (), SCENARIO.duration)

    def call():
        motion = given or known_motion(known_inputs(unchanged, SCENARIO), SCENARIO.duration)
        watch = Watch(new_log(), limits, *np.zeros((2, N_FLAG), dtype=np.int64))
        rows[0, : len(x0)] = x0
        integrate(part._replace(motion=motion), x0[n:], rtol, TIME, rows, 1, watch, {})
        return rows

    return call


# Peers


def scipy_lsoda(rtol, restarted, y0):
    f = np.empty(N_STIFF)

    def known(t, y):
        whole(t, y, f)
        return f.copy()

    def call():
        if not restarted:
            return solve_ivp(known, (0.0, TIME[-1]), y0, "LSODA", t_eval=TIME, rtol=rtol, atol=rtol).y.T
        rows = np.empty((N_FRAME + 1, N_STIFF))
        rows[0] = y0
        for k in range(N_FRAME):
            v = HELD_VOLTS[k]

            def frame(t, y, v=v):
                held(v[0], v[1], v[2], y, f)
                return f.copy()

            rows[k + 1] = solve_ivp(frame, (0.0, FRAME), rows[k], "LSODA", rtol=rtol, atol=rtol).y[:, -1]
        return rows

    return call


def cvode(rtol, restarted, y0):
    from sksundae.cvode import CVODE

    options = {"rtol": rtol, "atol": rtol, "method": "BDF", "max_num_steps": 100_000}

    def call():
        if not restarted:
            return CVODE(lambda t, y, f: whole(t, y, f), **options).solve(TIME, y0).y
        rows = np.empty((N_FRAME + 1, N_STIFF))
        rows[0] = y0
        volts = np.zeros(3)
        solver = CVODE(lambda t, y, f: held(volts[0], volts[1], volts[2], y, f), **options)
        ends = np.array([0.0, FRAME])
        for k in range(N_FRAME):
            volts[:] = HELD_VOLTS[k]
            rows[k + 1] = solver.solve(ends, rows[k]).y[-1]
        return rows

    return call


def numbalsoda_pair():
    """Compiled right-hand sides for numbalsoda and the loop over frames."""
    from numbalsoda import lsoda, lsoda_sig

    @numba.cfunc(lsoda_sig)
    def known(t, y, f, p):
        whole(t, numba.carray(y, (N_STIFF,)), numba.carray(f, (N_STIFF,)))

    @numba.cfunc(lsoda_sig)
    def given(t, y, f, p):
        v = numba.carray(p, (3,))
        held(v[0], v[1], v[2], numba.carray(y, (N_STIFF,)), numba.carray(f, (N_STIFF,)))

    known_address, given_address = known.address, given.address

    @numba.njit
    def frames(address, y0, volts, rtol, atol, rows):
        rows[0] = y0
        ends = np.array([0.0, FRAME])
        for k in range(volts.shape[0]):
            solution, _ = lsoda(address, rows[k], ends, volts[k], rtol, atol, 100_000)
            rows[k + 1] = solution[1]

    def make(rtol, restarted, y0):
        rows = np.empty((N_FRAME + 1, N_STIFF))

        def call():
            if restarted:
                frames(given_address, y0, HELD_VOLTS, rtol, rtol, rows)
                return rows
            return lsoda(known_address, y0, TIME, np.zeros(1), rtol, rtol, 100_000)[0]

        call.keep = (known, given)
        return call

    return make


def table(title, calls, truth, pairs):
    """Print errors and times of all methods; times of those that meet the goal."""
    found = {name: errors(call(), truth) for name, call in calls.items()}
    times, met = paired_times(calls, base="semi-implicit 5 ms", pairs=pairs), {}
    print(f"\n{title}\n  {'':24s} {'ms':>9s}  {'ratio (quartiles)':24s} joints %  pressures %   goal")
    for name, (joints, pressures) in found.items():
        if joints <= JOINT_GOAL and pressures <= PRESSURE_GOAL:
            met[name] = times[name].ratio
        line = (
            f"  {name:24s} {times[name].seconds * 1e3:9.3f}  {times[name].ratio!s:24s} {joints:8.4f} {pressures:12.4f}"
        )
        print(f"{line}   {'met' if name in met else ''}".rstrip())
    return met


def fastest(met, family):
    """The fastest of a family of methods at the goal."""
    return min((name for name in met if name.startswith(family)), key=met.get, default=None)


def summary(calls, met, ours, peers, pairs):
    """The fastest of each family at the goal in pairs with each other."""
    for mine in ours:
        for peer in peers:
            a, b = fastest(met, mine), fastest(met, peer)
            if a and b:
                ratio = paired_ratio(calls[b], calls[a], pairs=pairs)
                print(f"  at the goal, {b} takes {ratio} times as long as {a}")


def agreement(truth, makers, restarted, y0):
    """How far the truth is from a tight solution of another solver, or of the same where there is no other."""
    name = "CVODE" if "CVODE" in makers else "SciPy LSODA"
    off = errors(makers[name](1e-9, restarted, y0)(), truth)
    print("\nthe tight solution and {} at 1e-9 differ by {:.1e} % (joints), {:.1e} % (pressures)".format(name, *off))


def known_peers():
    """Peers that are installed, and the others."""
    makers = {"numbalsoda": numbalsoda_pair, "CVODE": lambda: cvode}
    modules = {"numbalsoda": "numbalsoda", "CVODE": "sksundae"}
    there = {name: make() for name, make in makers.items() if find_spec(modules[name])}
    return there | {"SciPy LSODA": scipy_lsoda}, [name for name in makers if name not in there]


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--pairs", type=int, default=11)
    pairs = arguments.parse_args().pairs
    y0 = start()
    makers, missing = known_peers()

    def say_missing():
        if missing:
            left_out(f"solvers {' and '.join(missing)}, next to the methods of simulate", HOW)

    say_missing()
    tight = makers.get("numbalsoda", scipy_lsoda)

    print(
        f"pick and place, {SCENARIO.duration:g} s; goal: joints within {JOINT_GOAL} % of travel, pressures {PRESSURE_GOAL} % rms"
    )
    truth = tight(1e-10, False, y0)().copy()
    agreement(truth, makers, False, y0)
    calls = {f"semi-implicit {dt * 1e3:g} ms": semi_implicit(dt, False) for dt in (5e-3, 2.5e-3, 1e-3)}
    calls |= {f"rk4 {dt * 1e3:g} ms": runge_kutta(dt) for dt in (5e-3,)}
    calls |= {f"rosenbrock {rtol:g}": rosenbrock(rtol, False) for rtol in (3e-3, 2e-3, 1e-3, 3e-4, 1e-4)}
    for name, make in makers.items():
        calls |= {
            f"{name} {rtol:g}": make(rtol, False, y0) for rtol in (1e-2, 3e-3, 1e-3, 7e-4, 5e-4, 3e-4, 1e-4, 1e-5)
        }
    met = table("whole run, states every 5 ms", calls, truth, pairs)
    summary(calls, met, ["rosenbrock", "semi-implicit"], makers, pairs)

    truth = tight(1e-10, True, y0)().copy()
    agreement(truth, makers, True, y0)
    calls = {f"semi-implicit {dt * 1e3:g} ms": semi_implicit(dt, True) for dt in (5e-3, 2.5e-3, 1e-3)}
    calls |= {f"rosenbrock {rtol:g}": rosenbrock(rtol, True) for rtol in (1e-3, 3e-4, 1e-4)}
    for name, make in makers.items():
        calls |= {f"{name} {rtol:g}": make(rtol, True, y0) for rtol in (1e-3, 3e-4, 1e-4)}
    fewer = (pairs + 1) // 2  # these take seconds
    met = table("a start afresh each 5 ms, voltages held", calls, truth, fewer)
    summary(calls, met, ["rosenbrock", "semi-implicit"], makers, fewer)
    say_missing()


if __name__ == "__main__":
    main()
