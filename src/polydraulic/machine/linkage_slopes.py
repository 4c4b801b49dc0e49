"""Slopes of the torques that a motion needs: M(q) q'' + h(q, q') + gravity over boom angle, stick angle and joint rates."""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import SinCos
from polydraulic.machine.linkage import Linkage
from polydraulic.machine.state import Links


class MotionSlopes(NamedTuple):
    """Slopes of the three torques; nothing depends on the swing angle."""

    by_boom: Links  # N m/rad
    by_stick: Links
    by_swing_rate: Links  # N m s/rad
    by_boom_rate: Links
    by_stick_rate: Links


@kernel
def motion_slopes(b: SinCos, s: SinCos, rate: Links, acceleration: Links, m: Linkage) -> MotionSlopes:
    """Slopes at a position, motion and acceleration; the other arguments are those of `motion`."""
    cos_both, sin_both = b.cos * s.cos - b.sin * s.sin, b.sin * s.cos + b.cos * s.sin
    cos_boom, sin_boom = b.cos * m.boom_cos - b.sin * m.boom_sin, b.sin * m.boom_cos + b.cos * m.boom_sin
    cos_stick = cos_both * m.stick_cos - sin_both * m.stick_sin
    sin_stick = sin_both * m.stick_cos + cos_both * m.stick_sin
    cos_rel, sin_rel = s.cos * m.stick_cos - s.sin * m.stick_sin, s.sin * m.stick_cos + s.cos * m.stick_sin

    x_boom, z_boom = m.boom_cg * cos_boom, m.boom_cg * sin_boom
    x_stick, z_stick = m.stick_cg * cos_stick, m.stick_cg * sin_stick
    x_far, z_far = m.boom_length * b.cos + x_stick, m.boom_length * b.sin + z_stick
    r_boom, r_stick = m.a1 + x_boom, m.a1 + x_far
    mx_boom, mz_boom = m.boom_mass * x_boom + m.stick_mass * x_far, m.boom_mass * z_boom + m.stick_mass * z_far
    mx_stick, mz_stick = m.stick_mass * x_stick, m.stick_mass * z_stick
    fold = m.stick_mass * m.stick_cg * m.boom_length
    k, k_stick = fold * sin_rel, fold * cos_rel

    # half the slopes of m11 over boom and stick angle, and their slopes
    turn = m.stick_slender * (cos_both * cos_both - sin_both * sin_both)
    slope_stick = m.stick_slender * sin_both * cos_both - r_stick * mz_stick
    slope_boom = m.boom_slender * b.sin * b.cos - m.boom_mass * r_boom * z_boom
    slope_boom += m.stick_slender * sin_both * cos_both - m.stick_mass * r_stick * z_far
    boom_boom = m.boom_slender * (b.cos * b.cos - b.sin * b.sin) + m.boom_mass * (z_boom * z_boom - r_boom * x_boom)
    boom_boom += turn + m.stick_mass * (z_far * z_far - r_stick * x_far)
    boom_stick = turn + z_far * mz_stick - r_stick * mx_stick
    stick_stick = turn + z_stick * mz_stick - r_stick * mx_stick

    w, p, q = rate.swing, rate.boom, rate.stick
    a, c, e = acceleration.swing, acceleration.boom, acceleration.stick
    both = (2.0 * p + q) * q
    return MotionSlopes(
        Links(
            2.0 * slope_boom * a
            + m.d * (mx_boom * c + mx_stick * e)
            + 2.0 * w * (boom_boom * p + boom_stick * q)
            - m.d * (mz_boom * p * p + mz_stick * both),
            m.d * mx_boom * a - boom_boom * w * w - m.gravity * mz_boom,
            m.d * mx_stick * a - boom_stick * w * w - m.gravity * mz_stick,
        ),
        Links(
            2.0 * slope_stick * a
            + m.d * mx_stick * (c + e)
            + 2.0 * w * (boom_stick * p + stick_stick * q)
            - m.d * mz_stick * (p * p + both),
            m.d * mx_stick * a - k * (2.0 * c + e) - k_stick * both - boom_stick * w * w - m.gravity * mz_stick,
            m.d * mx_stick * a - k * c + k_stick * p * p - stick_stick * w * w - m.gravity * mz_stick,
        ),
        Links(2.0 * (slope_boom * p + slope_stick * q), -2.0 * slope_boom * w, -2.0 * slope_stick * w),
        Links(
            2.0 * w * slope_boom + 2.0 * m.d * (mx_boom * p + mx_stick * q),
            -2.0 * k * q,
            2.0 * k * p,
        ),
        Links(2.0 * w * slope_stick + 2.0 * m.d * mx_stick * (p + q), -2.0 * k * (p + q), 0.0),
    )
