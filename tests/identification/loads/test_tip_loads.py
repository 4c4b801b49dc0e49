"""Payload and force at the tip against what hung and pushed there in simulated logs, and what their errors say."""

from dataclasses import replace

import numpy as np
import pytest

from polydraulic import InputError, load_machine, random_operator, simulate
from polydraulic.identification import estimate_payload, estimate_tip_force
from polydraulic.identification.loads.tip_loads import load_table
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant
from polydraulic.tables import Table

LIFTS = {"lift": Constant(0.6)}
NOISE = {"angle": np.radians(0.03), "position": 1e-3, "p_a": 1e5, "p_b": 1e5}


def log_of(machine, scenario, seed, noise=1.0):
    run = simulate(machine, "exact", scenario, every=4)
    rng = np.random.default_rng(seed)
    kept = [name for name in run.names if name == "time" or name.split(".")[-1] in NOISE]
    sigma = {name: noise * NOISE.get(name.split(".")[-1], 0.0) for name in kept}
    return Table(
        {name: run[name] + rng.normal(0.0, sigma[name], len(run)) for name in kept},
        {name: run.unit(name) for name in kept},
    )


def hung(mass):
    return Loads({}, Payload((0.0,), (mass,)))


def pushed(force):
    return Loads({c: Constant(value) for c, value in zip("xyz", force, strict=True)}, None)


@pytest.fixture(scope="module")
def loader():
    return load_machine("wheel_loader").with_values({"functions.lift.initial.angle": -0.5})


def test_without_noise_a_steady_motion_gives_the_payload(loader):
    lifted = Scenario("lift", 6.0, LIFTS, loads=hung(700.0))
    found = estimate_payload(loader, log_of(loader, lifted, 0, noise=0.0), window=1.0)
    np.testing.assert_allclose(found.payload[2:], 700.0, rtol=0, atol=1.0)


def test_a_payload_is_found_within_its_error(loader):
    for seed, mass in enumerate((0.0, 1500.0)):
        work = replace(random_operator(seed, 20.0, functions=loader.names), loads=hung(mass))
        found = estimate_payload(loader, log_of(loader, work, seed))
        assert abs(found.mean - mass) < 2.0 * found.mean_error
        assert found.mean_error < 120.0
        off = np.abs(found.payload - mass)
        assert (off <= 2.0 * found.error).mean() > 0.8


def test_a_sensor_that_is_silent_is_a_gap_and_others_that_are_not_needed_are_none(loader):
    lifted = Scenario("lift", 6.0, LIFTS, loads=hung(700.0))
    log = log_of(loader, lifted, 0, noise=0.0)
    pressure = np.where((log["time"] > 3.05) & (log["time"] < 3.25), np.nan, log["lift.p_a"])
    columns = dict(log.columns) | {"lift.p_a": pressure, "cab.heat": np.full(len(log), np.nan)}
    found = estimate_payload(loader, Table(columns, log.units).partial(), window=1.0)
    whole = estimate_payload(loader, log, window=1.0)
    assert 2 < len(found.time) < len(whole.time)
    np.testing.assert_allclose(found.payload[2:], 700.0, rtol=0, atol=2.0)


def test_at_rest_static_friction_is_in_the_error(loader):
    """4 and 5.6 kN m of static friction, over the root of three, hold what weighs as much at the tip."""
    still = estimate_payload(loader, log_of(loader, Scenario("rest", 6.0, {}, loads=hung(500.0)), 1))
    moving = estimate_payload(loader, log_of(loader, Scenario("lift", 6.0, LIFTS, loads=hung(500.0)), 1))
    assert abs(still.mean - 500.0) < still.mean_error
    assert np.median(still.error) > 30.0
    assert moving.error.min() < 0.7 * np.median(still.error)


def test_a_force_is_found_in_the_plane_that_joints_feel(loader):
    push = (1500.0, 0.0, -2500.0)
    found = estimate_tip_force(loader, log_of(loader, Scenario("lift", 6.0, LIFTS, loads=pushed(push)), 3))
    assert np.isinf(found.error[:, 1]).all()  # no joint of a loader feels y
    assert np.isnan(found.force[:, 1]).all()
    off = found.force[:, [0, 2]] - np.array(push)[[0, 2]]
    assert np.abs(off[:, 1]).max() < 600.0
    assert (np.abs(off) <= 2.0 * found.error[:, [0, 2]]).mean() > 0.9
    table = load_table(found)
    assert list(table.names) == ["time", "force_x", "force_x_error", "force_z", "force_z_error"]


def test_a_known_payload_is_no_force(loader):
    log = log_of(loader, Scenario("lift", 5.0, LIFTS, loads=hung(800.0)), 4)
    with_it, without = (estimate_tip_force(loader, log, payload=mass).force[1:, 2] for mass in (800.0, 0.0))
    assert np.abs(with_it).max() < 600.0
    np.testing.assert_allclose(without - with_it, -800.0 * 9.81, rtol=0.1)


@pytest.mark.slow  # compiles another machine
@pytest.mark.parametrize("seed", [21, 22])
def test_payload_and_force_of_an_excavator_are_as_close_as_published(seed):
    machine = load_machine("excavator_22t")
    work = replace(random_operator(seed, 40.0, functions=machine.names), loads=hung(2000.0))
    assert abs(estimate_payload(machine, log_of(machine, work, seed)).mean - 2000.0) < 20.0  # 1 % of 2 t
    force = np.array([-3000.0, 2000.0, 4000.0])
    steady = Scenario("pushed", 8.0, {f: Constant(0.3) for f in ("swing", "boom", "stick")}, loads=pushed(force))
    found = estimate_tip_force(machine, log_of(machine, steady, seed)).force
    assert np.linalg.norm(found - force, axis=1).max() < 400.0
    share = found @ force / np.linalg.norm(found, axis=1) / np.linalg.norm(force)
    assert np.degrees(np.arccos(share)).max() < 13.0


def test_logs_that_do_not_serve_are_refused(loader):
    log = log_of(loader, Scenario("rest", 3.0, {}), 0)
    with pytest.raises(InputError, match="no piece of the log lasts"):
        estimate_payload(loader, log, window=5.0)
    with pytest.raises(InputError, match="window = -1"):
        estimate_payload(loader, log, window=-1.0)
    columns = {name: log[name] for name in log.names if name != "lift.p_a"}
    with pytest.raises(InputError, match=r"lift\.p_a"):
        estimate_payload(loader, Table(columns, {name: log.unit(name) for name in columns}))


@pytest.mark.parametrize(
    ("quantity", "factor", "match"),
    [("p_", 1e-5, "must be in Pa"), ("angle", 180.0 / np.pi, "lift.angle.*must be in rad")],
)
def test_bar_and_degrees_are_not_taken_for_si(loader, quantity, factor, match):
    log = log_of(loader, Scenario("lift", 4.0, LIFTS), 0)
    other = Table({name: log[name] * (factor if quantity in name else 1.0) for name in log.names}, {})
    with pytest.raises(InputError, match=match):
        estimate_payload(loader, other)


@pytest.mark.parametrize("payload", [-5.0, np.nan, np.inf])
def test_a_known_payload_is_a_mass(loader, payload):
    with pytest.raises(InputError, match="payload = .* must be a mass"):
        estimate_tip_force(loader, log_of(loader, Scenario("lift", 4.0, LIFTS), 0), payload=payload)
