"""Every machine that comes with the package, moved step by step: the bits of runs, single and side by side, compiled and in plain Python."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from helpers.held_levers import held_scenario, random_levers, random_split
from polydraulic import BatchSimulator, Simulator, load_machine, simulate
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import machine_names

LAYOUTS = [name for name in machine_names() if isinstance(load_machine(name), LayoutMachine)]
TIP = ("effector.x", "effector.y", "effector.z")
pytestmark = pytest.mark.slow  # each layout is compiled for tens of seconds


@pytest.mark.parametrize("name", LAYOUTS)
def test_steps_have_the_bits_of_runs(name):
    machine, rng = load_machine(name), np.random.default_rng(0)
    levers = random_levers(1, 600, len(machine.names), each=30, limit=0.9)
    run = simulate(machine, "exact", held_scenario(machine, levers, 5e-3))
    events, k = [], 0
    with Simulator(machine) as sim:
        for lever in levers[::30]:
            for n in random_split(rng, 30):
                sim.restore(sim.save())
                sim.step(lever, n=n)
                events, k = events + sim.events, k + n
                for column in run.names:
                    if column not in TIP and column != "time" and not column.endswith("voltage"):
                        assert float(sim[column]) == run[column][k], (column, k)
    assert sorted(events) == sorted(run.info["events"])
    assert np.allclose([sim[axis] for axis in TIP], [run[axis][-1] for axis in TIP], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", LAYOUTS)
def test_lanes_have_the_bits_of_single_machines(name):
    machine = load_machine(name)
    levers = np.stack([random_levers(i, 120, len(machine.names), each=30, limit=0.9) for i in range(70)])
    with BatchSimulator(machine, 70, threads=2) as many, Simulator(machine) as one:
        for k in range(0, 120, 2):
            many.step(levers[:, k], n=2)
        for i in (0, 31, 63, 64, 69):
            one.reset()
            for k in range(0, 120, 30):
                one.step(levers[i, k], n=30)
            assert all(many[column][i] == one[column] for column in many.outputs)


PLAIN = """
import sys
import numpy as np
from polydraulic import Simulator, load_machine
machine = load_machine(sys.argv[1])
sim = Simulator(machine)
rows = []
for k in range(6):
    sim.step(np.full(len(machine.names), 0.7 - 0.28 * k), n=k + 1)
    rows.append(sim.values.copy())
np.save(sys.argv[2], rows)
"""


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
@pytest.mark.parametrize("name", LAYOUTS)
def test_plain_python_has_the_bits_of_compiled_code(name, tmp_path):
    for way, off in (("plain", "1"), ("compiled", "0")):
        subprocess.run(
            [sys.executable, "-c", PLAIN, name, tmp_path / f"{way}.npy"],
            check=True,
            env={**os.environ, "NUMBA_DISABLE_JIT": off},
        )
    assert np.load(tmp_path / "plain.npy").tobytes() == np.load(tmp_path / "compiled.npy").tobytes()
