"""Machines of other layouts as C and as FMUs: the bits of `simulate`."""

import ctypes
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from helpers.small_crane import crane_text_with_effects, write_crane
from polydraulic import InputError, load_machine, load_scenario, simulate
from polydraulic.export import export_machine, export_machine_fmu
from polydraulic.export.machine import machine_parts
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.parameters.loads import Loads
from polydraulic.parameters.scenario import Scenario, random_operator
from polydraulic.parameters.signals import Sine
from polydraulic.simulation.layout.runs import step_inputs


@pytest.fixture(scope="module")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))


@pytest.fixture(scope="module")
def scenario(crane):
    operator = random_operator(4, 3.0, functions=crane.names)
    return Scenario("pushed", 3.0, operator.voltage, loads=Loads({"y": Sine(200.0, 2.0)}))


@pytest.fixture(scope="module")
def run(crane, scenario):
    return simulate(crane, "exact", scenario)


@pytest.mark.parametrize("effects", [False, True])
def test_the_c_code_has_the_bits_of_a_run(crane, scenario, tmp_path, effects):
    if effects:
        (tmp_path / "effects.toml").write_text(crane_text_with_effects(), encoding="utf-8")
        crane, scenario = load_machine(tmp_path / "effects.toml"), replace(scenario, loads=Loads())
    force = not effects  # of one of the two, whose layout other tests compile as well
    # voltages that arrive late are those of times that rounding shifts by a bit
    crane = crane._replace(functions=tuple(f._replace(pilot=f.pilot._replace(dead_time=0.0)) for f in crane.functions))
    run = simulate(crane, "exact", scenario)
    export_machine(crane, "exact", tmp_path, name="crane", force=force)
    sources = [str(tmp_path / f"crane{part}.c") for part in ("", "_kernels", "_parameters")]
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fPIC", "-shared"]
    subprocess.run(["gcc", *flags, *sources, "-o", tmp_path / "crane.so", "-lm"], check=True)
    library = ctypes.CDLL(str(tmp_path / "crane.so"))
    parts = machine_parts(crane, "exact", force=force)
    memory = (ctypes.c_double * parts.size)()
    assert library.crane_init(memory) == 0
    inputs = step_inputs(crane, scenario, np.arange(600) * 5e-3)
    names = [name for name, _ in parts.outputs]
    assert ("lift.gap" in names) == effects
    for k in range(600):
        status = library.crane_step(memory, (ctypes.c_double * inputs.shape[1])(*inputs[k]))
        assert status == 0
        if k % 50 == 0:
            found = dict(zip(names, memory, strict=False))
            for name in run.names:
                if name in found and not name.startswith("effector"):
                    assert found[name] == run[name][k + 1], (name, k)
            assert found["effector.x"] == pytest.approx(run["effector.x"][k + 1], abs=1e-12)


@pytest.mark.parametrize("flow", ["stiff", pytest.param("tlm", marks=pytest.mark.slow)])
def test_c_code_with_volumes_before_the_valves_has_the_bits_of_a_run(flow, tmp_path):
    loader, scenario = load_machine("wheel_loader"), load_scenario("wheel_loader_cycle")
    loader = adapted(loader, scenario)
    loader = loader._replace(
        functions=tuple(f._replace(pilot=f.pilot._replace(dead_time=0.0)) for f in loader.functions)
    )
    run = simulate(loader, flow, scenario, t_end=1.0)
    export_machine(loader, flow, tmp_path, name="loader")
    sources = [str(tmp_path / f"loader{part}.c") for part in ("", "_kernels", "_parameters")]
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fPIC", "-shared"]
    subprocess.run(["gcc", *flags, *sources, "-o", tmp_path / "loader.so", "-lm"], check=True)
    library, parts = ctypes.CDLL(str(tmp_path / "loader.so")), machine_parts(loader, flow)
    names, memory = [name for name, _ in parts.outputs], (ctypes.c_double * parts.size)()
    assert library.loader_init(memory) == 0
    for k, inputs in enumerate(step_inputs(loader, scenario, np.arange(200) * 5e-3)):
        assert library.loader_step(memory, (ctypes.c_double * len(inputs))(*inputs)) == 0
        found = dict(zip(names, memory, strict=False))
        for name in ("work.p_pump", "work.p_between", "work.q_stored", "lift.angle"):
            assert found[name] == run[name][k + 1], (name, k)


@pytest.mark.parametrize("version", [2, 3])
def test_the_fmu_runs_and_takes_other_parameters(crane, scenario, run, tmp_path, version):
    import fmpy

    path = tmp_path / f"crane{version}.fmu"
    export_machine_fmu(crane, "exact", path, version=version, name="crane", force=True)
    description = fmpy.read_model_description(str(path), validate=True)
    variables = {v.name: v for v in description.modelVariables}
    assert variables["tip.force_y"].causality == "input"
    assert variables["extend.position"].unit == "m"
    assert "functions.lift.line.relief" in variables
    assert "circuits.main.pump.relief" not in variables
    columns = {"time": run["time"][:-1]}
    t = run["time"][:-1]
    columns |= {f"{f}.voltage": scenario.voltages(t, crane.names)[:, k] for k, f in enumerate(crane.names)}
    columns |= {f"tip.force_{c}": scenario.loads.forces(t)[:, k] for k, c in enumerate("xyz")}
    dtype = [(name, np.float64) for name in columns]
    signals = np.array(list(zip(*columns.values(), strict=True)), dtype=dtype)
    options = {
        "input": signals,
        "output": ["lift.angle", "extend.position"],
        "output_interval": 5e-3,
        "step_size": 5e-3,
        "stop_time": 1.0,
    }
    found = fmpy.simulate_fmu(str(path), **options)
    for name in ("lift.angle", "extend.position"):
        assert np.allclose(found[name], run[name][: len(found)], atol=1e-9)
    weak = fmpy.simulate_fmu(str(path), start_values={"functions.extend.line.relief": 1.1e6}, **options)
    assert np.abs(weak["extend.position"] - found["extend.position"]).max() > 5e-5


def test_what_a_layout_cannot_do_is_refused(crane, tmp_path):
    with pytest.raises(InputError, match="flow 'tlm' is for circuits of valves in series; .*: use 'exact'"):
        export_machine("cat215b_crossover", "tlm", tmp_path)
    with pytest.raises(InputError, match="flow 'lookup' is not exported at any size.*export flow 'exact', or networks"):
        export_machine(crane, "lookup", tmp_path)
    with pytest.raises(InputError, match="leave one of"):
        export_machine(crane, "exact", tmp_path, locked=crane.names)
    with pytest.raises(InputError, match="not a function of the machine"):
        export_machine(crane, "exact", tmp_path, locked=["boom"])
    assert not list(tmp_path.iterdir())
