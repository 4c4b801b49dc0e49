"""The planar arm: its kernels against tip and Jacobian of any machine, rates that move the tip as wanted."""

import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.control.arm import arm_pose, arm_rates, joints_at, planar_arm, pump_rate
from polydraulic.machine.reach.tip import tip_at_joints, tip_jacobian

NAMES = ("cat215b", "excavator_22t", "loader_crane", "wheel_loader")


def pose_of(machine, angles):
    """Pose and columns of the arm at joint angles."""
    arm, n = planar_arm(machine), len(angles)
    live = np.concatenate([angles, np.zeros(3 * n)])
    pose = arm_pose(arm, live, 0, 2 * n)
    return np.array(pose), live


def inside(machine, rng):
    stops = np.clip(np.array([f.stops for f in machine.functions]), -1.0, 2.0)
    return rng.uniform(stops[:, 0], stops[:, 1])


@pytest.mark.parametrize("name", NAMES)
def test_the_tip_is_where_the_frames_of_the_links_put_it(name):
    machine, rng = load_machine(name), np.random.default_rng(1)
    for _ in range(5):
        angles = inside(machine, rng)
        x, y, z = tip_at_joints(machine, angles)
        arm = planar_arm(machine)
        yaw = angles[arm.swing] if arm.swing >= 0 else 0.0
        (reach, height, _), _ = pose_of(machine, angles)
        assert reach == pytest.approx(x * np.cos(yaw) + y * np.sin(yaw), abs=1e-9)
        assert height == pytest.approx(z, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_columns_are_those_of_the_jacobian(name):
    machine, rng = load_machine(name), np.random.default_rng(2)
    arm, angles = planar_arm(machine), inside(machine, rng)
    n, jacobian = len(angles), tip_jacobian(machine, angles)
    _, live = pose_of(machine, angles)
    yaw = arm.swing_sign * angles[arm.swing] if arm.swing >= 0 else 0.0
    for i, f in enumerate(arm.function):
        moved = jacobian[:, f]
        if arm.attachment >= 0 and arm.slides[i] == 0:  # it keeps its angle to the ground, as its pin moves
            moved = moved - arm.sign[i] * arm.attachment_sign * jacobian[:, arm.attachment]
        found = live[2 * n + 2 * i : 2 * n + 2 * i + 2]
        np.testing.assert_allclose(found, [np.cos(yaw) * moved[0] + np.sin(yaw) * moved[1], moved[2]], atol=1e-12)


@pytest.mark.parametrize("name", ["cat215b", "excavator_22t", "loader_crane"])
def test_rates_move_the_tip_as_wanted_and_hold_the_attachment(name):
    machine = load_machine(name)
    arm, n = planar_arm(machine), len(machine.names)
    angles = np.array([f.initial.angle for f in machine.functions])
    before, live = pose_of(machine, angles)
    arm_rates(arm, live, 2 * n, n, 0.2, -0.1, 0.3, 0.0, 1e-3)
    rates = live[n : 2 * n].copy()
    after, _ = pose_of(machine, angles + 1e-6 * rates)
    wanted = [0.2, -0.1, 0.0] if arm.attachment >= 0 else [0.2, -0.1]
    np.testing.assert_allclose((after - before)[: len(wanted)] / 1e-6, wanted, atol=1e-5)
    assert rates[arm.swing] == 0.3


def test_rates_stay_small_where_the_arm_is_stretched():
    machine = load_machine("cat215b")
    arm = planar_arm(machine)
    for stick, most in ((-1.0, 1.0), (-1e-3, 1.0), (0.0, 1.0)):
        _, live = pose_of(machine, np.array([0.0, 0.2, stick]))
        arm_rates(arm, live, 6, 3, 0.3, 0.0, 0.0, 0.0, 0.15)
        assert np.abs(live[3:6]).max() < most


def test_joints_bring_the_tip_to_a_place_or_say_that_they_cannot():
    machine = load_machine("excavator_22t")
    found = joints_at(machine, 6.5, -0.5, pitch=-1.9)
    pose, _ = pose_of(machine, np.array([found[name] for name in machine.names]))
    np.testing.assert_allclose(pose, [6.5, -0.5, -1.9], atol=2e-6)
    with pytest.raises(InputError, match="cannot be brought to a reach of 12 m"):
        joints_at(machine, 12.0, 0.0, pitch=-1.9)
    with pytest.raises(InputError, match="reach = nan: must be a finite number"):
        joints_at(load_machine("cat215b"), reach=np.nan, height=0.0)


def test_machines_without_a_planar_arm_are_refused():
    machine = load_machine("cat215b")
    links = tuple(link._replace(axis="x") if link.name == "stick" else link for link in machine.links)
    with pytest.raises(InputError, match="revolute x of stick"):
        planar_arm(machine._replace(links=links))


def test_a_loader_with_its_bucket_held_moves_its_tip_up_and_down_alone():
    machine = load_machine("wheel_loader")
    arm, n = planar_arm(machine), len(machine.names)
    assert [machine.names[f] for f in (*arm.function, arm.attachment)] == ["lift", "tilt"]
    _, live = pose_of(machine, np.array([f.initial.angle for f in machine.functions]))
    arm_rates(arm, live, 2 * n, n, 0.3, 0.0, 0.0, 0.0, 0.0)
    assert np.all(live[n : 2 * n] == 0.0)  # outward: nothing that it can do


def test_the_whole_flow_gives_a_plausible_rate():
    machine = load_machine("excavator_22t")
    rates = {f.name: pump_rate(machine, f) for f in machine.functions}
    assert rates["swing"] == pytest.approx(11.5 * 2 * np.pi / 60.0, rel=0.02)  # the file says so: 11.5 rpm
    assert all(0.1 < rate < 2.0 for rate in rates.values())
