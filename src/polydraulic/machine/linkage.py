"""Subsystem 4, the linkage: equations of motion of three joints in closed form, and the end-effector's position.

M(q) q'' + h(q, q') + gravity = torques, with swing, boom and stick in this order. Boom and stick move in a plane that turns
with the upper structure, at the lateral distance d from its axis; d couples the swing to the other two.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import SinCos, sincos_of
from polydraulic.machine.state import Links
from polydraulic.parameters.schema import Geometry, Machine


class Linkage(NamedTuple):
    """Masses and lengths, multiplied out; the centres' angles above the pin lines as sine and cosine."""

    swing_inertia: float  # about the swing axis: upper structure, and both masses at the distance d
    boom_mass: float
    boom_cg: float
    boom_inertia: float  # pitch, about the boom joint, with the stick's mass at the stick joint
    boom_transverse: float  # about the centre: yaw with the boom level
    boom_slender: float  # longitudinal - transverse
    boom_sin: float
    boom_cos: float
    stick_mass: float
    stick_cg: float
    stick_inertia: float  # pitch, about the stick joint
    stick_transverse: float
    stick_slender: float
    stick_sin: float
    stick_cos: float
    boom_length: float
    a1: float
    d: float
    gravity: float


class Symmetric(NamedTuple):
    """A symmetric matrix over swing (1), boom (2) and stick (3)."""

    m11: float
    m12: float
    m13: float
    m22: float
    m23: float
    m33: float


class Motion(NamedTuple):
    """Mass matrix in kg m2, and the torques in N m that motion and gravity need."""

    mass: Symmetric
    bias: Links  # Coriolis and centrifugal
    gravity: Links


class Held(NamedTuple):
    """Which joints stand still whatever pushes them."""

    swing: bool
    boom: bool
    stick: bool


def prepare_linkage(machine: Machine) -> Linkage:
    """Collect the constants of the equations of motion."""
    boom, stick, g = machine.boom.body, machine.stick.body, machine.geometry
    return Linkage(
        swing_inertia=machine.swing.body.inertia + (boom.mass + stick.mass) * g.d**2,
        boom_mass=boom.mass,
        boom_cg=boom.cg,
        boom_inertia=boom.inertia_transverse + boom.mass * boom.cg**2 + stick.mass * g.boom_length**2,
        boom_transverse=boom.inertia_transverse,
        boom_slender=boom.inertia_longitudinal - boom.inertia_transverse,
        boom_sin=sin(boom.cg_angle),
        boom_cos=cos(boom.cg_angle),
        stick_mass=stick.mass,
        stick_cg=stick.cg,
        stick_inertia=stick.inertia_transverse + stick.mass * stick.cg**2,
        stick_transverse=stick.inertia_transverse,
        stick_slender=stick.inertia_longitudinal - stick.inertia_transverse,
        stick_sin=sin(stick.cg_angle),
        stick_cos=cos(stick.cg_angle),
        boom_length=g.boom_length,
        a1=g.a1,
        d=g.d,
        gravity=g.gravity,
    )


@kernel
def motion(b: SinCos, s: SinCos, rate: Links, m: Linkage) -> Motion:
    """Mass matrix and torques at a position and motion.

    Parameters
    ----------
    b, s : SinCos
        Of the boom's angle above the horizontal and of the stick's angle from the boom line.
    rate : Links, rad/s
    m : Linkage
    """
    # directions: stick in space, centre of the boom, centre of the stick in space and from the boom line
    cos_both, sin_both = b.cos * s.cos - b.sin * s.sin, b.sin * s.cos + b.cos * s.sin
    cos_boom, sin_boom = b.cos * m.boom_cos - b.sin * m.boom_sin, b.sin * m.boom_cos + b.cos * m.boom_sin
    cos_stick = cos_both * m.stick_cos - sin_both * m.stick_sin
    sin_stick = sin_both * m.stick_cos + cos_both * m.stick_sin
    cos_rel, sin_rel = s.cos * m.stick_cos - s.sin * m.stick_sin, s.sin * m.stick_cos + s.cos * m.stick_sin

    # centres of the two masses, outward and upward: boom, stick from its joint, stick from the boom joint
    x_boom, z_boom = m.boom_cg * cos_boom, m.boom_cg * sin_boom
    x_stick, z_stick = m.stick_cg * cos_stick, m.stick_cg * sin_stick
    x_far, z_far = m.boom_length * b.cos + x_stick, m.boom_length * b.sin + z_stick
    r_boom, r_stick = m.a1 + x_boom, m.a1 + x_far  # from the swing axis
    mx_boom, mz_boom = m.boom_mass * x_boom + m.stick_mass * x_far, m.boom_mass * z_boom + m.stick_mass * z_far
    mx_stick, mz_stick = m.stick_mass * x_stick, m.stick_mass * z_stick

    fold = m.stick_mass * m.stick_cg * m.boom_length
    k = fold * sin_rel
    m23 = m.stick_inertia + fold * cos_rel
    mass = Symmetric(
        m.swing_inertia
        + m.boom_mass * r_boom * r_boom
        + m.stick_mass * r_stick * r_stick
        + m.boom_transverse
        + m.boom_slender * b.sin * b.sin
        + m.stick_transverse
        + m.stick_slender * sin_both * sin_both,
        m.d * mz_boom,
        m.d * mz_stick,
        m.boom_inertia + m.stick_inertia + 2.0 * fold * cos_rel,
        m23,
        m.stick_inertia,
    )
    # half the slopes of m11 over boom and stick angle
    slope_stick = m.stick_slender * sin_both * cos_both - r_stick * mz_stick
    slope_boom = m.boom_slender * b.sin * b.cos - m.boom_mass * r_boom * z_boom
    slope_boom += m.stick_slender * sin_both * cos_both - m.stick_mass * r_stick * z_far
    w, p, q = rate.swing, rate.boom, rate.stick
    bias = Links(
        2.0 * w * (slope_boom * p + slope_stick * q) + m.d * (mx_boom * p * p + mx_stick * (2.0 * p + q) * q),
        -k * (2.0 * p + q) * q - slope_boom * w * w,
        k * p * p - slope_stick * w * w,
    )
    return Motion(mass, bias, Links(0.0, m.gravity * mx_boom, m.gravity * mx_stick))


@kernel
def solve_motion(m: Symmetric, held: Held, right: Links) -> Links:
    """Solve M v = right for the joints that are free; held ones get 0. One division, by the determinant."""
    m11 = 1.0 if held.swing else m.m11
    m22 = 1.0 if held.boom else m.m22
    m33 = 1.0 if held.stick else m.m33
    m12 = 0.0 if (held.swing or held.boom) else m.m12
    m13 = 0.0 if (held.swing or held.stick) else m.m13
    m23 = 0.0 if (held.boom or held.stick) else m.m23
    r1 = 0.0 if held.swing else right.swing
    r2 = 0.0 if held.boom else right.boom
    r3 = 0.0 if held.stick else right.stick
    c11, c12, c13 = m22 * m33 - m23 * m23, m13 * m23 - m12 * m33, m12 * m23 - m13 * m22
    c22, c23, c33 = m11 * m33 - m13 * m13, m12 * m13 - m11 * m23, m11 * m22 - m12 * m12
    scale = 1.0 / (m11 * c11 + m12 * c12 + m13 * c13)
    return Links(
        (c11 * r1 + c12 * r2 + c13 * r3) * scale,
        (c12 * r1 + c22 * r2 + c23 * r3) * scale,
        (c13 * r1 + c23 * r2 + c33 * r3) * scale,
    )


@kernel
def times(m: Symmetric, v: Links) -> Links:
    """M v: momentum of rates, torque of accelerations."""
    return Links(
        m.m11 * v.swing + m.m12 * v.boom + m.m13 * v.stick,
        m.m12 * v.swing + m.m22 * v.boom + m.m23 * v.stick,
        m.m13 * v.swing + m.m23 * v.boom + m.m33 * v.stick,
    )


class Tip(NamedTuple):
    """Position of the stick's tip in m, from the boom foot's height on the swing axis."""

    x: float
    y: float
    z: float


@kernel
def tip(swing: SinCos, boom: SinCos, both: SinCos, g: Geometry) -> Tip:
    """Turn the arm's reach about the swing axis; `both` is of the stick's angle in space."""
    reach = g.a1 + g.boom_length * boom.cos + g.stick_length * both.cos
    return Tip(
        reach * swing.cos - g.d * swing.sin,
        reach * swing.sin + g.d * swing.cos,
        g.boom_length * boom.sin + g.stick_length * both.sin,
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
    parts = (angle[..., 0], angle[..., 1], angle[..., 1] + angle[..., 2])
    swing, boom, both = (SinCos(*turn) for turn in map(sincos_of, parts))
    on_arrays = getattr(tip, "py_func", tip)
    return np.stack(on_arrays(swing, boom, both, g), axis=-1)


def end_effector_printed(angle: np.ndarray, g: Geometry) -> np.ndarray:
    """Position by the formula as printed (thesis 5.3.1), for comparison only.

    Its two d terms have the same sign, so that it is not a rotation; `angle` and `g` are those of `end_effector`.
    """
    position = end_effector(angle, g)
    position[..., 0] += 2.0 * g.d * np.sin(angle[..., 0])
    return position
