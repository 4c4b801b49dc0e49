"""The valves of every shipped machine, learnt in haste (of the quick one: in great haste) from their exact circuits: runs with these networks."""

import ctypes
import os
import subprocess
import sys
from dataclasses import replace

import numba
import numpy as np
import pytest

from helpers.mechanical_energy import joint_columns
from helpers.unlocked import unlocked_scenarios
from polydraulic import build_flow, load_machine, load_models, random_operator, save_models, simulate, simulate_batch
from polydraulic.export import export_machine
from polydraulic.export.fmu.machine_parameters import direct_parameters
from polydraulic.export.machine import machine_parts
from polydraulic.flow import TrainingEffort, train_layout
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import machine_names
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.layout.runs import step_inputs

MACHINES = {name: load_machine(name) for name in machine_names()}
LAYOUTS = [name for name, m in MACHINES.items() if isinstance(m, LayoutMachine) and not m.crossovers]
QUICK = "wheel_loader"  # each layout is compiled once, for tens of seconds
EACH = [pytest.param(name, marks=[] if name == QUICK else pytest.mark.slow) for name in LAYOUTS]
CLOSE = 0.1  # of the motion of a joint, at every time


@pytest.fixture(scope="module", params=EACH)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def plant(name):
    return load_machine(name)


@pytest.fixture(scope="module")
def models(name, plant, tmp_path_factory):
    """Networks, as they are read from a file."""
    path = tmp_path_factory.mktemp("learnt") / "networks.json"
    effort = TrainingEffort(0.1, 4, 150) if name == QUICK else TrainingEffort(0.01, 27, 400)
    save_models(train_layout(plant, effort=effort), path)
    return load_models(path)


@pytest.fixture(scope="module")
def flow(plant, models):
    return build_flow("polynomial", plant, models=models)


def test_the_machines_own_work_is_done_as_by_its_valves(name, plant, flow):
    for scenario in unlocked_scenarios(name):
        exact, learnt = (simulate(plant, model, scenario) for model in ("exact", flow))
        assert learnt.info["flow"] == "polynomial"
        (wanted, _), (found, _) = joint_columns(plant, exact), joint_columns(plant, learnt)
        assert np.all(np.abs(found - wanted).max(axis=0) < CLOSE * np.ptp(wanted, axis=0)), scenario
        for c in plant.circuits:  # oil is neither made nor lost
            inlets = sum(learnt[f"{f}.q_in"] for f in c.functions)
            gap = learnt[f"{c.name}.q_pump"] - inlets - learnt[f"{c.name}.q_bypass"]
            assert np.abs(gap).max() <= 1e-9 * c.pump.flow
            assert min(learnt[f"{f}.q_in"].min() for f in c.functions) >= 0.0
            assert learnt[f"{c.name}.q_bypass"].min() >= -1e-9 * c.pump.flow


def test_steps_outside_of_what_networks_know_are_counted(plant, models):
    """Networks that know the first function's pressure up to 1 MPa alone."""
    function, steps = plant.names[0], 200

    def narrowed(model):
        if model.output.name != f"{function}.q_in":
            return model
        place = [variable.name for variable in model.inputs].index(f"{function}.p_in")
        high = [tuple(1e6 if k == place else x for k, x in enumerate(network.x_high)) for network in model.networks]
        low = [
            tuple(min(pair) for pair in zip(network.x_low, of, strict=True))
            for network, of in zip(model.networks, high, strict=True)
        ]
        networks = zip(model.networks, low, high, strict=True)
        return replace(model, networks=tuple(replace(network, x_low=a, x_high=b) for network, a, b in networks))

    flow = build_flow("polynomial", plant, models=[narrowed(model) for model in models])
    whole = {f: Constant(0.6) for f in plant.names}
    run = simulate(plant, flow, Scenario("lever", 5e-3 * steps, whole), dt=5e-3)
    above = run[f"{function}.p_in"] > 1e6
    # the pressure at the start of a step counts; at the end of one a row is recorded
    assert run.info["steps_out_of_domain"] == pytest.approx(above[:-1].sum(), abs=2)
    assert run.info["steps_out_of_domain"] > 0


PLAIN = """
import sys
import numpy as np
from polydraulic import build_flow, load_machine, load_models, simulate
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant

plant = load_machine(sys.argv[1])
volts = {f: Constant(0.7 if place % 2 else -0.7) for place, f in enumerate(plant.names)}
flow = build_flow("polynomial", plant, models=load_models(sys.argv[2]))
run = simulate(plant, flow, Scenario("all at once", 0.2, volts), dt=5e-3)
np.save(sys.argv[3], np.column_stack([run[name] for name in run.names]))
"""


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_plain_python_has_the_bits_of_compiled_code(name, plant, models, flow, tmp_path):
    save_models(models, tmp_path / "networks.json")
    subprocess.run(
        [sys.executable, "-c", PLAIN, name, tmp_path / "networks.json", tmp_path / "plain.npy"],
        check=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
    )
    volts = {f: Constant(0.7 if place % 2 else -0.7) for place, f in enumerate(plant.names)}
    run = simulate(plant, flow, Scenario("all at once", 0.2, volts), dt=5e-3)
    compiled = np.column_stack([run[column] for column in run.names])
    assert len(compiled) == 41
    assert np.load(tmp_path / "plain.npy").tobytes() == compiled.tobytes()


@pytest.mark.slow  # lanes of networks are compiled for cat215b in tests/simulation/batch
def test_batches_have_the_bits_of_single_runs(plant, flow):
    operators = [random_operator(seed, 0.5, functions=plant.names) for seed in range(5)]
    batch = simulate_batch(
        plant, flow, operators, keep=["rows", "range"], columns=[f"{plant.names[0]}.p_in", f"{plant.names[0]}.q_in"]
    )
    assert batch.info["flow"] == "polynomial"
    for place, operator in enumerate(operators):
        run = simulate(plant, flow, operator)
        rows = np.column_stack([run[column] for column in batch.names])
        assert batch.rows[place].tobytes() == rows.tobytes()
        assert np.array_equal(batch.highest[place], rows.max(axis=0))
    whole = simulate_batch(plant, flow, operators[:1])
    assert set(whole.names) == {*run.names} - {"time"} - {f"{f}.voltage" for f in plant.names}


def test_an_fmu_offers_no_parameters_that_networks_were_learnt_with(plant, flow):
    exact, learnt = ({p.name for p in direct_parameters(plant, model)} for model in ("exact", flow))
    assert exact - learnt == {name for name in exact if name.startswith(("circuits.", "tank.return"))}
    assert learnt


@pytest.mark.slow
def test_exported_c_has_the_bits_of_a_run(plant, flow, tmp_path):
    operator = random_operator(1, 1.0, functions=plant.names)
    run = simulate(plant, flow, operator)
    export_machine(plant, flow, tmp_path, name="learnt")
    sources = [str(tmp_path / f"learnt{part}.c") for part in ("", "_kernels", "_parameters")]
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fPIC", "-shared"]
    subprocess.run(["gcc", *flags, *sources, "-o", tmp_path / "learnt.so", "-lm"], check=True)
    library, parts = ctypes.CDLL(str(tmp_path / "learnt.so")), machine_parts(plant, flow)
    memory = (ctypes.c_double * parts.size)()
    assert library.learnt_init(memory) == 0
    names = [name for name, _ in parts.outputs]
    compared = [name for name in run.names if name in names and not name.startswith("effector")]
    for k, volts in enumerate(step_inputs(plant, operator, np.arange(len(run["time"]) - 1) * 5e-3)):
        library.learnt_step(memory, (ctypes.c_double * len(volts))(*volts))
        found = dict(zip(names, memory, strict=False))
        assert all(found[name] == run[name][k + 1] for name in compared), k
