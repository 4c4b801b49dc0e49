"""Lift capacity against statics that are computed another way: weights in MuJoCo, forces of cylinders from their pins."""

from math import cos, pi, sin

import numpy as np
import pytest

from helpers.trees import mujoco_model
from polydraulic import InputError, load_machine
from polydraulic.machine.stability.lifting import lift_limits
from polydraulic.machine.stability.statics import holding_pressures, static_torques
from polydraulic.parameters.layout.parts import FourBar, Pins
from polydraulic.simulation.layout.tree import tree_of

MACHINES = ("excavator_22t", "loader_crane", "wheel_loader")


class Statics:
    """A machine in MuJoCo, at rest."""

    def __init__(self, machine, positions):
        self.mujoco = pytest.importorskip("mujoco")
        self.machine = machine
        links = tree_of(machine)
        self.model = mujoco_model(links)
        self.data = self.mujoco.MjData(self.model)
        self.names = [machine.function(f).moves for f in machine.names]
        for name, value in zip(self.names, positions, strict=True):
            self.data.joint(self._joint(name)).qpos[0] = value
        self.mujoco.mj_forward(self.model, self.data)
        self.torques = np.array([self.data.joint(self._joint(name)).qfrc_bias[0] for name in self.names])
        self.tip = self.point(*machine.tip)
        columns = np.zeros((3, self.model.nv))
        self.mujoco.mj_jac(
            self.model, self.data, columns, None, self.tip, self.model.body(self._body(machine.tip[0])).id
        )
        places = [self.model.joint(self._joint(name)).dofadr[0] for name in self.names]
        self.torques_per_kg = machine.gravity * columns[2, places]

    def _joint(self, link):
        names = [self.model.joint(k).name for k in range(self.model.njnt)]
        return next(n for n in names if n == link or self._alias(n) == link)

    def _body(self, link):
        names = [self.model.body(k).name for k in range(self.model.nbody)]
        return next(n for n in names if n == link or self._alias(n) == link)

    def _alias(self, name):  # the tree goes by names of functions
        return self.machine.function(name).moves if name in self.machine.names else name

    def point(self, link, at):
        at = np.array([at.get(c, 0.0) for c in "xyz"])
        if link == "ground":
            return at
        body = self.data.body(self._body(link))
        return body.xpos + body.xmat.reshape(3, 3) @ at

    def masses(self):
        return [(self.model.body_mass[k], self.data.xipos[k]) for k in range(1, self.model.nbody)]


def stroke_rate(f, link, angle):
    """Rate of a bucket cylinder's length over its joint, by a complex step through the circles on which its knee lies."""
    h = 1e-30
    sign = -1.0 if link.axis[0] == "-" else 1.0

    def flat(point):  # x and z, so that -y turns x to z; +y the other way
        return complex(point.get("x", 0.0) - link.at.get("x", 0.0), point.get("z", 0.0) - link.at.get("z", 0.0))

    base, hinge, knee0 = (flat(p) for p in (f.pins.base, f.pins.hinge, f.pins.knee))
    pin = complex(f.pins.pin.get("x", 0.0), f.pins.pin.get("z", 0.0))
    rocker, coupler = abs(knee0 - hinge), abs(pin - knee0)
    sense = np.sign(
        ((knee0 - hinge).conjugate() * (pin - knee0)).imag
    )  # on which side of the rocker the coupler goes on
    q = -sign * angle + 1j * h  # u, v below are analytic in q: real pairs instead of complex numbers
    c, s = np.cos(q), np.sin(q)
    px, pz = pin.real * c - pin.imag * s, pin.real * s + pin.imag * c
    dx, dz = px - hinge.real, pz - hinge.imag
    d2 = dx * dx + dz * dz
    a = (d2 + rocker**2 - coupler**2) / (2.0 * d2)
    b = np.sqrt(rocker**2 / d2 - a * a)
    for side in (1.0, -1.0):
        kx, kz = hinge.real + a * dx - side * b * dz, hinge.imag + a * dz + side * b * dx
        turn = (kx - hinge.real) * (pz - kz) - (kz - hinge.imag) * (px - kx)
        if np.sign(turn.real) == sense:
            length = np.sqrt((kx - base.real) ** 2 + (kz - base.imag) ** 2)
            return -sign * length.imag / h
    raise AssertionError


def lever_of(statics, f, angle):
    """Torque about the joint per force along the cylinder, positive where it lengthens."""
    link = statics.machine.link(f.moves)
    if f.actuator == "ram":
        return 1.0
    if isinstance(f.pins, FourBar):
        return stroke_rate(f, link, angle)
    assert isinstance(f.pins, Pins)
    base, rod = statics.point(link.parent, f.pins.base), statics.point(link.name, f.pins.rod)
    joint = statics.point(link.name, {})
    axis = statics.point(link.name, {"xyz"["xyz".index(link.axis[-1])]: 1.0}) - joint
    axis = -axis if link.axis[0] == "-" else axis
    return float(np.cross(rod - joint, (rod - base) / np.linalg.norm(rod - base)) @ axis)


def independent(machine, positions, lifting):
    """Tipping load, hydraulic load and capacity of one pose."""
    statics = Statics(machine, positions)
    corners = machine.chassis.corners
    parts = [*statics.masses(), (machine.chassis.mass, np.array([machine.chassis.cg.get(c, 0.0) for c in "xyz"]))]
    tipping = np.inf
    for k, (x0, y0, _) in enumerate(corners):
        x1, y1, _ = corners[(k + 1) % len(corners)]
        axis = np.array([x1 - x0, y1 - y0, 0.0])
        origin, down = np.array([x0, y0, 0.0]), np.array([0.0, 0.0, -1.0])
        moment = sum(m * np.cross(at - origin, down) @ axis for m, at in parts)
        of_load = np.cross(statics.tip - origin, down) @ axis
        if of_load > 0.0:
            tipping = min(tipping, max(-moment / of_load, 0.0))
    hydraulic, p_return = np.inf, machine.tank.return_pressure
    for place, f in enumerate(machine.functions):
        bare, per_kg = statics.torques[place], statics.torques_per_kg[place]
        if f.actuator == "motor":
            assert abs(per_kg) < 1e-9
            continue
        head, rod = (f.drive.number * pi / 4.0 * (f.drive.bore**2 - d**2) for d in (0.0, f.drive.rod))
        pump = next(c.pump for c in machine.circuits if f.name in c.functions)
        most = min(pump.relief, f.line.relief) if f.name == lifting else f.line.relief
        lever = lever_of(statics, f, positions[place])
        ends = sorted([lever * (most * head - p_return * rod), -lever * (most * rod - p_return * head)])
        own = ((ends[1] - bare) if per_kg > 0.0 else (ends[0] - bare)) / per_kg if abs(per_kg) > 1e-8 else np.inf
        hydraulic = min(hydraulic, max(own, 0.0) if ends[0] <= bare <= ends[1] else 0.0)
    return tipping, hydraulic, min(0.75 * tipping, 0.87 * hydraulic)


def poses(machine, count=7):
    rng = np.random.default_rng(3)
    low, high = (
        np.array([np.clip(getattr(f.stops, e), -2.0, 2.0) for f in machine.functions]) for e in ("low", "high")
    )
    return low + (high - low) * rng.random((count, len(low)))


@pytest.mark.parametrize("name", MACHINES)
def test_capacity_is_that_of_independent_statics(name):
    machine = load_machine(name)
    lifting, rows = machine.names[-2], poses(machine)
    found = lift_limits(machine, rows, lifting)
    for k, row in enumerate(rows):
        tipping, hydraulic, capacity = independent(machine, row, lifting)
        assert found.tipping[k] == pytest.approx(tipping, rel=1e-9)
        assert found.hydraulic[k] == pytest.approx(hydraulic, rel=1e-9, abs=1e-7)
        assert found.capacity[k] == pytest.approx(capacity, rel=1e-9, abs=1e-7)
    assert found.by_tipping.any() != found.by_tipping.all() or name != "excavator_22t"


def test_static_torques_are_weights_times_arms():
    machine = load_machine("wheel_loader")
    lift, tilt = 0.3, -0.2
    ((torque, _),) = static_torques(machine, np.array([[lift, tilt]]), 100.0)
    bucket = 2.6 * cos(lift)
    arm = 1250.0 * (1.25 * cos(lift) - 0.1 * sin(lift))
    load = 3650.0 * (bucket + 0.65 * cos(lift + tilt) - 0.35 * sin(lift + tilt)) + 100.0 * (
        bucket + 1.3 * cos(lift + tilt)
    )
    assert torque == pytest.approx(9.81 * (arm + load), rel=1e-12)


def test_pressures_that_hold_are_equal_to_the_torque():
    machine = load_machine("wheel_loader")
    row = np.array([[0.1, 0.2]])
    (p_a, p_b), _ = holding_pressures(machine, row, 500.0)[0]
    statics = Statics(machine, row[0])
    lever = lever_of(statics, machine.functions[0], row[0, 0])
    head, rod = (2 * pi / 4.0 * (0.12**2 - d**2) for d in (0.0, 0.07))
    torque = statics.torques[0] + 500.0 * statics.torques_per_kg[0]
    assert (p_a * head - p_b * rod) * lever == pytest.approx(torque, rel=1e-9)
    assert min(p_a, p_b) == machine.tank.return_pressure


def test_nothing_is_lifted_without_gravity():
    with pytest.raises(InputError, match="gravity = 0"):
        lift_limits(load_machine("wheel_loader")._replace(gravity=0.0), np.zeros((1, 2)), "lift")
