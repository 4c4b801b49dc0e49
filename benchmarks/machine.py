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

from polydraulic import load_machine, load_scenario, simulate_batch
from polydraulic._kernel import _DRIVER_OPTIONS, _KERNEL_OPTIONS, driver, kernel
from polydraulic.flow import exact_flow
from polydraulic.flow.lanes import LANES
from polydraulic.simulation.batch.batch import _processors
from polydraulic.simulation.batch.family import family_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.runs import prepared_run
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


STEP = prepare_layout(load_machine("cat215b"), 5e-3).module


@driver
def lane_steps(valves, plant, rows, n):
    for _ in range(n):
        STEP.pilot_stage(plant, None, rows)
        STEP.flow_stage(valves, None, rows, False)
        STEP.position_stage(plant, None, rows)
        STEP.hose_stage(plant, None, rows)
        STEP.motion_stage(plant, None, rows)


@driver
def lane_rest(valves, plant, rows, n):
    """All stages but the flow model's."""
    for _ in range(n):
        STEP.pilot_stage(plant, None, rows)
        STEP.position_stage(plant, None, rows)
        STEP.hose_stage(plant, None, rows)
        STEP.motion_stage(plant, None, rows)


@kernel
def of_circuit(c):
    return c.q_pump + c.q_bypass + c.q_relief + c.p_pump + c.q_stored


@kernel
def of_links(x):
    return x.swing + x.boom + x.stick


@driver
def scalar_flows(valves, memory, rows):
    """Sum of everything that the flow model gives, so that the compiler leaves nothing out."""
    total = 0.0
    for k in range(rows.shape[0]):
        x = rows[k]
        spool, p_a, p_b = (
            STEP.Functions(x[0], x[1], x[2]),
            STEP.Functions(x[3], x[4], x[5]),
            STEP.Functions(x[6], x[7], x[8]),
        )
        seen = STEP.seen_pressures(spool, p_a, p_b)
        q = STEP.flow_step(valves, memory, spool, seen.p_in, seen.p_out, 0.005)
        total += (
            of_links(q.q_in)
            + of_links(q.k_out)
            + of_circuit(q.circuit_boom)
            + of_circuit(q.circuit_series)
            + q.between_series_1
            + q.status
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


def compiled_step(valves, plant, rows):
    """Assembly of the stages of a step with constant pump flow; each loop over lanes stands there once."""
    llvm.set_option("", "-unroll-full-max-count=1")
    names = ("pilot", "valve", "inlet_boom", "inlet_series", "position", "hose", "motion")
    parts = [name.replace("_", "_stage_") if "_" in name else f"{name}_stage" for name in names]
    stages = [numba.njit(**_KERNEL_OPTIONS)(getattr(STEP, part).py_func) for part in parts]
    pilot, valve, boom, series, position, hose, motion = stages

    def step(valves, plant, rows):
        pilot(plant, None, rows)
        valve(valves, None, rows)
        boom(valves, None, rows)
        series(valves, None, rows)
        position(plant, None, rows)
        hose(plant, None, rows)
        motion(plant, None, rows)

    whole = fresh(step)
    whole(valves, plant, rows)
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
    ready, family = prepare_layout(machine, 5e-3, scenario.locked), family_of(machine, exact_flow(machine))
    inputs = prepared_run(machine, "exact", scenario).args[4]
    voltage = inputs[None] * np.linspace(0.7, 1.3, LANES)[:, None, None]
    batch = simulate_batch(machine, "exact", voltage, t_end=scenario.duration / 4)
    rows = np.zeros((family.n_row, LANES))
    names = [f"{link}.{name}" for name in ("spool", "p_a", "p_b", "angle", "rate") for link in machine.names]
    rows[: len(names)] = batch.final[:, [batch.place(name) for name in names]].T
    rows = rows.ravel()
    for lane in range(LANES):
        STEP.put_voltage(rows, lane, STEP.Functions(*voltage[lane, len(inputs) // 4]))
    return ready.valves, ready.plant, rows


def few_rows(machine, scenario):
    """The compiled loop, which keeps the first row alone."""
    valves, memory, plant, start, inputs, _, rows, counts = prepared_run(machine, "exact", scenario).args
    return lambda: STEP.run(valves, memory, plant, start, inputs, 10**6, rows, counts)


def steps(machine, name):
    scenario = load_scenario(name)
    every = prepared_run(machine, "exact", scenario)
    every()
    valves, memory, _, _, inputs, _, recorded, _ = every.args
    few, n_step = few_rows(machine, scenario), len(inputs)
    states = np.ascontiguousarray(recorded[:, :9])  # few bytes, since a step reads none
    block_valves, plant, start = one_block(machine, scenario)
    voltage = inputs[None] * np.linspace(0.7, 1.3, MACHINES)[:, None, None]
    n_lane = 500

    def repeated(loop):
        loop(block_valves, plant, start.copy(), n_lane)

    scalar, batch = "scalar step", f"simulate_batch, {MACHINES} machines, 1 thread"
    alone, staged, rest = "scalar flow model alone", "stages in lanes", "the same without the flow model"
    calls = {
        scalar: few,
        alone: lambda: scalar_flows(valves, memory, states),
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
    loop, inputs = few_rows(machine, scenario), prepared_run(machine, "exact", scenario).args[4]
    voltage = inputs[None] * np.linspace(0.7, 1.3, n * PER_PROCESSOR)[:, None, None]
    runs = len(voltage) // 3
    calls = {"simulate, one machine": lambda: [loop() for _ in range(runs)]}
    for count in sorted({1, n}):
        calls[f"simulate_batch, {len(voltage)} machines, {count} threads"] = lambda count=count: simulate_batch(
            machine, "exact", voltage, threads=count
        )
    work = {name: len(inputs) * (runs if "one" in name else len(voltage)) for name in calls}
    times = paired_times(calls, pairs=7, clock=perf_counter, work=work)
    show(f"elapsed time of a step of a machine, {n} processors", times, "ns")


def main():
    machine = load_machine("cat215b")
    limited = with_pumps(machine, torque_limit_enabled=True)
    for name in ("sine", "step"):
        steps(machine, name)
    measured = steps(machine, "task")
    limits(compiled_step(*one_block(machine, load_scenario("task"))), *measured)
    for name in ("sine", "step"):
        steps(limited, name)
    threads(machine)


if __name__ == "__main__":
    main()
