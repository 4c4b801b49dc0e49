"""Batches of machines of other layouts have the bits of single runs, and lanes that are vector instructions."""

import inspect
import re

import numba
import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import InputError, _kernel, load_machine, simulate, simulate_batch
from polydraulic.flow.lanes import LANES
from polydraulic.machine.circuits.series import passes
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import machine_names
from polydraulic.parameters.scenario import Scenario, random_operator
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.lane_blocks import LaneBlock
from polydraulic.simulation.layout.prepare import prepare_layout

# Each layout is compiled once, for tens of seconds: here the one whose lanes others compile, too; in plain Python the smallest.
QUICK = "wheel_loader" if numba.config.DISABLE_JIT else "cat215b"
LAYOUTS = [name for name in machine_names() if isinstance(load_machine(name), LayoutMachine)]
EACH = [pytest.param(name, marks=[] if name == QUICK else pytest.mark.slow) for name in LAYOUTS]
# stages that call others; those that take few machines, one by one
WHOLE = ("flow_stage", "circuit_stage", "cross_stage")
FEW = ("stop_stage", "repair_stage", "law_stage", "join_on_stage", "bracket_stage")


@pytest.fixture(scope="module")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))


@pytest.fixture(scope="module")
def heavy(crane):
    return crane._replace(links=tuple(link._replace(mass=1.3 * link.mass) for link in crane.links))


def operator(seed, functions, seconds=3.0):
    """A random hand; in plain Python, where a block takes 64 times as long as a machine, levers that are pulled at once."""
    if not numba.config.DISABLE_JIT:
        return random_operator(seed, seconds, functions=functions)
    volts = np.random.default_rng(seed).choice([-1.0, 1.0], len(functions)) * (1.0 + 0.1 * seed)
    return Scenario(f"pulled {seed}", 0.3, {name: Constant(v) for name, v in zip(functions, volts, strict=True)})


@pytest.mark.slow_to_compile
def test_machines_in_lanes_have_the_bits_of_single_ones(crane, heavy):
    scenarios = [operator(seed, crane.names) for seed in range(6)]
    machines = [crane, heavy, crane, heavy, crane, crane]
    batch = simulate_batch(machines, "exact", scenarios, keep=["rows"])
    for i in (0, 1, 5):
        run = simulate(machines[i], "exact", scenarios[i])
        for name in batch.names:
            assert np.array_equal(batch[name][i], run[name]), (i, name)
    assert not np.array_equal(batch["lift.angle"][0], batch["lift.angle"][2])
    assert batch.not_converged.sum() == 0
    assert batch.units["extend.position"] == "m"


def test_voltages_and_states_have_the_size_of_the_machine(crane):
    with pytest.raises(InputError, match=r"\(n_step, 3\)"):
        simulate_batch(crane, "exact", np.zeros((10, 4)))
    with pytest.raises(InputError, match=r"\(15,\)"):
        simulate_batch(crane, "exact", np.zeros((10, 3)), x0=np.zeros(20))
    with pytest.raises(InputError, match="extend voltage in step 2"):
        simulate_batch(crane, "exact", np.where(np.arange(30).reshape(10, 3) == 8, np.nan, 0.0))


def test_machines_of_different_layouts_do_not_mix(crane):
    with pytest.raises(InputError, match="2 layouts; a batch holds machines of one layout"):
        simulate_batch([crane, "cat215b"], "exact", np.zeros((10, 3)))


def limited(machine, **limit):
    """The machine with other torque limits."""
    circuits = (c._replace(pump=c.pump._replace(**limit)) for c in machine.circuits)
    return machine._replace(circuits=tuple(circuits))


@pytest.mark.parametrize("name", EACH)
def test_torque_limits_in_lanes_have_the_bits_of_single_machines(name):
    """With and without limit, of power and not, in one block."""
    machine = load_machine(name)
    start = min(0.1 * c.pump.relief for c in machine.circuits)
    on = {"torque_limit_enabled": True, "torque_limit_start": start}
    machines = [
        limited(machine, torque_limit_enabled=False),
        limited(machine, **on, torque_limit_exponent=1.0),
        limited(machine, **on, torque_limit_exponent=0.6),
    ]
    scenarios = [operator(seed, machine.names, 1.0) for seed in range(2)]
    for together in ([1], [0, 1, 2]):  # parameters that are shared, and rows of them
        cases = [(i, scenario) for i in together for scenario in scenarios]
        batch = simulate_batch([machines[i] for i, _ in cases], "exact", [s for _, s in cases], keep=["rows"])
        assert batch.not_converged.sum() == 0
        lowered = 0
        for place, (i, scenario) in enumerate(cases):
            run = simulate(machines[i], "exact", scenario)
            for column in batch.names:
                assert np.array_equal(batch[column][place], run[column]), (i, column)
            lowered += sum(run[f"{c.name}.q_pump"].min() < 0.99 * c.pump.flow for c in machine.circuits)
        assert lowered > 0


def assembly(stage, given):
    """Of a stage, compiled without the cache, which keeps none."""
    fresh = numba.njit(**_kernel._DRIVER_OPTIONS)(stage.py_func)
    fresh(*(given[name] for name in inspect.signature(stage.py_func).parameters))
    return fresh.inspect_asm(fresh.signatures[0])


def scalars(text):
    """Divisions and roots one by one."""
    return len(re.findall(r"\tv?(?:div|sqrt)sd\t", text))


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")
@pytest.mark.parametrize("name", EACH)
def test_every_stage_is_vector_instructions(name):
    """A stage that stays scalar would divide or take roots one by one; what is the same for all lanes is computed once."""
    machine = load_machine(name)
    ready = prepare_layout(machine, 5e-3)
    rows = np.zeros(ready.module.N_ROW * LANES)
    numbers = np.zeros(LANES, dtype=np.int64)
    block = LaneBlock(rows, np.arange(LANES), numbers, np.zeros((0, LANES)), np.zeros((0, LANES)))
    given = {
        "valves": ready.valves,
        "plant": ready.plant,
        "own": None,
        "rows": rows,
        "block": block,
        "limit": True,
        "power": False,
        "seen": np.full((3, len(machine.names), LANES), np.inf),
    }
    given |= {"inputs": np.zeros((1, 1, len(machine.names))), "k": 0, "n_step": 1}
    stages = {
        stage: function
        for stage, function in vars(ready.module).items()
        if re.search(r"_stage(_|$)", stage) and not stage.startswith((*WHOLE, *FEW))
    }
    circuits = sum(2 if len(c.functions) < 3 else 3 for c in machine.circuits)
    assert all(f"join_pass_stage_{x.name}" in stages for x in machine.crossovers)
    assert len(stages) >= circuits + 10
    texts = {stage: assembly(function, given) for stage, function in stages.items()}
    if not re.search(r"%[yz]mm", texts["position_stage"]):
        pytest.skip("this processor has no AVX")
    pump = getattr(ready.valves, f"pump_{machine.circuits[0].name}")
    single = {"Q": pump.flow, "last": 0.0, "least": 0.0, "whole": passes.Outlet(1.0, 0.0), "pump": pump, "still": False}
    law = scalars(assembly(passes.limited, single))  # by logarithms, which do not stay in lanes
    divides = 0
    for stage, text in texts.items():
        wide = len(re.findall(r"\tv(?:div|sqrt)pd\t[^\n]*%[yz]mm", text))
        own = scalars(text) - (law if stage.startswith("pass_stage") else 0)
        assert own <= min(wide, 2 if stage.startswith("join") else 1), stage  # of one pump, or two
        divides += wide > 0
    assert divides >= len(machine.circuits) + 3  # levers and motion, lines, joints
