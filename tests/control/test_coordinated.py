"""A coordinated controller in front of the machine that it knows: directions, limits, neutral levers, and what is refused."""

import numpy as np
import pytest

from polydraulic import InputError, Simulator, StabilityMonitor, build_flow, load_machine
from polydraulic.control import ControlSettings, CoordinatedControl, SensorErrors, run_controlled, straight_line
from polydraulic.control.coordinated import VELOCITIES, measured_columns
from polydraulic.machine.stability.statics import holding_pressures

AT = {"boom.angle": 0.3, "stick.angle": -1.6}
NO_FEEDBACK = {"gain": 1e-6, "integral_gain": 0.0}


@pytest.fixture(scope="module")
def machine():
    return load_machine("cat215b")


def moved(machine, wanted, seconds, *, start=AT, **settings):
    """Run with constant wanted velocity; positions of the joints, and reach and height of the tip, at each call."""
    control = CoordinatedControl(machine, settings=ControlSettings(**settings))
    rows = []
    with Simulator(machine) as simulator:
        simulator.reset(start)
        simulator.step(np.zeros(3), n=200)
        for _ in range(round(seconds / control.dt)):
            volts = control.step(control.measured(simulator), wanted)
            rows.append(
                [*(float(simulator[f"{f}.angle"]) for f in machine.names), *control.reference[:2], float(control.share)]
            )
            simulator.step(volts, n=2)
    return np.array(rows), control


def reach_height(machine, angles):
    _, boom, stick = machine.links
    (x, length), tip = (boom.at["x"], stick.at["x"]), machine.tip[1]["x"]
    b, s = angles[:, 1], angles[:, 1] + angles[:, 2]
    return np.stack([x + length * np.cos(b) + tip * np.cos(s), length * np.sin(b) + tip * np.sin(s)], axis=1)


def test_neutral_levers_give_no_voltage_at_all(machine):
    control = CoordinatedControl(machine)
    with Simulator(machine) as simulator:
        for _ in range(20):
            assert not control.step(control.measured(simulator), np.zeros(4)).any()
            simulator.step(np.zeros(3), n=2)


def test_valves_close_when_the_lever_is_let_go(machine):
    control = CoordinatedControl(machine)
    with Simulator(machine) as simulator:
        for k in range(200):
            volts = control.step(control.measured(simulator), {"height": 0.3} if k < 60 else {})
            assert volts.any() or k == 0 or k > 60
            simulator.step(volts, n=2)
    assert not volts.any()


@pytest.mark.parametrize("wanted", [{"reach": -0.25}, {"height": 0.2}, {"reach": -0.2, "height": -0.1}])
def test_inverted_valves_alone_move_the_tip_about_as_fast_as_wanted(machine, wanted):
    rows, _ = moved(machine, wanted, 3.0, **NO_FEEDBACK)
    tips = reach_height(machine, rows)
    speed = (tips[-1] - tips[150]) / (1.5 - 0.01)
    np.testing.assert_allclose(speed, [wanted.get("reach", 0.0), wanted.get("height", 0.0)], atol=0.04)


def test_servos_keep_the_tip_at_its_reference(machine):
    rows, _ = moved(machine, {"reach": -0.25}, 3.0)
    apart = np.linalg.norm(reach_height(machine, rows)[100:] - rows[100:, 3:5], axis=1)
    lag = 0.25 * (0.06 + 0.01)  # by which the machine follows
    assert np.abs(apart - lag).max() < 0.03


def test_the_direction_is_kept_where_the_pump_runs_short(machine):
    wanted = {"reach": -1.5, "height": 0.9}
    rows, _ = moved(machine, wanted, 2.0, acceleration=3.0)
    assert rows[60:, 5].min() < 0.9
    done = np.diff(rows[:, 3:5], axis=0)
    across = done @ np.array([0.9, 1.5]) / np.hypot(1.5, 0.9)
    assert np.abs(across.sum()) < 0.01 * np.linalg.norm(done.sum(axis=0))
    tips = reach_height(machine, rows)[60:]
    off = (tips - tips[0]) @ np.array([0.9, 1.5]) / np.hypot(1.5, 0.9)
    along = np.linalg.norm(tips[-1] - tips[0])
    alone, _ = moved(machine, wanted, 2.0, acceleration=3.0, shares_flow=False)
    others = reach_height(machine, alone)[60:]
    off_alone = (others - others[0]) @ np.array([0.9, 1.5]) / np.hypot(1.5, 0.9)
    assert np.abs(off).max() < 0.12 * along
    assert np.abs(off).max() < 0.5 * np.abs(off_alone).max()


def test_the_reference_never_passes_a_limit_and_the_machine_does_not_meet_its_stop_hard(machine):
    control = CoordinatedControl(machine)
    low, high = control.servo.low, control.servo.high
    with Simulator(machine) as simulator:
        simulator.reset({"boom.angle": 0.0, "stick.angle": -2.3})
        events = []
        for _ in range(600):
            simulator.step(control.step(control.measured(simulator), {"reach": -0.6}), n=2)
            events += simulator.events
            assert (control.joints >= low - 1e-9).all()
            assert (control.joints <= high + 1e-9).all()
        assert float(control.share) < 0.05
        assert abs(float(simulator["stick.rate"])) < 0.02
    assert [what for _, where, what in events if where == "stick" and "stop met" in what] == []


def test_the_same_calls_give_the_same_bits_after_a_reset(machine):
    control, rng = CoordinatedControl(machine), np.random.default_rng(4)
    start = np.array([0.0, 0.3, -1.6, 2e6, 8e6, 3e6, 2e6, 5e5, 4e5])
    calls = [(start * rng.uniform(0.99, 1.01, 9), rng.uniform(-0.3, 0.3, 4)) for _ in range(30)]
    first = [control.step(*call).copy() for call in calls]
    control.reset()
    assert all(np.array_equal(control.step(*call), was) for call, was in zip(calls, first, strict=True))
    assert np.isfinite(first).all()


def test_a_closed_run_follows_a_line_through_noise_and_delay(machine):
    control = CoordinatedControl(machine, settings=ControlSettings(delay=0.04))
    run = run_controlled(
        machine,
        control,
        lambda tip: straight_line(tip, length=1.0, ramp=1.0),
        start=AT,
        errors=SensorErrors(5e-4, 1e5, 0.04, 1),
    )
    apart = np.hypot(run["tip.reach"] - run["target.reach"], run["tip.height"] - run["target.height"])
    assert np.sqrt(np.mean(apart**2)) < 0.018
    assert run["tip.reach"][0] - run["tip.reach"][-1] == pytest.approx(1.0, abs=0.03)
    assert run.units["boom.p_a"] == "Pa"


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"dt": 0.0}, "step"),
        ({"gain": 0.0}, "gain = 0.0"),
        ({"reach": np.nan}, "reach = nan"),
        ({"margin": 0.5}, "margin = 0.5"),
        ({"delay": 2.0}, "delay = 2 s: at most 1 s"),
        ({"delay": -0.1}, "delay = -0.1: must be a number, 0 or more"),
    ],
)
def test_settings_that_cannot_be_used_are_refused(machine, settings, words):
    with pytest.raises(InputError, match=words):
        CoordinatedControl(machine, settings=ControlSettings(**settings))


def test_a_path_that_is_not_finished_is_warned_of(machine):
    control = CoordinatedControl(machine, settings=ControlSettings(delay=0.04))
    with pytest.warns(UserWarning, match=r"not through when the limit of 1 s came, .* % of its path behind it"):
        run = run_controlled(machine, control, lambda tip: straight_line(tip, length=1.0, speed=0.2), limit=1.0)
    assert len(run) == 100


def test_flow_models_that_cannot_be_inverted_are_refused(machine):
    with pytest.raises(InputError, match="inverted of 'exact' circuits and of networks"):
        CoordinatedControl(machine, build_flow("iterative", machine))


@pytest.mark.parametrize(
    ("measured", "wanted"),
    [
        (np.zeros(8), np.zeros(4)),
        (np.full(9, np.nan), np.zeros(4)),
        (np.zeros(9), np.zeros(3)),
        (np.zeros(9), np.array([np.inf, 0.0, 0.0, 0.0])),
        ([0.0] * 9, np.zeros(4)),
    ],
)
def test_measurements_and_velocities_that_are_none_are_refused(machine, measured, wanted):
    with pytest.raises(InputError, match="measured must be 9 finite numbers"):
        CoordinatedControl(machine).step(measured, wanted)


def test_sliding_joints_are_measured_by_their_position():
    columns = measured_columns(load_machine("loader_crane"))
    assert columns[:5] == ["slew.angle", "inner.angle", "outer.angle", "reach.position", "tilt.angle"]
    assert [columns[5], columns[6], columns[-1]] == ["slew.p_a", "inner.p_a", "tilt.p_b"]


def test_velocities_are_known_by_name(machine):
    control = CoordinatedControl(machine)
    with pytest.raises(InputError, match="'depth'"):
        control.step(np.zeros(9), {"depth": 1.0})
    with pytest.raises(InputError, match="a multiple|whole multiple"):
        run_controlled(machine, control, lambda tip: straight_line(tip, length=1.0), dt=0.004)
    sticks = np.array([1.0, 0.5, 0.0, -1.0, 0.0, 0.0])
    np.testing.assert_allclose(control.velocity(sticks), [0.3, 0.6, -0.4, 0.0])
    assert len(VELOCITIES) == 4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "wanted", "near"),
    [
        ("excavator_22t", {"reach": -0.25}, 0.06),
        ("cat215b_crossover", {"reach": -0.25}, 0.06),
        ("wheel_loader", {"height": 0.25}, 0.03),
        ("loader_crane", {"reach": -0.15, "height": 0.1}, 0.06),
    ],
)
def test_every_layout_is_moved_as_wanted_and_holds_its_attachment(name, wanted, near):
    other = load_machine(name)
    control = CoordinatedControl(other)
    waits = 100  # calls, in which the start is over
    with Simulator(other) as simulator:
        simulator.step(np.zeros(len(other.names)), n=400)
        for k in range(400):
            simulator.step(control.step(control.measured(simulator), wanted), n=2)
            place = np.array([float(simulator["effector.x"]), float(simulator["effector.z"])])
            if k == waits:
                first, pitch = place, float(control.reference[3])
    done = (place - first) / ((399 - waits) * control.dt)
    asked = [wanted.get("reach", 0.0), wanted.get("height", 0.0)]
    use = slice(1, 2) if name == "wheel_loader" else slice(0, 2)
    np.testing.assert_allclose(done[use], float(control.share) * np.array(asked)[use], atol=near)
    assert float(control.reference[3]) == pytest.approx(pitch, abs=0.03)


@pytest.mark.slow
def test_networks_are_inverted_as_circuits_are(machine):
    control = CoordinatedControl(machine, "polynomial", settings=ControlSettings(delay=0.04))
    run = run_controlled(machine, control, lambda tip: straight_line(tip, length=1.0, ramp=1.0), start=AT)
    apart = np.hypot(run["tip.reach"] - run["target.reach"], run["tip.height"] - run["target.height"])
    assert np.sqrt(np.mean(apart**2)) < 0.03


def test_a_wanted_velocity_that_is_no_number_is_named():
    with pytest.raises(InputError, match="wanted = {'height': 'up'}: must be numbers"):
        CoordinatedControl("wheel_loader").step(np.zeros(6), {"height": "up"})


# machine with a light chassis, payload in kg, where it begins, what is asked for, margin that is kept in m, seconds
NEAR = [
    ("wheel_loader", 6000.0, 1000.0, {"lift": 0.6}, {"height": -0.3}, 0.2, 7.0),
    pytest.param(
        "excavator_22t", 3000.0, 1500.0, {"swing": 1.57, "boom": 0.4}, {"reach": 0.3}, 0.35, 9.0, marks=pytest.mark.slow
    ),
]


def towards_a_tip(machine, payload, start, wanted, seconds, *, release=None, **settings):
    """Least static and dynamic distance at each call, and the share of the motion that was left."""
    control = CoordinatedControl(machine, settings=ControlSettings(payload=payload, **settings))
    monitor = StabilityMonitor(machine)
    at = np.array([[start.get(f.name, f.initial.angle) for f in machine.functions]])
    held = holding_pressures(machine, at, payload)[0]
    state = {f"{name}.angle": value for name, value in zip(machine.names, at[0].tolist(), strict=True)}
    for name, pair in zip(machine.names, held.tolist(), strict=True):
        state |= {f"{name}.p_a": pair[0], f"{name}.p_b": pair[1]}
    rows = []
    with Simulator(machine, load={"payload": payload}) as simulator:
        simulator.reset(state)
        simulator.step({}, n=100)
        for k in range(round(seconds / control.dt)):
            asked = {} if release is not None and k * control.dt >= release else wanted
            simulator.step(control.step(control.measured(simulator), asked), n=2)
            seen = monitor(simulator, payload=payload)
            rows.append([seen.distance.min(), seen.dynamic_distance.min(), float(control.share)])
    return np.array(rows).T


@pytest.mark.slow_to_compile
@pytest.mark.parametrize(("name", "mass", "payload", "start", "wanted", "margin", "seconds"), NEAR)
def test_a_motion_that_would_tip_is_slowed_and_refused(name, mass, payload, start, wanted, margin, seconds):
    light = load_machine(name).with_values({"chassis.mass": mass})
    free = towards_a_tip(light, payload, start, wanted, seconds)
    kept = towards_a_tip(light, payload, start, wanted, seconds, tip_margin=margin)
    assert min(free[0].min(), free[1].min()) < margin - 0.1  # it would come nearer
    assert kept[0].min() > margin - 0.02
    assert kept[1].min() > margin - 0.12  # and the arm on its oil does not swing it over
    assert kept[0][-1] < margin + 0.1  # it went as near as it may
    assert kept[2][-1] < 0.25
    slowed = kept[2][(kept[0] > margin + 0.01) & (kept[2] < 1.0)]
    assert len(slowed) > 10  # ahead of it


@pytest.mark.slow_to_compile
def test_a_lever_that_is_let_go_leaves_the_margin(machine):
    light = load_machine("wheel_loader").with_values({"chassis.mass": 6000.0})
    distance, dynamic, _ = towards_a_tip(
        light, 1000.0, {"lift": 0.6}, {"height": -0.6}, 3.0, release=0.9, tip_margin=0.2
    )
    assert dynamic.min() > 0.0
    assert distance.min() > 0.18


@pytest.mark.slow_to_compile
def test_a_motion_away_from_a_tip_is_not_slowed(machine):
    light = load_machine("wheel_loader").with_values({"chassis.mass": 5000.0})
    start, kept = {"lift": 0.2}, {"tip_margin": 0.3}  # nearer than that already
    distance, _, share = towards_a_tip(light, 1000.0, start, {"height": 0.2}, 1.5, **kept)
    assert distance[-1] > distance[0] + 0.01
    assert share[-50:].min() > 0.5
    _, _, share = towards_a_tip(light, 1000.0, start, {"height": -0.2}, 0.5, **kept)
    assert share.max() == 0.0


def test_a_payload_that_is_told_of_counts_as_one_that_was_known():
    light = load_machine("wheel_loader").with_values({"chassis.mass": 6000.0, "functions.lift.initial.angle": 0.2})
    known, told, plain = (
        CoordinatedControl(light, settings=ControlSettings(tip_margin=margin, payload=payload))
        for margin, payload in ((0.2, 1000.0), (0.2, 0.0), (0.0, 0.0))
    )
    with Simulator(light) as simulator:
        measured = told.measured(simulator).copy()
    down = {"height": -0.2}
    for control in (known, told, plain):
        for _ in range(5):
            control.step(measured, down)
    assert (known.tip_share, told.tip_share, plain.tip_share) == (0.0, 1.0, 1.0)
    told.reset()
    told.carry(1000.0)
    assert told.settings.payload == 1000.0
    assert repr(told.parts.numbers.body) == repr(known.parts.numbers.body)
    for _ in range(5):
        told.step(measured, down)
    assert told.tip_share == known.tip_share
    with pytest.raises(InputError, match="payload = -1"):
        told.carry(-1.0)
    assert told.settings.payload == 1000.0


def test_what_cannot_be_kept_from_tipping_is_refused(machine):
    with pytest.raises(InputError, match=r"no \[chassis\]"):
        CoordinatedControl(machine._replace(chassis=None), settings=ControlSettings(tip_margin=0.2))
    with pytest.raises(InputError, match="tip_margin = -1"):
        CoordinatedControl(machine, settings=ControlSettings(tip_margin=-1.0))
