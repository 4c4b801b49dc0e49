"""The energy account closes, and force and payload at the tip act as mechanics says."""

import numpy as np
import pytest

from polydraulic import load_machine, simulate, simulate_batch
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.scenario import Scenario, random_operator
from polydraulic.parameters.signals import Constant, Sine


@pytest.fixture(scope="module")
def loads():
    return Loads({"x": Sine(400.0, 3.0), "z": Constant(-300.0)})


def mechanical_gap(run, names):
    """Energy that the account loses of what has been put in, over a run without stops, J."""
    power = sum(run[f"{f}.joint_power"] - run[f"{f}.friction_power"] for f in names) + run["tip.push_power"]
    stored = run["energy.kinetic"] + run["energy.potential"]
    put_in = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(run["time"]))])
    return np.abs(stored - stored[0] - put_in).max(), np.ptp(stored)


def test_the_mechanical_account_closes_with_the_step(crane, loads):
    gaps = []
    for dt in (4e-3, 2e-3, 1e-3):
        scenario = random_operator(2, 1.6, functions=crane.names)
        scenario = Scenario(scenario.name, scenario.duration, scenario.voltage, loads=loads)
        run = simulate(crane, "exact", scenario, dt=dt, energy=True)
        assert not [event for event in run.info["events"] if "stop" in event[2]]
        gap, moved = mechanical_gap(run, crane.names)
        gaps.append(gap / moved)
    assert gaps[0] < 0.05
    assert gaps[1] < 0.6 * gaps[0]
    assert gaps[2] < 0.6 * gaps[1]


def test_the_pumps_power_goes_somewhere_and_no_loss_is_negative(crane):
    run = simulate(crane, "exact", "random:3:8", energy=True)
    for c in crane.circuits:
        assert run[f"{c.name}.throttling_power"].min() > -1e-6 * c.pump.flow * c.pump.relief
        assert run[f"{c.name}.relief_power"].min() >= 0.0
    for f in crane.names:
        assert run[f"{f}.friction_power"].min() >= 0.0
        assert run[f"{f}.outlet_power"].min() >= 0.0
    assert run.unit("main.pump_power") == "W"
    assert run.unit("energy.kinetic") == "J"


def stored_gaps(run, p_return):
    """Energy that the oil before the valves of each circuit loses of what it was given, over what it has moved, and its account's largest flaw."""
    for name, of in run.info["circuits"].items():
        energy, power = run[f"{name}.stored_energy"], run[f"{name}.stored_power"]
        given = np.concatenate([[0.0], np.cumsum(power[1:] * np.diff(run["time"]))])
        yield np.abs(energy - energy[0] - given).max() / np.ptp(energy)
        parts = sum(run[f"{name}.{what}_power"] for what in ("relief", "throttling", "stored"))
        entered = sum(run[f"{f}.q_in"] * run[f"{f}.p_in"] for f in of)
        back = run[f"{name}.pump_power"] - parts - entered
        assert np.abs(back - run[f"{name}.q_bypass"] * p_return).max() < 1e-6
        assert run[f"{name}.throttling_power"].min() > -1e-6


@pytest.mark.parametrize("flow", ["stiff", pytest.param("tlm", marks=pytest.mark.slow_to_compile)])
@pytest.mark.parametrize("name", ["wheel_loader", pytest.param("cat215b", marks=pytest.mark.slow_to_compile)])
def test_the_oil_before_the_valves_keeps_its_account(name, flow):
    p_return = load_machine(name).tank.return_pressure
    coarse, fine = (
        [*stored_gaps(simulate(name, flow, "random:3:2", t_end=1.5, dt=dt, energy=True), p_return)]
        for dt in (5e-3, 1.25e-3)
    )
    for far, near in zip(coarse, fine, strict=True):
        assert far < 0.3
        assert near < (0.3 if flow == "stiff" else 0.6) * far


def test_a_force_is_carried_by_the_pressures(crane):
    """Virtual work: what a slow force adds at the boom is force times how the tip moves with the angle."""
    still = Scenario("still", 4.0, {})
    pushed = Scenario("pushed", 4.0, {}, loads=Loads({"z": Constant(-2000.0)}))
    load = {}
    for scenario in (still, pushed):
        run = simulate(crane, "exact", scenario, dt=2e-3, energy=True)
        levers = (run["lift.p_a"], run["lift.p_b"])
        load[scenario.name] = levers, run["lift.angle"][-1], run["extend.position"][-1]
    f = crane.function("lift")
    head, rod = np.pi / 4 * f.drive.bore**2, np.pi / 4 * (f.drive.bore**2 - f.drive.rod**2)
    forces = {name: (p_a[-1] * head - p_b[-1] * rod) for name, ((p_a, p_b), _, _) in load.items()}
    _, angle, out = load["pushed"]
    reach = (1.8 + out + 1.5) * np.cos(angle)
    from polydraulic.parameters.layout.geometry import lever

    arm = lever(f, crane.link("boom"), angle)
    friction = 2 * f.friction.static / arm  # either way
    assert forces["pushed"] - forces["still"] == pytest.approx(2000.0 * reach / arm, abs=friction)


def test_a_payload_that_comes_and_goes_weighs_as_long_as_it_is_there(crane):
    scenario = Scenario("lift and drop", 6.0, {}, loads=Loads(payload=Payload((2.0, 4.0), (150.0, 0.0))))
    run = simulate(crane, "exact", scenario, dt=2e-3, energy=True)
    p = run["lift.p_a"]
    before, during, after = (p[(run["time"] > a - 0.3) & (run["time"] < a)].mean() for a in (2.0, 4.0, 6.0))
    assert during > 1.2 * before
    assert after < 0.5 * (before + during)
    again = simulate(crane, "exact", scenario, dt=2e-3, every=4)
    assert np.array_equal(again["lift.angle"], run["lift.angle"][::4])


@pytest.mark.slow_to_compile
def test_forces_in_lanes_have_the_bits_of_single_runs(crane, loads):
    scenarios = [
        Scenario(f"s{k}", 1.0, random_operator(k, 1.0, functions=crane.names).voltage, loads=loads) for k in range(3)
    ]
    batch = simulate_batch(crane, "exact", scenarios, keep=["rows"])
    run = simulate(crane, "exact", scenarios[2])
    assert all(np.array_equal(batch[name][2], run[name]) for name in batch.names)
    assert "doubtful_inputs" not in {**batch.info, **run.info}  # forces are no voltages


def test_what_passes_a_crossover_is_given_by_one_pump_and_gained_by_the_other(joined_crane):
    run = simulate(joined_crane, "exact", "random:3:8", energy=True)
    both, left = 0.0, 0.0
    for c in joined_crane.circuits:
        both = both + run[f"{c.name}.pump_power"] - run[f"{c.name}.relief_power"] - run[f"{c.name}.throttling_power"]
        assert run[f"{c.name}.throttling_power"].min() > -1e-6 * c.pump.flow * c.pump.relief
        left = left + run[f"{c.name}.q_bypass"] * joined_crane.tank.return_pressure
    given = run["main_giving.cross_power"]
    assert np.allclose(given, run["main_giving.q_cross"] * run["main_taking.p_between"], rtol=1e-12)
    assert given.max() > 100.0
    left = left + sum(run[f"{f}.q_in"] * run[f"{f}.p_in"] for f in joined_crane.names)
    assert np.allclose(both, left, rtol=0.0, atol=1e-9 * both.max())
