"""The equations of motion against MuJoCo, against energies, and joints at their end stops."""

import math

import numpy as np
import pytest

from polydraulic.elementary import sincos
from polydraulic.machine.joints import moved, stopped
from polydraulic.machine.linkage import Held, motion, prepare_linkage, solve_motion, times
from polydraulic.machine.plant import prepare
from polydraulic.machine.state import Links

FREE = Held(False, False, False)


def matrix(m):
    return np.array([[m.m11, m.m12, m.m13], [m.m12, m.m22, m.m23], [m.m13, m.m23, m.m33]])


def at(angle, rate, linkage):
    return motion(sincos(angle[1]), sincos(angle[2]), Links(*rate), linkage)


def random_states(machine, n, seed=0):
    rng = np.random.default_rng(seed)
    low, high = (
        [-3.0, *(getattr(link.stops, end) for link in (machine.boom, machine.stick))] for end in ("low", "high")
    )
    high[0] = 3.0
    return zip(
        rng.uniform(low, high, (n, 3)), rng.uniform(-1.5, 1.5, (n, 3)), rng.uniform(-1e5, 1e5, (n, 3)), strict=True
    )


def mujoco_model(machine):
    mujoco = pytest.importorskip("mujoco")
    g = machine.geometry

    def inertial(body):
        x, z = body.cg * math.cos(body.cg_angle), body.cg * math.sin(body.cg_angle)
        pitch = body.inertia_transverse
        return (
            f'<inertial pos="{x!r} 0 {z!r}" mass="{body.mass!r}" '
            f'diaginertia="{body.inertia_longitudinal!r} {pitch!r} {pitch!r}"/>'
        )

    swing = machine.swing.body.inertia
    return mujoco.MjModel.from_xml_string(
        f"""
        <mujoco><compiler balanceinertia="false"/><option gravity="0 0 {-g.gravity!r}"/><worldbody><body>
          <joint type="hinge" axis="0 0 1"/>
          <inertial pos="0 0 0" mass="1" diaginertia="{swing!r} {swing!r} {swing!r}"/>
          <body pos="{g.a1!r} {g.d!r} 0"><joint type="hinge" axis="0 -1 0"/>{inertial(machine.boom.body)}
            <body pos="{g.boom_length!r} 0 0"><joint type="hinge" axis="0 -1 0"/>{inertial(machine.stick.body)}</body>
          </body>
        </body></worldbody></mujoco>"""
    )


def test_accelerations_are_those_of_mujoco(machine):
    mujoco = pytest.importorskip("mujoco")
    model = mujoco_model(machine)
    data = mujoco.MjData(model)
    linkage = prepare_linkage(machine)
    for angle, rate, torque in random_states(machine, 3000):
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = angle, rate, torque
        mujoco.mj_forward(model, data)
        m = at(angle, rate, linkage)
        right = Links(*(torque - np.array(m.bias) - np.array(m.gravity)))
        found = np.array(solve_motion(m.mass, FREE, right))
        assert found == pytest.approx(data.qacc, rel=1e-10)


def centres(angle, machine):
    """Positions of the two centres of gravity in space, and directions of the two links."""
    g, (swing, boom, both) = machine.geometry, (angle[0], angle[1], angle[1] + angle[2])
    radial = np.array([math.cos(swing), math.sin(swing), 0.0])
    aside, up = np.array([-math.sin(swing), math.cos(swing), 0.0]), np.array([0.0, 0.0, 1.0])

    def along(theta):
        return math.cos(theta) * radial + math.sin(theta) * up

    foot = g.a1 * radial + g.d * aside
    b, s = machine.boom.body, machine.stick.body
    return (
        foot + b.cg * along(boom + b.cg_angle),
        foot + g.boom_length * along(boom) + s.cg * along(both + s.cg_angle),
    )


def test_gravity_is_the_slope_of_the_height(machine):
    linkage, h = prepare_linkage(machine), 1e-5
    weights = [machine.geometry.gravity * link.body.mass for link in (machine.boom, machine.stick)]
    for angle, rate, _ in random_states(machine, 50):
        slopes = []
        for axis in range(3):
            step = h * np.eye(3)[axis]
            ends = [centres(angle + sign * step, machine) for sign in (1.0, -1.0)]
            slopes.append(sum(w * (up[2] - down[2]) for w, up, down in zip(weights, *ends, strict=True)) / (2 * h))
        assert at(angle, rate, linkage).gravity == pytest.approx(slopes, rel=1e-8, abs=1e-3)


def test_motion_alone_keeps_the_kinetic_energy(machine):
    """Without torques the bias must only turn energy around: d(v M v / 2)/dt = 0, with dM/dt by differences."""
    linkage, h = prepare_linkage(machine), 1e-6
    for angle, rate, _ in random_states(machine, 50):
        m = at(angle, rate, linkage)
        change = [matrix(at(angle + sign * h * rate, rate, linkage).mass) for sign in (1.0, -1.0)]
        rise = 0.5 * rate @ ((change[0] - change[1]) / (2 * h)) @ rate
        assert rate @ np.array(m.bias) == pytest.approx(rise, rel=1e-6, abs=1e-3)


@pytest.mark.parametrize("held", [(a, b, c) for a in (False, True) for b in (False, True) for c in (False, True)])
def test_held_joints_leave_the_reduced_system(machine, held):
    linkage, free = prepare_linkage(machine), [i for i in range(3) if not held[i]]
    for angle, rate, torque in random_states(machine, 20):
        mass = at(angle, rate, linkage).mass
        expected = np.zeros(3)
        expected[free] = np.linalg.solve(matrix(mass)[np.ix_(free, free)], torque[free])
        assert solve_motion(mass, Held(*held), Links(*torque)) == pytest.approx(expected, rel=1e-10, abs=1e-14)
        assert times(mass, Links(*rate)) == pytest.approx(matrix(mass) @ rate, rel=1e-12)


def at_stops(machine, boom=None, stick=None):
    """Angles with boom or stick at an end, given as -1 or 1."""

    def angle(link, side, middle):
        return middle if side is None else (link.stops.high if side > 0 else link.stops.low)

    return Links(0.3, angle(machine.boom, boom, 0.2), angle(machine.stick, stick, -1.2))


def test_impact_stops_one_joint_and_moves_the_others(machine):
    plant = prepare(machine, 0.005)
    angle, rate = at_stops(machine, stick=1), Links(0.1, -0.05, 0.4)
    mass = at(angle, rate, plant.linkage).mass
    after = stopped(angle, rate, mass, plant)
    assert after.rate.stick == 0.0
    assert after.there == (False, False, True)
    change = matrix(mass) @ (np.array(after.rate) - np.array(rate))
    assert change[:2] == pytest.approx([0.0, 0.0], abs=1e-9)  # the impulse acts on the stick alone
    assert change[2] < 0.0
    assert after.rate.boom != rate.boom
    energy = [0.5 * np.array(v) @ matrix(mass) @ np.array(v) for v in (rate, after.rate)]
    assert energy[1] < energy[0]


def test_two_joints_at_their_stops(machine):
    """Whatever drives them: no joint goes on into its stop, none is pulled by it, and no energy appears."""
    plant = prepare(machine, 0.005)
    rng = np.random.default_rng(3)
    for _ in range(300):
        sides = rng.choice([-1, 1], 2)
        angle, rate = at_stops(machine, *sides), Links(*rng.uniform(-1.0, 1.0, 3))
        mass = at(angle, rate, plant.linkage).mass
        after = np.array(stopped(angle, rate, mass, plant).rate)
        impulse = matrix(mass) @ (after - np.array(rate))
        assert np.all(after[1:] * sides <= 1e-12)
        assert np.all(impulse[1:] * sides <= 1e-9)
        assert abs(impulse[0]) < 1e-9
        assert after @ matrix(mass) @ after <= np.array(rate) @ matrix(mass) @ np.array(rate) * (1.0 + 1e-12)


def test_a_held_joint_leaves_when_it_is_pulled_away(machine):
    plant = prepare(machine, 0.005)
    angle, rest = at_stops(machine, boom=1), Links(0.0, 0.0, 0.0)
    mass = at(angle, rest, plant.linkage).mass
    pushed = moved(angle, rest, Links(0.0, 2.0, 0.5), mass, plant)
    assert (pushed.angle.boom, pushed.rate.boom) == (machine.boom.stops.high, 0.0)
    reduced = np.linalg.solve(matrix(mass)[np.ix_([0, 2], [0, 2])], (matrix(mass) @ np.array([0.0, 2.0, 0.5]))[[0, 2]])
    assert [pushed.rate.swing, pushed.rate.stick] == pytest.approx(0.005 * reduced, rel=1e-10)
    pulled = moved(angle, rest, Links(0.0, -2.0, 0.5), mass, plant)
    assert pulled.rate.boom == pytest.approx(-0.01)
    assert pulled.angle.boom < machine.boom.stops.high


def test_a_joint_comes_to_rest_at_its_stop(machine):
    plant = prepare(machine, 0.005)
    angle, rate = Links(0.0, machine.boom.stops.high - 1e-4, -1.2), Links(0.0, 0.5, 0.0)
    after = moved(angle, rate, Links(0.0, 0.0, 0.0), at(angle, rate, plant.linkage).mass, plant)
    assert (after.angle.boom, after.rate.boom) == (machine.boom.stops.high, 0.0)


def test_locked_joints_stand_still(machine):
    plant = prepare(machine, 0.005, ["swing", "stick"])
    assert plant.locked == (True, False, True)
    angle, rate = at_stops(machine, boom=1), Links(0.0, 0.4, 0.0)
    after = moved(angle, rate, Links(0.0, 1.0, 0.0), at(angle, rate, plant.linkage).mass, plant)
    assert after.rate == (0.0, 0.0, 0.0)
    assert after.angle == angle
