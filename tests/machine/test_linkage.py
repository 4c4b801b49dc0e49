"""The equations of motion against MuJoCo, against energies, and joints at their end stops."""

import math

import numpy as np
import pytest

from polydraulic.elementary import sincos
from polydraulic.machine.linkage import (
    Held,
    end_effector,
    end_effector_printed,
    motion,
    prepare_linkage,
    solve_motion,
    times,
)
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


def test_end_effector_is_a_rotation(machine):
    g = machine.geometry
    swing = np.linspace(-3.0, 3.0, 7)
    angle = np.column_stack([swing, np.full(7, 0.5), np.full(7, -1.4)])
    position = end_effector(angle, g)
    assert np.hypot(position[:, 0], position[:, 1]) == pytest.approx(np.hypot(position[3, 0], position[3, 1]))
    c1, s1 = np.cos(swing), np.sin(swing)
    c2, c23 = math.cos(0.5), math.cos(-0.9)
    printed = end_effector_printed(angle, g)
    assert printed[:, 0] == pytest.approx(1.8 * c1 * c23 + 5.19 * c1 * c2 + 0.81 * c1 + 0.12 * s1)
    assert printed[:, 1] == pytest.approx(1.8 * s1 * c23 + 5.19 * s1 * c2 + 0.81 * s1 + 0.12 * c1)
    assert printed[:, 2] == pytest.approx(1.8 * math.sin(-0.9) + 5.19 * math.sin(0.5))
