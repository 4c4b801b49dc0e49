"""Margins of runs: at rest those of the centre of gravity, with inertia what the ground must bear, and tips that are foreseen."""

import numpy as np
import pytest

from polydraulic import InputError, load_machine, run_summary, simulate
from polydraulic.machine.frames import link_frames, vector
from polydraulic.machine.stability.statics import holding_pressures
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant, Piecewise


def loaded(machine, payload, volts, duration, start=1.0):
    """A scenario that begins with what holds the payload, and moves levers from a time on."""
    at = np.array([[f.initial.angle for f in machine.functions]])
    held = holding_pressures(machine, at, payload)[0]
    changes = {
        f.name: {"initial": {key: {"value": float(p), "unit": "Pa", "source": "holds"} for key, p in zip(("p_a", "p_b"), pair, strict=True)}}
        for f, pair in zip(machine.functions, held, strict=True)
    }  # fmt: skip
    lever = {name: Piecewise(np.array([0.0, start, start + 0.3]), np.array([0.0, 0.0, v])) for name, v in volts.items()}
    return Scenario("loaded", duration, lever, changes=changes, loads=Loads({}, Payload((0.0,), (payload,))))


def centre_of_gravity(machine, positions):
    frames = link_frames(machine, positions)
    parts = [(link.mass, frames[link.name][1] + frames[link.name][0] @ vector(link.cg)) for link in machine.links]
    parts.append((machine.chassis.mass, np.broadcast_to(vector(machine.chassis.cg), parts[0][1].shape)))
    return sum(m * at for m, at in parts) / sum(m for m, _ in parts)


def test_distances_are_those_of_the_common_centre_of_gravity():
    machine = load_machine("wheel_loader")
    run = simulate(machine, "exact", loaded(machine, 800.0, {"lift": 0.5}, 3.0), stability=True)
    cg = centre_of_gravity(with_payload(machine, 800.0), np.column_stack([run["lift.angle"], run["tilt.angle"]]))
    assert run.info["stability_edges"] == ["forward", "left", "rear", "right"]
    np.testing.assert_allclose(run["stability.forward.distance"], 0.3 - cg[:, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["stability.rear.distance"], cg[:, 0] + 2.8, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["stability.left.distance"], 1.0, rtol=0, atol=1e-12)
    least = np.minimum(run["stability.forward.distance"], 1.0)
    np.testing.assert_array_equal(run["stability.distance"], np.minimum(least, run["stability.rear.distance"]))


def test_at_rest_dynamic_distances_are_the_static_ones_and_moving_ones_are_not():
    machine = load_machine("wheel_loader")
    run = simulate(machine, "exact", loaded(machine, 800.0, {"lift": 0.8}, 2.0), stability=True)
    away = np.abs(run["stability.forward.dynamic_distance"] - run["stability.forward.distance"])
    begun = run["time"] < 1.0
    assert away[begun].max() < 2e-3  # friction is smooth, so that it creeps
    assert away[~begun].max() > 0.01


def test_a_stop_that_is_met_is_no_tip():
    machine = load_machine("wheel_loader")
    run = simulate(machine, "exact", loaded(machine, 0.0, {"lift": 0.8}, 9.0), stability=True)
    assert any(what == "high stop met" for _, _, what in run.info["events"])
    assert run.info["tips"] == []
    assert run.info["stability_least"][1] == run["stability.dynamic_distance"].min() > 0.0


@pytest.mark.slow  # compiles another method
def test_other_methods_give_the_same_margins():
    machine = load_machine("wheel_loader")
    what = loaded(machine, 800.0, {"lift": 0.5}, 2.0)
    a, b = (
        simulate(machine, "exact", what, stability=True, method=m)["stability.forward.distance"]
        for m in ("semi-implicit", "rosenbrock")
    )
    np.testing.assert_allclose(a, b, rtol=0, atol=2e-3)


def test_a_machine_without_chassis_is_refused_before_the_run():
    machine = load_machine("wheel_loader")._replace(chassis=None)
    with pytest.raises(InputError, match=r"no \[chassis\]"):
        simulate(machine, "exact", loaded(machine, 0.0, {}, 1.0), stability=True)


# payload hung at the tip in kg, changes of the machine, levers in V, and where it tips
RAISED = {"functions.lift.initial.angle": 0.6}
EMPTY_TRAILER = {"chassis.mass": 3000.0}
TIPS = [
    ("wheel_loader", 5500.0, RAISED, {"lift": -0.3}, "forward"),
    pytest.param("excavator_22t", 4500.0, {}, {"swing": 0.3, "stick": 0.4}, "left", marks=pytest.mark.slow),
    pytest.param(
        "loader_crane", 2500.0, EMPTY_TRAILER, {"reach": 0.4, "slew": 0.3}, "forward left", marks=pytest.mark.slow
    ),
]


@pytest.mark.parametrize(("name", "payload", "changes", "volts", "direction"), TIPS)
def test_a_tip_is_foreseen_a_second_ahead_and_named(name, payload, changes, volts, direction):
    machine = load_machine(name).with_values(changes)
    run = simulate(machine, "exact", loaded(machine, payload, volts, 11.0), stability=True)
    at, where, ahead = run.info["tips"][0]
    row = np.flatnonzero(run["stability.dynamic_distance"] <= 0.0)[0]
    assert at == run["time"][row] > 2.0
    assert where == direction
    assert ahead >= 1.0
    assert [at, "chassis", f"tips {direction}"] in run.info["events"]
    assert any(line.startswith(f"warning: the machine tips {direction}") for line in run_summary(run))


def test_quiet_work_warns_of_nothing():
    run = simulate("wheel_loader", "exact", Scenario("quiet", 3.0, {"lift": Constant(0.3)}), stability=True)
    assert run.info["tips"] == []
    assert run["stability.time_to_tip"].min() > 2.0
