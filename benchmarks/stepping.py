"""Machines moved step by step from Python, next to runs as a whole: a call of one, and 4,096 side by side with two steps of 5 ms a call.

``python benchmarks/stepping.py [MACHINE ...]``; one thread, processor time. Levers change with every call. Of one machine the compiled loop of
`simulate`, with levers known in advance, is what a step costs by itself; of many it is `simulate_batch` over 100 steps, which keeps the end alone.
Results of every call are summed. Compilation is not in it.
"""

import sys
import time

import numpy as np

from polydraulic import BatchSimulator, Simulator, load_machine, simulate_batch
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.thesis.timing import paired_times
from show import show

MACHINES, DT, CALLS, LONG, EACH = ("wheel_loader", "cat215b_bucket"), 5e-3, 2000, 100, 4096
ENVIRONMENT = 2  # steps of 5 ms


def levers_of(machine, *shape):
    """Voltages at random."""
    return np.random.default_rng(0).uniform(-0.7, 0.7, (*shape, len(machine.names)))


def single(machine):
    """Calls of one step each, of ten, and the loop over all of them."""
    ready, levers = prepare_layout(machine, DT), levers_of(machine, CALLS)
    rows, counts = np.empty((CALLS + 1, len(columns_of(machine).columns))), np.zeros(2, dtype=np.int64)
    sim = Simulator(machine, dt=DT)

    def loop():
        ready.module.run(ready.valves, np.zeros(ready.n_memory), ready.plant, ready.start, levers, 1, rows, counts)
        return rows[-1].sum()

    def calls(n):
        def run():
            sim.reset()
            for lever in levers[: CALLS // n]:
                sim.step(lever, n)
            return sim.values.sum()

        return run

    return {"the loop of `simulate`": loop, "one step a call": calls(1), "ten steps a call": calls(10)}


def batches(machine):
    """Calls of two steps each, and a long batch: as many steps of as many machines."""
    levers = levers_of(machine, EACH)
    held = np.repeat(levers[:, None], LONG, axis=1)
    sim = BatchSimulator(machine, EACH, dt=DT)
    few = BatchSimulator(machine, EACH, dt=DT, columns=["effector.x", "effector.y", "effector.z"])

    def calls(which):
        def run():
            which.reset()
            for _ in range(LONG // ENVIRONMENT):
                which.step(levers, n=ENVIRONMENT)
            return which["effector.x"].sum()

        return run

    return {
        "a long batch": lambda: simulate_batch(machine, "exact", held, dt=DT, threads=1).final.sum(),
        "two steps a call": calls(sim),
        "two steps a call, the tip alone": calls(few),
    }


def main():
    begun = time.perf_counter()
    for name in sys.argv[1:] or MACHINES:
        machine = load_machine(name)
        times = paired_times(single(machine), clock=time.process_time)
        step, call = (times[key][0] / CALLS * 1e6 for key in ("the loop of `simulate`", "one step a call"))
        show(
            f"{name}: a step of one machine",
            times,
            "us",
            per=CALLS,
            notes={"one step a call": f"{call - step:.2f} us more than the step"},
        )
        per = EACH * LONG
        found = paired_times(batches(machine), clock=time.process_time)
        rates = {key: per / ENVIRONMENT / seconds / 1e6 for key, (seconds, _) in found.items()}
        show(
            f"{name}: a step of one of {EACH} machines",
            found,
            "ns",
            per=per,
            notes={key: f"{rate:.2f} million environment steps of 10 ms a second" for key, rate in rates.items()},
        )
    print(f"\n{time.perf_counter() - begun:.0f} s in all")


if __name__ == "__main__":
    main()
