import json

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.cockpit.cab import DT, Cab
from polydraulic.cockpit.description import machine_description
from polydraulic.cockpit.protocol import Flag
from polydraulic.cockpit.wanted import TrialWish, Wanted

FREE = Wanted(locked=False)


def sticks(**axes):
    """Sticks by name."""
    names = ("lx", "ly", "rx", "ry", "a5", "a6")
    return FREE._replace(axes=tuple(axes.get(name, 0.0) for name in names))


def columns(cab):
    """Values of the last frame by name."""
    return dict(zip((c.name for c in cab.view.columns), np.frombuffer(cab.shown.values, "<f4").tolist(), strict=True))


def test_a_locked_machine_ignores_its_levers(cab):
    other = Cab("wheel_loader")
    cab.move(sticks(ry=-1.0)._replace(locked=True), 100)
    other.move(Wanted(), 100)
    assert cab.shown.values == other.shown.values
    assert cab.shown.flags & Flag.LOCKED
    assert columns(cab)["lift.voltage"] == 0.0


@pytest.mark.parametrize(
    ("machine", "axes", "column", "sign"),
    [
        ("wheel_loader", {"ry": -0.8}, "lift.angle", 1),  # pulled back: up
        ("wheel_loader", {"rx": -0.6}, "tilt.angle", 1),  # to the left: rolls back
    ],
)
def test_a_lever_moves_its_joint_the_way_the_pattern_says(machine, axes, column, sign):
    cab = Cab(machine)
    before = columns(cab)
    cab.move(sticks(**axes), 200)
    moved = columns(cab)[column] - before[column]
    assert sign * moved > 0.05


def test_the_last_sticks_and_the_steps_are_shown(cab):
    cab.move(FREE._replace(seq=5), 3, overruns=2)
    shown = cab.shown
    assert (shown.seq, shown.overruns, shown.steps) == (5, 2, 3)
    assert shown.time == pytest.approx(3 * DT)
    assert columns(cab)["effector.z"] == pytest.approx(float(cab.simulator["effector.z"]), rel=1e-6)


def test_how_steps_are_divided_among_calls_does_not_matter(cab):
    other = Cab("wheel_loader")
    cab.move(sticks(ry=-0.7), 60)
    for n in (1, 9, 10, 10, 10, 10, 10):
        other.move(sticks(ry=-0.7), n)
    assert cab.simulator.save().live.tobytes() == other.simulator.save().live.tobytes()


def test_a_reset_is_made_once(cab):
    cab.move(sticks(ry=-0.7), 50)
    cab.move(FREE._replace(resets=1), 1)
    cab.move(FREE._replace(resets=1), 1)
    assert cab.simulator.steps == 2


def test_a_fault_changes_the_machine_and_leaves_it_as_it_was(cab):
    pump = cab.machine.circuit("work").pump
    cab.move(FREE._replace(faults=("work.pump_worn", "work.pump_relief_low")), 10)
    ill = cab.simulator.machine.circuit("work").pump
    assert (ill.flow, ill.relief) == (0.95 * pump.flow, 0.9 * pump.relief)
    assert cab.shown.faults == ("work.pump_worn", "work.pump_relief_low")
    cab.move(FREE._replace(faults=("work.pump_relief_low",)), 10)
    assert cab.simulator.machine.circuit("work").pump == pump._replace(relief=0.9 * pump.relief)
    cab.move(FREE, 10)
    assert cab.simulator.machine == cab.machine


def test_a_payload_weighs(cab):
    other = Cab("wheel_loader")
    cab.move(FREE._replace(payload=1500.0), 200)
    other.move(FREE, 200)
    assert columns(cab)["payload"] == 1500.0
    assert columns(cab)["lift.p_a"] > columns(other)["lift.p_a"] + 1e6


def test_relief_and_stop_are_flagged_and_told(cab):
    cab.move(sticks(rx=-1.0), 400)  # rolled back to the end
    assert cab.shown.flags & Flag.STOP
    assert any(what == "high stop met" for _, (_, _, what) in cab.shown.events)


def test_a_machine_that_diverges_stands_still_until_it_is_reset(cab, monkeypatch):
    from polydraulic.errors import SimulationError

    def diverges(*args):
        raise SimulationError("diverged")

    with monkeypatch.context() as m:
        m.setattr(cab.simulator, "step", diverges)
        cab.move(FREE, 1)
    assert "diverged" in cab.shown.error[1]
    cab.move(FREE, 5)
    assert cab.simulator.steps == 0
    cab.move(FREE._replace(resets=1), 5)
    assert cab.simulator.steps == 5


def followed(shadow):
    """How far a shadow is away after a while of all that can happen."""
    cab = Cab("wheel_loader", shadow=shadow)
    cab.move(sticks(ry=-0.8)._replace(payload=500.0, faults=("lift.friction_high",)), 200)
    cab.move(sticks(ry=-0.8)._replace(payload=200.0, resets=1), 100)
    cab.move(sticks(rx=-0.8), 100)
    assert cab.shown.shadow == ""
    return columns(cab)["shadow.tip_error"]


def test_a_shadow_of_the_same_model_stays_where_the_machine_is():
    assert followed("exact") == 0.0


@pytest.mark.slow
def test_a_shadow_of_another_model_is_away():
    assert 0.0 < followed("tlm") < 0.2


def test_an_exercise_begins_anew_and_is_scored(cab):
    cab.move(sticks(ry=-0.7), 50)
    wish = FREE._replace(trial=TrialWish(1, "tracking", "S-1"))
    cab.move(wish, 1000)  # 3 s to get ready
    assert cab.shown.time == pytest.approx(5.0)
    assert cab.shown.flags & Flag.TARGET
    score = cab.shown.trial.score
    assert cab.shown.trial.running
    assert score["time"][0] == pytest.approx(2.0, abs=2 * DT)
    seen = columns(cab)
    away = np.linalg.norm([seen[f"target.{c}"] - seen[f"effector.{c}"] for c in "xyz"])
    assert score["error_max"][0] == pytest.approx(away, abs=0.05)  # it moves away from a machine that stands
    assert score["energy"][0] > 0.0
    cab.move(FREE, 1)
    assert not cab.shown.flags & Flag.TARGET
    assert (cab.shown.trial.running, cab.shown.trial.finished) == (False, False)


def test_the_description_is_json_that_names_every_column(cab):
    found = json.loads(json.dumps(machine_description(cab), allow_nan=False))
    assert len(found["columns"]) * 4 == len(cab.shown.values)
    bar = found["display"]["lift.p_a"]
    assert (bar["unit"], bar["factor"] * 2e5 + bar["offset"]) == ("bar", pytest.approx(2.0))
    assert found["circuits"][0]["functions"] == ["tilt", "lift"]  # in the order in which oil reaches them
    assert [f["position"] for f in found["functions"]] == ["lift.angle", "tilt.angle"]
    assert {e["name"] for e in found["exercises"]} == {"tracking", "trench", "pick and place", "truck loading"}
    assert found["patterns"]["iso"]["lift"] == {"axis": 3, "sign": -1, "positive": "boom down", "negative": "boom up"}
    assert found["coordinated"]["able"] is False  # before it is ready


def test_coordinated_sticks_move_the_tip_and_not_a_joint(cab):
    cab.warm_up()
    assert machine_description(cab)["coordinated"]["able"] is True
    before = cab.view.tip.copy()
    up = sticks(ry=-0.4)._replace(mode="coordinated")  # pulled back: up
    cab.move(up, 300)
    moved = cab.view.tip - before
    assert moved[2] > 0.25
    assert abs(moved[0]) < 0.05
    assert np.ptp([columns(cab)[f"{name}.voltage"] for name in ("lift", "tilt")]) > 0.0
    other = Cab("wheel_loader")
    other.warm_up()
    for n in (7, 1, 10, *[10] * 28, 2):
        other.move(up, n)
    assert other.simulator.save().live.tobytes() == cab.simulator.save().live.tobytes()
    cab.move(up._replace(locked=True), 5)
    assert columns(cab)["lift.voltage"] == 0.0


def test_a_sensor_that_errs_deceives_the_controller_and_not_the_view(cab):
    cab.warm_up()
    up = sticks(ry=-0.3)._replace(mode="coordinated")
    other = Cab("wheel_loader")
    other.warm_up()
    for c, wanted in ((cab, up), (other, up._replace(faults=("lift.angle.bias",)))):
        c.move(up, 100)
        c.move(wanted, 200)  # the sensor goes off while the arm moves: the servo corrects what is no error
    assert other.shown.faults == ("lift.angle.bias",)
    assert other.simulator.machine == other.machine
    assert cab.view.tip[2] - other.view.tip[2] > 0.02
    assert columns(other)["lift.angle"] == pytest.approx(float(other.simulator["lift.angle"]), rel=1e-6)


def test_a_shadow_that_does_not_know_a_fault_is_lost_until_it_begins_anew(cab, monkeypatch):
    from polydraulic.errors import InputError

    shadowed = Cab("wheel_loader", shadow="exact")

    def refuses(values):
        raise InputError("was trained on others")

    shadowed.move(sticks(ry=-0.8)._replace(faults=("lift.leak_across",)), 5)
    with monkeypatch.context() as m:
        m.setattr(shadowed.shadow._free, "change", refuses)
        shadowed.move(sticks(ry=-0.8)._replace(faults=("work.pump_relief_low",)), 50)
        shadowed.move(sticks(ry=-0.8)._replace(faults=("work.pump_relief_low",)), 100)
    assert "circuits.work.pump.relief" in shadowed.shown.shadow
    assert shadowed.simulator.steps == 155  # the machine goes on
    assert columns(shadowed)["shadow.tip_error"] > 0.0
    shadowed.move(FREE._replace(resets=1), 1)
    assert shadowed.shown.shadow == ""
    assert columns(shadowed)["shadow.tip_error"] == 0.0
    assert shadowed.shadow._free.machine == cab.machine


def test_one_step_of_a_shadow_begins_where_the_machine_is():
    """The same model makes the same step, dead times included; networks that are wrong make another one, however near their own run is."""
    machine = load_machine("wheel_loader")
    late = machine.with_values({"functions.lift.pilot.dead_time": 0.02})
    cab = Cab(late, shadow="exact")
    for n, stick in ((3, -0.8), (1, 0.5), (10, -0.3)):
        cab.move(sticks(ry=stick), n)
        seen = columns(cab)
        assert (seen["shadow.step_speed_error"], seen["shadow.step_flow_error"], seen["shadow.tip_error"]) == (
            0.0,
            0.0,
            0.0,
        )
    worn = Cab(late, shadow="exact")
    worn.shadow.change({"circuits.work.pump.flow": 0.8 * late.circuits[0].pump.flow})
    worn.move(sticks(ry=-1.0), 60)
    seen = columns(worn)
    assert seen["shadow.step_flow_error"] > 1e-4
    assert seen["shadow.tip_error"] > 0.0


def test_a_flow_model_without_pump_pressures_is_scored_by_what_flows_into_actuators(cab):
    power = cab.view.power
    cab.view.knows_power = False
    cab.move(sticks(ry=-0.8)._replace(trial=TrialWish(1, "pick and place", "")), 100)
    sim, score = cab.simulator, cab.shown.trial.score
    inlet = sim["lift.p_a"] if sim.state[0] >= 0.0 else sim["lift.p_b"]
    other = sim["tilt.p_a"] if sim.state[1] >= 0.0 else sim["tilt.p_b"]
    assert cab.view.power == pytest.approx(float(sim["lift.q_in"] * inlet + sim["tilt.q_in"] * other))
    assert cab.view.power != power
    assert "energy" not in score
    assert score["actuator_energy"][0] > 0.0
