"""Speed of the whole machine: one step, 64 machines in lanes, batches on all processors, next to what the arithmetic takes.

``python benchmarks/machine.py`` prints and asserts nothing. All times but the last table's are processor times, medians of
turns within this run; the limit counts the divisions, roots, products and sums in the compiled lanes, times the throughput
of each, measured here too.
"""

import re
from math import sqrt
from statistics import median
from time import perf_counter, process_time

import llvmlite.binding as llvm
import numba
import numpy as np

from polydraulic import build_flow, load_machine, load_scenario, simulate_batch
from polydraulic._kernel import _DRIVER_OPTIONS, KERNEL_OPTIONS, driver
from polydraulic.flow import exact_lanes
from polydraulic.flow.dispatch import flow_lanes, flow_step
from polydraulic.flow.lanes import LANES
from polydraulic.machine.plant import prepare
from polydraulic.machine.state import Links
from polydraulic.simulation.batch import lanes
from polydraulic.simulation.batch.batch import _processors
from polydraulic.simulation.loop import run
from polydraulic.simulation.runs import arrange
from polydraulic.simulation.step import seen_pressures

PER_PROCESSOR = 1024
OPERATIONS = {
    "division": "div",
    "square root": "sqrt",
    "product": "mul",
    "sum, minimum, maximum": "(?:add|sub|min|max)",
}


def in_turn(calls, repeats=9, clock=process_time):
    """Median seconds of each call; the calls take turns, after one that compiles."""
    seconds = {name: [] for name in calls}
    for repeat in range(repeats + 1):
        for name, call in calls.items():
            start = clock()
            call()
            if repeat:
                seconds[name].append(clock() - start)
    return {name: median(values) for name, values in seconds.items()}


def fresh(function):
    """Compiled without the cache, which keeps no assembly."""
    return numba.njit(**_DRIVER_OPTIONS)(function)


@driver
def lane_steps(model, plant, rows, n):
    for _ in range(n):
        lanes._pilot_stage(plant, None, rows)
        flow_lanes(model, None, rows, False)
        lanes._position_stage(plant, None, rows)
        lanes._hose_stage(plant, None, rows)
        lanes._motion_stage(plant, None, rows)


@driver
def lane_rest(model, plant, rows, n):
    """All stages but the flow model's."""
    for _ in range(n):
        lanes._pilot_stage(plant, None, rows)
        lanes._position_stage(plant, None, rows)
        lanes._hose_stage(plant, None, rows)
        lanes._motion_stage(plant, None, rows)


@driver
def scalar_flows(model, memory, rows):
    total = 0.0
    for k in range(rows.shape[0]):
        x = rows[k]
        spool = Links(x[0], x[1], x[2])
        seen = seen_pressures(spool, Links(x[3], x[4], x[5]), Links(x[6], x[7], x[8]))
        total += flow_step(model, memory, spool, seen.p_in, seen.p_out, 0.005).q_in.boom
    return total


def throughput(body, wide):
    """Nanoseconds an operation, 16 of them a value, on values that do not depend on each other."""
    names = {"sqrt": sqrt}
    stay = "" if wide else "            if x < 0.0: return 1\n"  # a way out of the loop keeps it scalar
    text = "def loop(values, c, n):\n    for _ in range(n):\n        for i in range(128):\n            x = values[i]\n"
    exec(text + stay + f"            x = {body}\n" * 16 + "            values[i] = x\n    return 0\n", names)
    loop, values = fresh(names["loop"]), np.full(128, 1.5)
    seconds = in_turn({"loop": lambda: loop(values, 1.0000001, 2000)})["loop"]
    return seconds / 2000 / 128 / 16 * 1e9


def compiled_step(model, plant, rows):
    """Assembly of the stages of a step with constant pump flow; each loop over lanes stands there once."""
    llvm.set_option("", "-unroll-full-max-count=1")
    stages = [
        numba.njit(**KERNEL_OPTIONS)(stage.py_func)
        for stage in (
            lanes._pilot_stage,
            exact_lanes._valves,
            exact_lanes._boom,
            exact_lanes._series,
            lanes._position_stage,
            lanes._hose_stage,
            lanes._motion_stage,
        )
    ]
    pilot, valves, boom, series, position, hose, motion = stages

    def step(model, plant, rows):
        pilot(plant, None, rows)
        valves(model, None, rows)
        boom(model, None, rows, False)
        series(model, None, rows, False)
        position(plant, None, rows)
        hose(plant, None, rows)
        motion(plant, None, rows)

    whole = fresh(step)
    whole(model, plant, rows)
    return whole.inspect_asm(whole.signatures[0])


def limits(assembly):
    """Nanoseconds that the operations of a step take one by one and in lanes, if nothing else took time."""
    bodies = ("c / x", "sqrt(x)", "c * x", "c + x")
    width = 8 if "zmm" in assembly else 4
    print(f"\noperations of a step, in vectors of {width}, and their throughput")
    table = {}
    for (name, code), body in zip(OPERATIONS.items(), bodies, strict=True):
        count = len(re.findall(rf"\tv{code}pd\t", assembly))
        one, many = throughput(body, False), throughput(body, True)
        table[name] = np.array([count * one, count * many])
        print(f"  {name:24s} {count:5d}   one by one {one:6.3f} ns, in vectors {many:6.3f} ns a value")
    divider = table["division"] + table["square root"]
    products, sums = table["product"], table["sum, minimum, maximum"]
    for name, (one, many) in (("divider, for roots too", divider), ("products", products), ("sums", sums)):
        print(f"  {name:24s} busy {one:4.0f} ns a step one by one, {many:5.1f} ns in lanes")
    # the units work side by side, so that the busiest sets the limit
    return np.max([divider, products, sums], axis=0)


def one_block(machine, scenario):
    """Arguments of the loops over lanes, after a tenth of the scenario, voltages spread over the lanes."""
    plant, model = prepare(machine, 5e-3, scenario.locked), build_flow("exact", machine)
    arranged = arrange(machine, "exact", scenario)
    spread = np.linspace(0.7, 1.3, LANES)
    voltage = arranged.voltage[None] * spread[:, None, None]
    batch = simulate_batch(machine, "exact", voltage, t_end=scenario.duration / 4)
    rows = np.zeros((lanes.N_ROW, LANES))
    names = [
        f"{link}.{name}" for name in ("spool", "p_a", "p_b", "angle", "rate") for link in ("swing", "boom", "stick")
    ]
    rows[:15] = batch.final[:, [batch.place(name) for name in names]].T
    rows[lanes._VOLTAGE : lanes._VOLTAGE + 3] = voltage[:, len(arranged.voltage) // 4].T
    return model, plant, rows


def steps(machine, name):
    scenario = load_scenario(name)
    arranged = arrange(machine, "exact", scenario, every=10**6)
    n_step = len(arranged.voltage)
    every = arrange(machine, "exact", scenario)
    run(*every)
    model, plant, start = one_block(machine, scenario)
    voltage = arranged.voltage[None] * np.linspace(0.7, 1.3, PER_PROCESSOR)[:, None, None]
    n_lane = 500

    def repeated(loop):
        rows = start.ravel().copy()
        loop(model, plant, rows, n_lane)

    seconds = in_turn(
        {
            "scalar step": lambda: run(*arranged),
            "scalar flow model alone": lambda: scalar_flows(every.model, every.memory, every.rows),
            "stages in lanes": lambda: repeated(lane_steps),
            "the same without the flow model": lambda: repeated(lane_rest),
            f"simulate_batch, {PER_PROCESSOR} machines, 1 thread": lambda: simulate_batch(
                machine, "exact", voltage, threads=1
            ),
        },
        5,
    )
    counts = [n_step, n_step, n_lane * LANES, n_lane * LANES, n_step * PER_PROCESSOR]
    each = {label: value / count * 1e9 for (label, value), count in zip(seconds.items(), counts, strict=True)}
    scalar = each["scalar step"]
    print(f"\n{name}, exact flow, torque limit {'on' if machine.pumps.torque_limit_enabled else 'off'}")
    for label, value in each.items():
        print(f"  {label:44s} {value:8.1f} ns a step   scalar / this {scalar / value:6.2f}")
    print(f"  share of the flow model: scalar {each['scalar flow model alone'] / scalar:.0%},", end=" ")
    print(f"lanes {1.0 - each['the same without the flow model'] / each['stages in lanes']:.0%}")
    return scalar, each["stages in lanes"]


def threads(machine):
    """Machine-steps a second, in elapsed time, which neighbours on the same processors disturb."""
    scenario, n = load_scenario("task"), _processors()
    arranged = arrange(machine, "exact", scenario, every=10**6)
    voltage = arranged.voltage[None] * np.linspace(0.7, 1.3, n * PER_PROCESSOR)[:, None, None]
    calls = {"simulate, one machine": lambda: run(*arranged)}
    for count in sorted({1, n}):
        calls[f"simulate_batch, {len(voltage)} machines, {count} threads"] = lambda count=count: simulate_batch(
            machine, "exact", voltage, threads=count
        )
    seconds = in_turn(calls, 5, perf_counter)
    made = len(arranged.voltage)
    rates = {name: made * (1 if "one" in name else len(voltage)) / value for name, value in seconds.items()}
    print(f"\nelapsed time, {n} processors")
    for name, rate in rates.items():
        print(f"  {name:44s} {rate / 1e6:8.2f} million steps/s   ratio {rate / rates['simulate, one machine']:6.2f}")


def main():
    machine = load_machine("cat215b")
    limited = machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=True))
    measured = {name: steps(machine, name) for name in ("sine", "task", "step")}
    model, plant, rows = one_block(machine, load_scenario("task"))
    least_scalar, least_lanes = limits(compiled_step(model, plant, rows.ravel()))
    for name, (scalar, lane) in measured.items():
        print(f"  {name:6s} scalar {scalar / least_scalar:5.2f} times its limit, lanes {lane / least_lanes:5.2f} times")
    for name in ("sine", "step"):
        steps(limited, name)
    threads(machine)


if __name__ == "__main__":
    main()
