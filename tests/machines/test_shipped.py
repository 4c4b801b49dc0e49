"""Every machine that comes with the package and is described by links, functions and circuits: one body of tests for all of them."""

import ctypes
import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from helpers.mechanical_energy import joint_columns, joint_power, mechanical_energy
from helpers.unlocked import unlocked_scenarios
from polydraulic import load_machine, random_operator, simulate, simulate_batch
from polydraulic.export import export_machine, export_machine_fmu
from polydraulic.export.machine import machine_parts
from polydraulic.parameters.layout.parts import Effects, FlowForce
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.layout.usual import unusual
from polydraulic.parameters.load import machine_names
from polydraulic.parameters.scenario import Scenario, scenario_names
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.layout.runs import step_inputs

LAYOUTS = [name for name in machine_names() if isinstance(load_machine(name), LayoutMachine)]
QUICK = "wheel_loader"  # each layout is compiled once, for tens of seconds
EACH = [pytest.param(name, marks=[] if name == QUICK else pytest.mark.slow) for name in LAYOUTS]
SECONDS = 2.0


@pytest.fixture(scope="module", params=EACH)
def plant(request):
    return load_machine(request.param)


@pytest.fixture(scope="module")
def run_of(plant, request):
    """A run by scenario and step, made once."""
    made = {}

    def run(scenario, dt=5e-3):
        if (scenario, dt) not in made:
            made[scenario, dt] = simulate(plant, "exact", scenario, dt=dt)
        return made[scenario, dt]

    return run


@pytest.fixture(scope="module")
def runs(plant, run_of):
    """Two seconds of two random operators, and those of the machine's own scenarios that hold no function."""
    name = next(name for name in LAYOUTS if load_machine(name) == plant)
    return [run_of(scenario) for scenario in (f"random:1:{SECONDS}", f"random:2:{SECONDS}", *unlocked_scenarios(name))]


@pytest.mark.parametrize("name", LAYOUTS)
def test_files_hold_nothing_unusual(name, call):
    assert unusual(load_machine(name)) == []
    code, out, _ = call("machine", "check", name)
    assert code == 0
    assert "warning" not in out
    assert out.rstrip().endswith(f"{name}: good")


@pytest.mark.parametrize("name", LAYOUTS)
def test_each_has_a_scenario_of_its_own(name):
    assert scenario_names(name)


def test_pump_flow_is_inlets_bypass_and_relief(plant, runs):
    for run in runs:
        assert run.info["steps_not_converged"] == 0
        for c in plant.circuits:
            inlets = sum(run[f"{f}.q_in"] for f in c.functions)
            given = sum(run[f"{x.giving}.q_cross"] for x in plant.crossovers if x.giving == c.name)
            taken = sum(run[f"{x.giving}.q_cross"] for x in plant.crossovers if x.taking == c.name)
            out = inlets + run[f"{c.name}.q_bypass"] + run[f"{c.name}.q_relief"] + given
            gap = run[f"{c.name}.q_pump"] + taken - out
            assert np.abs(gap).max() <= 1e-9 * c.pump.flow


def test_everything_is_a_number_and_stays_where_it_may_be(plant, runs):
    for run in runs:
        assert all(np.isfinite(run[name]).all() for name in run.names)
        positions, rates = joint_columns(plant, run)
        for place, f in enumerate(plant.functions):
            assert f.stops.low <= positions[:, place].min()
            assert positions[:, place].max() <= f.stops.high
            for port in ("p_a", "p_b"):
                p = run[f"{f.name}.{port}"]
                assert plant.tank.floor <= p.min()
                assert p.max() <= f.line.relief
        assert np.abs(rates).max() < 6.0  # rad/s and m/s
        for c in plant.circuits:
            p = run[f"{c.name}.p_pump"]
            assert plant.tank.return_pressure <= p.min()
            assert p.max() <= c.pump.relief * (1.0 + 1e-12)


def test_its_scenarios_move_every_function(plant, runs):
    moved = np.max([np.ptp(joint_columns(plant, run)[0], axis=0) for run in runs[2:]], axis=0)
    for f, far in zip(plant.functions, moved, strict=True):
        assert far > 0.05 * min(f.stops.high - f.stops.low, np.pi), f.name


def test_left_alone_it_comes_to_rest_where_it_stands(plant):
    """The pressures at the start carry it, and friction does not drive it to and fro within steps of 5 ms."""
    run = simulate(plant, "exact", Scenario("nobody", 5.0, {}), dt=5e-3)
    positions, rates = joint_columns(plant, run)
    assert np.abs(positions[-1] - positions[0]).max() < 3e-3  # rad and m
    assert np.abs(rates[-1]).max() < 1e-6


def _energy_gap(plant, run):
    """Change of energy less the work done on the joints, over the steps in which no joint is at a stop, and the work in all, J."""
    positions, _ = joint_columns(plant, run)
    low, high = (np.array([getattr(f.stops, end) for f in plant.functions]) for end in ("low", "high"))
    at_stop = ((positions <= low) | (positions >= high)).any(axis=1)
    free = ~(at_stop[1:] | at_stop[:-1])
    power = joint_power(plant, run)
    change, work = np.diff(mechanical_energy(plant, run)), 0.5 * (power[1:] + power[:-1]) * np.diff(run["time"])
    return (change - work)[free].sum(), np.abs(work[free]).sum()


def test_energy_is_what_oil_has_worked_less_friction_to_the_order_of_the_integrator(plant, run_of):
    gaps, scale = [], 0.0
    for dt in (5e-3, 2.5e-3):
        gap, scale = _energy_gap(plant, run_of(f"random:1:{SECONDS}", dt))
        gaps.append(abs(gap))
    assert scale > 1e3
    assert gaps[0] < 0.02 * scale
    assert 0.4 * gaps[0] < gaps[1] < 0.6 * gaps[0]


def test_the_account_of_energy_is_that_of_the_columns(plant):
    run = simulate(plant, "exact", f"random:1:{SECONDS}", energy=True)
    stored, own = run["energy.kinetic"] + run["energy.potential"], mechanical_energy(plant, run)
    assert np.allclose(stored - stored[0], own - own[0], rtol=0.0, atol=1e-9 * (np.abs(own).max() + np.ptp(own)))
    power = sum(run[f"{f}.joint_power"] - run[f"{f}.friction_power"] for f in plant.names)
    assert np.allclose(power, joint_power(plant, run), rtol=0.0, atol=1e-9 * np.abs(power).max())


@pytest.mark.slow
def test_exported_c_has_the_bits_of_a_run(plant, tmp_path):
    operator = random_operator(1, SECONDS, functions=plant.names)
    run = simulate(plant, "exact", operator)
    export_machine(plant, "exact", tmp_path, name="shipped")
    sources = [str(tmp_path / f"shipped{part}.c") for part in ("", "_kernels", "_parameters")]
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fPIC", "-shared"]
    subprocess.run(["gcc", *flags, *sources, "-o", tmp_path / "shipped.so", "-lm"], check=True)
    library, parts = ctypes.CDLL(str(tmp_path / "shipped.so")), machine_parts(plant, "exact")
    memory = (ctypes.c_double * parts.size)()
    assert library.shipped_init(memory) == 0
    names = [name for name, _ in parts.outputs]
    compared = [name for name in run.names if name in names and not name.startswith("effector")]
    assert len(compared) >= 7 * len(plant.names)
    inputs = step_inputs(plant, operator, np.arange(len(run["time"]) - 1) * 5e-3)
    for k, volts in enumerate(inputs):
        assert library.shipped_step(memory, (ctypes.c_double * len(volts))(*volts)) == 0
        found = dict(zip(names, memory, strict=False))
        assert all(found[name] == run[name][k + 1] for name in compared), k


@pytest.mark.slow
def test_an_fmu_runs_as_the_machine_does(plant, tmp_path):
    fmpy = pytest.importorskip("fmpy")
    operator = random_operator(1, SECONDS, functions=plant.names)
    run, path = simulate(plant, "exact", operator), tmp_path / "shipped.fmu"
    export_machine_fmu(plant, "exact", path, version=3, name="shipped")
    t = run["time"][:-1]
    columns = {"time": t} | {
        f"{f}.voltage": v for f, v in zip(plant.names, operator.voltages(t, plant.names).T, strict=True)
    }
    signals = np.array(list(zip(*columns.values(), strict=True)), dtype=[(name, np.float64) for name in columns])
    outputs = [name for name in run.names if name.endswith((".angle", ".position", ".p_a", ".p_pump"))]
    found = fmpy.simulate_fmu(
        str(path), input=signals, output=outputs, output_interval=5e-3, step_size=5e-3, stop_time=SECONDS / 2
    )
    assert len(found) == 201
    for name in outputs:
        assert np.allclose(found[name], run[name][:201], rtol=1e-9, atol=1e-9), name


PLAIN = """
import sys
import numpy as np
from polydraulic import load_machine, simulate
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant

plant = load_machine(sys.argv[1])
volts = {f: Constant(0.7 if place % 2 else -0.7) for place, f in enumerate(plant.names)}
run = simulate(plant, "exact", Scenario("all at once", 0.1, volts), dt=5e-3)
np.save(sys.argv[2], np.column_stack([run[name] for name in run.names]))
"""


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_plain_python_has_the_bits_of_compiled_code(plant, tmp_path):
    name = next(name for name in LAYOUTS if load_machine(name) == plant)
    subprocess.run(
        [sys.executable, "-c", PLAIN, name, tmp_path / "plain.npy"],
        check=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
    )
    volts = {f: Constant(0.7 if place % 2 else -0.7) for place, f in enumerate(plant.names)}
    run = simulate(plant, "exact", Scenario("all at once", 0.1, volts), dt=5e-3)
    compiled = np.column_stack([run[name] for name in run.names])
    assert len(compiled) == 21
    assert np.load(tmp_path / "plain.npy").tobytes() == compiled.tobytes()


@pytest.mark.slow
def test_lanes_have_the_bits_of_single_runs(plant):
    operators = [
        random_operator(seed, 1.0, functions=plant.names) for seed in range(70)
    ]  # more than stand side by side
    batch = simulate_batch(plant, "exact", operators, keep=["rows"])
    for place in (0, 31, 63, 64, 69):
        run = simulate(plant, "exact", operators[place])
        assert batch.rows[place].tobytes() == np.column_stack([run[name] for name in batch.names]).tobytes()


@pytest.mark.slow
def test_with_friction_that_holds_play_hysteresis_and_flow_forces(plant, run_of):
    """All effects that a function may have: the bits of lanes, losses that are none, and something that differs."""
    force = FlowForce(7e4, 870.0, np.radians(69.0))  # which steps of 5 ms follow in all machines
    plays = {f.name: 1e-3 if plant.link(f.moves).joint == "prismatic" else 2e-3 for f in plant.functions}
    worn = plant._replace(
        functions=tuple(f._replace(effects=Effects(True, plays[f.name], 2e-4, force)) for f in plant.functions)
    )
    operators = [random_operator(seed, SECONDS, functions=plant.names) for seed in (1, 2)]
    run = simulate(worn, "exact", operators[0], energy=True, forces=True)
    assert all(np.isfinite(run[name]).all() for name in run.names)
    assert all(run[f"{f}.friction_power"].min() >= 0.0 for f in plant.names)
    assert all(np.abs(run[f"{f}.gap"]).max() <= 0.5 * plays[f] for f in plant.names)
    smooth = run_of(f"random:1:{SECONDS}")
    last = plant.names[-1]
    assert max(np.abs(run[f"{f}.spool"] - smooth[f"{f}.spool"]).max() for f in plant.names) >= 1e-4
    assert np.array_equal(run[f"{last}.voltage"], smooth[f"{last}.voltage"])
    batch = simulate_batch(worn, "exact", operators, keep=["rows"])
    again = simulate(worn, "exact", operators[1])
    assert batch.rows[1].tobytes() == np.column_stack([again[name] for name in batch.names]).tobytes()


# What a full lever does, as data sheets of the classes say it: seconds from stop to stop, or revolutions in a minute.
TIMES = {
    "excavator_22t": {
        ("boom", 1): (3.0, 5.5),
        ("boom", -1): (2.0, 4.0),
        ("stick", -1): (3.0, 5.5),
        ("bucket", -1): (2.5, 5.0),
    },
    "loader_crane": {("inner", 1): (5.0, 9.0), ("outer", 1): (3.0, 7.0), ("reach", 1): (3.0, 7.0)},
    "wheel_loader": {("lift", 1): (5.0, 6.5), ("lift", -1): (2.5, 4.5), ("tilt", -1): (1.5, 3.0)},
}
SPEEDS = {"excavator_22t": ("swing", 8.0, 12.0), "loader_crane": ("slew", 2.0, 4.0)}


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n == QUICK else pytest.mark.slow) for n in TIMES])
def test_a_full_lever_takes_as_long_as_on_a_real_machine(name):
    plant = load_machine(name)
    for (function, side), (least, most) in TIMES[name].items():
        f = plant.function(function)
        begin, end = (f.stops.low, f.stops.high) if side > 0 else (f.stops.high, f.stops.low)
        begun = f._replace(initial=f.initial._replace(angle=begin))
        there = plant._replace(functions=tuple(begun if g.name == function else g for g in plant.functions))
        run = simulate(there, "exact", Scenario("full lever", 12.0, {function: Constant(0.8 * side)}), dt=5e-3)
        position = run[f"{function}.{'position' if plant.link(f.moves).joint == 'prismatic' else 'angle'}"]
        assert least < run["time"][np.abs(position - end) < 1e-9][0] < most, (function, side)
    if name in SPEEDS:
        function, least, most = SPEEDS[name]
        run = simulate(plant, "exact", Scenario("full lever", 8.0, {function: Constant(0.8)}), dt=5e-3)
        assert least < run[f"{function}.rate"][-1] * 30.0 / np.pi < most
