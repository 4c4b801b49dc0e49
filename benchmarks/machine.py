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

from polydraulic import build_flow, load_machine, load_scenario, simulate_batch
from polydraulic._kernel import _DRIVER_OPTIONS, KERNEL_OPTIONS, driver, kernel
from polydraulic.flow import exact_lanes
from polydraulic.flow.dispatch import flow_lanes, flow_step
from polydraulic.flow.lanes import LANES
from polydraulic.machine.plant import prepare
from polydraulic.machine.pump import Circuit
from polydraulic.machine.state import Links
from polydraulic.simulation.batch import lanes
from polydraulic.simulation.batch.batch import _processors
from polydraulic.simulation.loop import run
from polydraulic.simulation.runs import arrange
from polydraulic.simulation.step import seen_pressures
from polydraulic.thesis.timing import Ratio, in_turn
from show import show

PER_PROCESSOR = 1024
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


def throughput(body, wide):
    """Nanoseconds an operation, 16 of them a value, on values that do not depend on each other."""
    names = {"sqrt": sqrt}
    stay = "" if wide else "            if x < 0.0: return 1\n"  # a way out of the loop keeps it scalar
    text = "def loop(values, c, n):\n    for _ in range(n):\n        for i in range(128):\n            x = values[i]\n"
    exec(text + stay + f"            x = {body}\n" * 16 + "            values[i] = x\n    return 0\n", names)
    loop, values = fresh(names["loop"]), np.full(128, 1.5)
    turns = in_turn({"loop": lambda: loop(values, 1.0000001, 2000)}, turns=9)
    return turns.per(2000 * 128 * 16).median("loop") * 1e9


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

    scalar, batch = "scalar step", f"simulate_batch, {PER_PROCESSOR} machines, 1 thread"
    alone, staged, rest = "scalar flow model alone", "stages in lanes", "the same without the flow model"
    calls = {
        scalar: lambda: run(*arranged),
        alone: lambda: scalar_flows(every.model, every.memory, every.rows),
        staged: lambda: repeated(lane_steps),
        rest: lambda: repeated(lane_rest),
        batch: lambda: simulate_batch(machine, "exact", voltage, threads=1),
    }
    work = {
        scalar: n_step,
        alone: len(every.rows),
        staged: n_lane * LANES,
        rest: n_lane * LANES,
        batch: n_step * PER_PROCESSOR,
    }
    turns = in_turn(calls, turns=15, clock=process_time).per(work)  # the batch works in a thread of its own
    faster = {name: f"scalar / this {turns.ratio(scalar, name)}" for name in (staged, rest, batch)}
    limit = "on" if machine.pumps.torque_limit_enabled else "off"
    show(f"{name}, exact flow, torque limit {limit}: a step", turns, "ns", notes=faster)
    without = turns.ratio(rest, staged)
    lane_share = Ratio(1.0 - without.median, 1.0 - without.high, 1.0 - without.low)
    print(f"  share of the flow model: scalar {turns.ratio(alone, scalar)}, lanes {lane_share}")
    return turns.median(scalar) * 1e9, turns.median(staged) * 1e9


def threads(machine):
    """One machine, and many on one and all processors, in elapsed time, which neighbours on the same processors disturb."""
    scenario, n = load_scenario("task"), _processors()
    arranged = arrange(machine, "exact", scenario, every=10**6)
    voltage = arranged.voltage[None] * np.linspace(0.7, 1.3, n * PER_PROCESSOR)[:, None, None]
    calls = {"simulate, one machine": lambda: run(*arranged)}
    for count in sorted({1, n}):
        calls[f"simulate_batch, {len(voltage)} machines, {count} threads"] = lambda count=count: simulate_batch(
            machine, "exact", voltage, threads=count
        )
    turns = in_turn(calls, turns=9, clock=perf_counter)
    work = {name: len(arranged.voltage) * (1 if "one" in name else len(voltage)) for name in calls}
    show(f"elapsed time of a step of a machine, {n} processors", turns.per(work), "ns")


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
