"""Subsystem 4, the linkage: boom inertia and gravity torque, end-effector position.

So far the boom alone moves, with swing and stick held; then its equation of motion is
inertia * d2(angle)/dt2 = cylinder torque - gravity torque - friction torque.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import sincos
from polydraulic.parameters import Machine
from polydraulic.parameters.schema import Geometry


class Linkage(NamedTuple):
    """Masses and lengths, with the fixed angles of the centres of gravity already turned into sine and cosine."""

    boom_moment: float  # mass * distance of the centre from the joint
    boom_sin: float  # sine and cosine of the centre's angle above the pin line
    boom_cos: float
    boom_inertia: float  # about the boom joint
    stick_mass: float
    stick_cg: float
    stick_sin: float
    stick_cos: float
    stick_inertia: float  # about its centre
    boom_length: float
    gravity: float


class BoomLoad(NamedTuple):
    """What the cylinders have to move."""

    inertia: float  # kg m2
    gravity: float  # torque in N m that pulls the boom down


def prepare_linkage(machine: Machine) -> Linkage:
    """Collect the constants of the equation of motion."""
    boom, stick = machine.boom.body, machine.stick.body
    return Linkage(
        boom_moment=boom.mass * boom.cg,
        boom_sin=sin(boom.cg_angle),
        boom_cos=cos(boom.cg_angle),
        boom_inertia=boom.inertia_transverse + boom.mass * boom.cg**2,
        stick_mass=stick.mass,
        stick_cg=stick.cg,
        stick_sin=sin(stick.cg_angle),
        stick_cos=cos(stick.cg_angle),
        stick_inertia=stick.inertia_transverse,
        boom_length=machine.geometry.boom_length,
        gravity=machine.geometry.gravity,
    )


@kernel
def boom_load(angle_boom: float, angle_stick: float, m: Linkage) -> BoomLoad:
    """Inertia and gravity torque about the boom joint, swing and stick held (angles in rad)."""
    b, s = sincos(angle_boom), sincos(angle_stick)
    # direction of the stick's centre: relative to the boom, and in space
    cos_rel = s.cos * m.stick_cos - s.sin * m.stick_sin
    sin_rel = s.sin * m.stick_cos + s.cos * m.stick_sin
    cos_abs = b.cos * cos_rel - b.sin * sin_rel
    reach2 = (
        m.boom_length * m.boom_length + m.stick_cg * m.stick_cg + 2.0 * m.boom_length * m.stick_cg * cos_rel
    )  # squared distance of the stick's centre from the boom joint
    cos_boom = b.cos * m.boom_cos - b.sin * m.boom_sin
    return BoomLoad(
        m.boom_inertia + m.stick_inertia + m.stick_mass * reach2,
        m.gravity * (m.boom_moment * cos_boom + m.stick_mass * (m.boom_length * b.cos + m.stick_cg * cos_abs)),
    )


def end_effector(angle: np.ndarray, g: Geometry) -> np.ndarray:
    """Position of the stick's tip by a proper rotation about the swing axis.

    Parameters
    ----------
    angle : (..., 3) array, rad
        Joint angles, swing, boom, stick.
    g : Geometry

    Returns
    -------
    (..., 3) array, m
        X, Y, Z from the boom foot's height on the swing axis.
    """
    swing, boom, both = angle[..., 0], angle[..., 1], angle[..., 1] + angle[..., 2]
    reach = g.a1 + g.boom_length * np.cos(boom) + g.stick_length * np.cos(both)
    x = reach * np.cos(swing) - g.d * np.sin(swing)
    y = reach * np.sin(swing) + g.d * np.cos(swing)
    z = g.boom_length * np.sin(boom) + g.stick_length * np.sin(both)
    return np.stack([x, y, z], axis=-1)


def end_effector_printed(angle: np.ndarray, g: Geometry) -> np.ndarray:
    """Position by the formula as printed (thesis 5.3.1), for comparison only.

    Its two d terms have the same sign, so that it is not a rotation; `angle` and `g` are those of `end_effector`.
    """
    position = end_effector(angle, g)
    position[..., 0] += 2.0 * g.d * np.sin(angle[..., 0])
    return position
