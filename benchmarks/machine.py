"""Speed of the whole machine: one step, 64 machines in lanes, batches on all processors, next to what the arithmetic takes.

``python benchmarks/machine.py`` prints and asserts nothing. All times but the last table's are processor times; the limit counts
the divisions, roots, products and sums in the compiled lanes, times the throughput of each, measured here too. The share of
the flow model of a scalar step is that of the model alone, over the states of the run, all of its results summed.
"""

import re
from math import sqrt
from time import perf_counter, process_time

import llvmlite.binding as llvm
import numba
import numpy as np
from polydraulic.machine.plant import prepare
from polydraulic.simulation.loop import run
from polydraulic.simulation.step import seen_pressures

from polydraulic import build_flow, load_machine, load_scenario, simulate_batch
from polydraulic._kernel import _DRIVER_OPTIONS, KERNEL_OPTIONS, driver, kernel
from polydraulic.flow import exact_lanes
from polydraulic.flow.dispatch import flow_lanes, flow_step
from polydraulic.flow.lanes import LANES
from polydraulic.machine.pump import Circuit
from polydraulic.machine.state import Links
from polydraulic.simulation.batch import lanes
from polydraulic.simulation.batch.batch import _processors
from polydraulic.simulation.runs import arrange
from polydraulic.thesis.excavator import pump_of, with_pumps
from polydraulic.thesis.timing import Ratio, paired_ratio, paired_times
from show import show

MACHINES, PER_PROCESSOR = 256, 1024  # of a batch whose CPU time, or whose elapsed time, counts
OPERATIONS = {
    "division": "div",
    "square root": "sqrt",
    "product": "mul",
    "sum, minimum, maximum": "(?:add|sub|min|max)",
}


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


@kernel
def of_circuit(c: Circuit):
    return c.q_pump + c.q_bypass + c.q_relief + c.p_pump + c.q_stored


@kernel
def of_links(x: Links):
    return x.swing + x.boom + x.stick


@driver
def scalar_flows(model, memory, rows):
    """Sum of everything that the flow model gives, so that the compiler leaves nothing out."""
    total = 0.0
    for k in range(rows.shape[0]):
        x = rows[k]
        spool = Links(x[0], x[1], x[2])
        seen = seen_pressures(spool, Links(x[3], x[4], x[5]), Links(x[6], x[7], x[8]))
        q = flow_step(model, memory, spool, seen.p_in, seen.p_out, 0.005)
        total += (
            of_links(q.q_in) + of_links(q.k_out) + of_circuit(q.boom) + of_circuit(q.series) + q.p_between + q.status
        )
    return total


def throughput(body, wide, step, n_step):
    """Time of an operation, 16 of them a value, on values that do not depend on each other; ratio to a scalar step."""
    names = {"sqrt": sqrt}
    stay = "" if wide else "            if x < 0.0: return 1\n"  # a way out of the loop keeps it scalar
    text = "def loop(values, c, n):\n    for _ in range(n):\n        for i in range(128):\n            x = values[i]\n"
    exec(text + stay + f"            x = {body}\n" * 16 + "            values[i] = x\n    return 0\n", names)
    loop, values = fresh(names["loop"]), np.full(128, 1.5)
    work = {"step": n_step, "operation": 500 * 128 * 16}
    calls = {"step": step, "operation": lambda: loop(values, 1.0000001, 500)}
    return paired_times(calls, work=work)["operation"]


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


def limits(assembly, step, n_step, lane_step):
    """How far steps are from what their operations take one by one and in lanes, if nothing else took time."""
    bodies = ("c / x", "sqrt(x)", "c * x", "c + x")
    width = 8 if "zmm" in assembly else 4
    print(f"\noperations of a step, in vectors of {width}, and their throughput")
    busy = {}
    for (name, code), body in zip(OPERATIONS.items(), bodies, strict=True):
        count = len(re.findall(rf"\tv{code}pd\t", assembly))
        one, many = (throughput(body, wide, step, n_step) for wide in (False, True))
        busy[name] = count * np.array([one.ratio.median, many.ratio.median])
        times = f"one by one {one.seconds * 1e9:6.3f} ns, in vectors {many.seconds * 1e9:6.3f} ns a value"
        print(f"  {name:24s} {count:5d}   {times}")
    divider = busy["division"] + busy["square root"]
    products, sums = busy["product"], busy["sum, minimum, maximum"]
    for name, (one, many) in (("divider, for roots too", divider), ("products", products), ("sums", sums)):
        print(f"  {name:24s} busy {one:4.0%} of a scalar step one by one, {many / lane_step:4.0%} of a step in lanes")
    # the units work side by side, so that the busiest sets the limit
    least, least_lanes = np.max([divider, products, sums], axis=0)
    print(f"  a scalar step takes {1.0 / least:.2f} times its limit, one in lanes {lane_step / least_lanes:.2f} times")


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
    states = np.ascontiguousarray(every.rows[:, :9])  # few bytes, since a step reads none
    model, plant, start = one_block(machine, scenario)
    voltage = arranged.voltage[None] * np.linspace(0.7, 1.3, MACHINES)[:, None, None]
    n_lane = 500

    def repeated(loop):
        rows = start.ravel().copy()
        loop(model, plant, rows, n_lane)

    scalar, batch = "scalar step", f"simulate_batch, {MACHINES} machines, 1 thread"
    alone, staged, rest = "scalar flow model alone", "stages in lanes", "the same without the flow model"
    calls = {
        scalar: lambda: run(*arranged),
        alone: lambda: scalar_flows(every.model, every.memory, states),
        staged: lambda: repeated(lane_steps),
        rest: lambda: repeated(lane_rest),
        batch: lambda: simulate_batch(machine, "exact", voltage, threads=1),
    }
    work = {
        scalar: n_step,
        alone: len(states),
        staged: n_lane * LANES,
        rest: n_lane * LANES,
        batch: n_step * MACHINES,
    }
    # processor time of the process, since the batch works in a thread of its own
    times = paired_times(calls, pairs=15, clock=process_time, work=work)
    notes = {one: f"scalar / this {1.0 / times[one].ratio.median:6.2f}" for one in (staged, rest, batch)}
    limit = "on" if pump_of(machine, "boom").torque_limit_enabled else "off"
    show(f"{name}, exact flow, torque limit {limit}: a step", times, "ns", notes=notes)
    without = paired_ratio(calls[rest], calls[staged], pairs=15)
    lane_share = Ratio(1.0 - without.median, 1.0 - without.high, 1.0 - without.low)
    print(f"  share of the flow model: scalar {times[alone].ratio}, lanes {lane_share}")
    return calls[scalar], n_step, times[staged].ratio.median


def threads(machine):
    """One machine after another, and many on one and on all processors, in elapsed time.

    All calls are about as long, so that other programs take about as much of each.
    """
    scenario, n = load_scenario("task"), _processors()
    arranged = arrange(machine, "exact", scenario, every=10**6)
    voltage = arranged.voltage[None] * np.linspace(0.7, 1.3, n * PER_PROCESSOR)[:, None, None]
    runs = len(voltage) // 3
    calls = {"simulate, one machine": lambda: [run(*arranged) for _ in range(runs)]}
    for count in sorted({1, n}):
        calls[f"simulate_batch, {len(voltage)} machines, {count} threads"] = lambda count=count: simulate_batch(
            machine, "exact", voltage, threads=count
        )
    work = {name: len(arranged.voltage) * (runs if "one" in name else len(voltage)) for name in calls}
    times = paired_times(calls, pairs=7, clock=perf_counter, work=work)
    show(f"elapsed time of a step of a machine, {n} processors", times, "ns")


def main():
    machine = load_machine("cat215b")
    limited = with_pumps(machine, torque_limit_enabled=True)
    for name in ("sine", "step"):
        steps(machine, name)
    measured = steps(machine, "task")
    model, plant, rows = one_block(machine, load_scenario("task"))
    limits(compiled_step(model, plant, rows.ravel()), *measured)
    for name in ("sine", "step"):
        steps(limited, name)
    threads(machine)


if __name__ == "__main__":
    main()
