"""Statics of a machine another way: weights in MuJoCo, levers of cylinders from their pins."""

import numpy as np
import pytest

from helpers.trees import mujoco_model
from polydraulic.parameters.layout.parts import FourBar, Pins
from polydraulic.simulation.layout.tree import tree_of


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
