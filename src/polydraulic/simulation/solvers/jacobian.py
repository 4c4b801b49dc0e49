"""The continuous equations linearised at a state, and the solution of (1/g - J) k = r by blocks.

Unknown are the changes k of 12 quantities: two line pressures, angle and rate of each link; spools are known. Per link the lines
are named by their port, `in` and `out`, which halves the cases. The outlet is eliminated, then the inlet (swing and
stick share a pump: two together), then the angle; what is left is a 3 x 3 system in the joint rates.
"""

from typing import Any, NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import sincos
from polydraulic.flow.dispatch import flow_slopes
from polydraulic.machine.actuator import friction_slope, lever_slope
from polydraulic.machine.linkage import Held, times
from polydraulic.machine.linkage_slopes import MotionSlopes, motion_slopes
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State
from polydraulic.simulation.solvers.line_slopes import (
    EliminatedOutlet,
    Hoses,
    eliminate_outlet,
    hoses_at,
    line_sides,
    outlet_change,
    outlet_root,
    torque_change,
)
from polydraulic.simulation.solvers.right_hand_side import Rates


class Slow(NamedTuple):
    """The 12 quantities, or their rates."""

    p_in: Links
    p_out: Links
    angle: Links
    rate: Links


class Free(NamedTuple):
    """1 where a line pressure moves, 0 where a bound holds it."""

    a: Links
    b: Links


class Linear(NamedTuple):
    """All slopes at a state."""

    swing: Hoses
    boom: Hoses
    stick: Hoses
    own: Links  # slopes of q_in over the own p_in
    swing_by_stick: float
    stick_by_swing: float
    motion: MotionSlopes
    stiffness: Links  # slope of the pressures' torque over the own angle
    friction: Links
    drift: Slow  # rates' own change in time, because the spools move


@kernel
def linearise(model: Any, plant: Plant, x: State, r: Rates, inside: Links, velocity: Links, free: Free) -> Linear:
    """Slopes at a state.

    Parameters
    ----------
    model : flow model with slopes
    plant : Plant
        Prepared for dt = 1 s.
    x : State
    r : Rates
        Of this state.
    inside : Links, m
        Spools on the segments of their tables on which the step goes on.
    velocity : Links, m/s
        Of the spools.
    free : Free
    """
    f = flow_slopes(model, x.spool, inside, r.flows)
    b, s = sincos(x.angle.boom), sincos(x.angle.stick)
    boom, stick = plant.boom.cylinder, plant.stick.cylinder
    turn_boom = lever_slope(b, r.position.levers.a.boom / boom.area_a, boom)
    turn_stick = lever_slope(s, r.position.levers.a.stick / stick.area_a, stick)
    levers_a, levers_b, k, w = r.position.levers.a, r.position.levers.b, r.flows.k_out, x.rate
    swing_hoses = hoses_at(
        inside.swing, x.p_a.swing, x.p_b.swing, levers_a.swing, levers_b.swing, 0.0, 0.0,
        free.a.swing, free.b.swing, k.swing, w.swing, plant.swing.line,
    )  # fmt: skip
    boom_hoses = hoses_at(
        inside.boom, x.p_a.boom, x.p_b.boom, levers_a.boom, levers_b.boom, turn_boom * boom.area_a,
        turn_boom * boom.area_b, free.a.boom, free.b.boom, k.boom, w.boom, plant.boom.line,
    )  # fmt: skip
    stick_hoses = hoses_at(
        inside.stick, x.p_a.stick, x.p_b.stick, levers_a.stick, levers_b.stick, turn_stick * stick.area_a,
        turn_stick * stick.area_b, free.a.stick, free.b.stick, k.stick, w.stick, plant.stick.line,
    )  # fmt: skip
    nothing = Links(0.0, 0.0, 0.0)
    drift = Slow(
        Links(
            swing_hoses.gain_in
            * (f.by_own_spool.swing * velocity.swing + f.swing_by_stick_spool * velocity.stick),
            boom_hoses.gain_in * f.by_own_spool.boom * velocity.boom,
            stick_hoses.gain_in
            * (f.by_own_spool.stick * velocity.stick + f.stick_by_swing_spool * velocity.swing),
        ),
        Links(
            -swing_hoses.gain_out * f.outlet_by_spool.swing * velocity.swing
            * outlet_root(inside.swing, x.p_a.swing, x.p_b.swing, plant.swing.line),
            -boom_hoses.gain_out * f.outlet_by_spool.boom * velocity.boom
            * outlet_root(inside.boom, x.p_a.boom, x.p_b.boom, plant.boom.line),
            -stick_hoses.gain_out * f.outlet_by_spool.stick * velocity.stick
            * outlet_root(inside.stick, x.p_a.stick, x.p_b.stick, plant.stick.line),
        ),
        nothing,
        nothing,
    )  # fmt: skip
    return Linear(
        swing_hoses,
        boom_hoses,
        stick_hoses,
        f.by_own_p,
        f.swing_by_stick_p,
        f.stick_by_swing_p,
        motion_slopes(b, s, x.rate, r.acceleration, plant.linkage),
        Links(
            0.0,
            turn_boom * (boom.area_a * x.p_a.boom - boom.area_b * x.p_b.boom),
            turn_stick * (stick.area_a * x.p_a.stick - stick.area_b * x.p_b.stick),
        ),
        Links(
            friction_slope(w.swing, plant.swing.friction),
            friction_slope(w.boom, plant.boom.friction),
            friction_slope(w.stick, plant.stick.friction),
        ),
        drift,
    )


class Factors(NamedTuple):
    """What all solutions at a state and step size have in common."""

    e: float
    swing: EliminatedOutlet
    boom: EliminatedOutlet
    stick: EliminatedOutlet
    over_both: float  # one over the determinant of the inlets of swing and stick
    cross_swing: float  # minus their off-diagonal elements
    cross_stick: float
    n11: float
    n12: float
    n13: float
    n21: float
    n22: float
    n23: float
    n31: float
    n32: float
    n33: float
    over_all: float


@kernel
def factorise(e: float, a: Linear, r: Rates, held: Held) -> Factors:
    """Eliminate lines and angles from e - J; `e` in 1/s, `held` joints do not move."""
    swing, boom = eliminate_outlet(e, a.own.swing, a.swing), eliminate_outlet(e, a.own.boom, a.boom)
    stick = eliminate_outlet(e, a.own.stick, a.stick)
    cross_swing, cross_stick = a.swing.gain_in * a.swing_by_stick, a.stick.gain_in * a.stick_by_swing
    over_both = 1.0 / (swing.pivot * stick.pivot - cross_swing * cross_stick)
    # inlet pressures that come with a unit of joint rate
    swing_swing, stick_swing = stick.pivot * swing.feel * over_both, cross_stick * swing.feel * over_both
    swing_stick, stick_stick = cross_swing * stick.feel * over_both, swing.pivot * stick.feel * over_both
    m, d = r.position.motion.mass, a.motion
    over = 1.0 / e
    n11 = e * m.m11 + d.by_swing_rate.swing + a.friction.swing - torque_change(swing_swing, 1.0, a.swing, swing)
    n12 = e * m.m12 + d.by_boom_rate.swing + d.by_boom.swing * over
    n13 = e * m.m13 + d.by_stick_rate.swing + d.by_stick.swing * over - torque_change(swing_stick, 0.0, a.swing, swing)
    n21 = e * m.m12 + d.by_swing_rate.boom
    n22 = e * m.m22 + d.by_boom_rate.boom + a.friction.boom + (d.by_boom.boom - a.stiffness.boom) * over
    n22 = n22 - torque_change(boom.feel / boom.pivot, 1.0, a.boom, boom)
    n23 = e * m.m23 + d.by_stick_rate.boom + d.by_stick.boom * over
    n31 = e * m.m13 + d.by_swing_rate.stick - torque_change(stick_swing, 0.0, a.stick, stick)
    n32 = e * m.m23 + d.by_boom_rate.stick + d.by_boom.stick * over
    n33 = e * m.m33 + d.by_stick_rate.stick + a.friction.stick + (d.by_stick.stick - a.stiffness.stick) * over
    n33 = n33 - torque_change(stick_stick, 1.0, a.stick, stick)
    n11, n22, n33 = 1.0 if held.swing else n11, 1.0 if held.boom else n22, 1.0 if held.stick else n33
    n12, n21 = 0.0 if held.swing or held.boom else n12, 0.0 if held.swing or held.boom else n21
    n13, n31 = 0.0 if held.swing or held.stick else n13, 0.0 if held.swing or held.stick else n31
    n23, n32 = 0.0 if held.boom or held.stick else n23, 0.0 if held.boom or held.stick else n32
    det = n11 * (n22 * n33 - n23 * n32) - n12 * (n21 * n33 - n23 * n31) + n13 * (n21 * n32 - n22 * n31)
    return Factors(
        e, swing, boom, stick, over_both, cross_swing, cross_stick,
        n11, n12, n13, n21, n22, n23, n31, n32, n33, 1.0 / det,
    )  # fmt: skip


@kernel
def solve(right: Slow, f: Factors, a: Linear, r: Rates, held: Held) -> Slow:
    """Solve (e - J) k = right for all 12 changes."""
    over = 1.0 / f.e
    by_angle = Links(right.angle.swing * over, right.angle.boom * over, right.angle.stick * over)
    swing = line_sides(right.p_in.swing, right.p_out.swing, by_angle.swing, a.swing, f.swing)
    boom = line_sides(right.p_in.boom, right.p_out.boom, by_angle.boom, a.boom, f.boom)
    stick = line_sides(right.p_in.stick, right.p_out.stick, by_angle.stick, a.stick, f.stick)
    # inlets and outlets while the joints keep their rates
    in_swing = (f.stick.pivot * swing.inlet + f.cross_swing * stick.inlet) * f.over_both
    in_stick = (f.swing.pivot * stick.inlet + f.cross_stick * swing.inlet) * f.over_both
    in_boom = boom.inlet / f.boom.pivot
    out_swing, out_boom = (
        outlet_change(swing, in_swing, 0.0, a.swing, f.swing),
        outlet_change(boom, in_boom, 0.0, a.boom, f.boom),
    )
    out_stick = outlet_change(stick, in_stick, 0.0, a.stick, f.stick)
    m, d = times(r.position.motion.mass, right.rate), a.motion
    b, s = by_angle.boom, by_angle.stick
    t1 = (
        m.swing - d.by_boom.swing * b - d.by_stick.swing * s + a.swing.push_in * in_swing + a.swing.push_out * out_swing
    )
    t2 = m.boom - (d.by_boom.boom - a.stiffness.boom) * b - d.by_stick.boom * s
    t2 = t2 + a.boom.push_in * in_boom + a.boom.push_out * out_boom
    t3 = m.stick - d.by_boom.stick * b - (d.by_stick.stick - a.stiffness.stick) * s
    t3 = t3 + a.stick.push_in * in_stick + a.stick.push_out * out_stick
    t1, t2, t3 = 0.0 if held.swing else t1, 0.0 if held.boom else t2, 0.0 if held.stick else t3
    rate = Links(
        (
            t1 * (f.n22 * f.n33 - f.n23 * f.n32)
            + t2 * (f.n13 * f.n32 - f.n12 * f.n33)
            + t3 * (f.n12 * f.n23 - f.n13 * f.n22)
        )
        * f.over_all,
        (
            t1 * (f.n23 * f.n31 - f.n21 * f.n33)
            + t2 * (f.n11 * f.n33 - f.n13 * f.n31)
            + t3 * (f.n13 * f.n21 - f.n11 * f.n23)
        )
        * f.over_all,
        (
            t1 * (f.n21 * f.n32 - f.n22 * f.n31)
            + t2 * (f.n12 * f.n31 - f.n11 * f.n32)
            + t3 * (f.n11 * f.n22 - f.n12 * f.n21)
        )
        * f.over_all,
    )
    felt_swing, felt_stick = f.swing.feel * rate.swing, f.stick.feel * rate.stick
    p_in = Links(
        in_swing + (f.stick.pivot * felt_swing + f.cross_swing * felt_stick) * f.over_both,
        in_boom + f.boom.feel * rate.boom / f.boom.pivot,
        in_stick + (f.swing.pivot * felt_stick + f.cross_stick * felt_swing) * f.over_both,
    )
    return Slow(
        p_in,
        Links(
            outlet_change(swing, p_in.swing, rate.swing, a.swing, f.swing),
            outlet_change(boom, p_in.boom, rate.boom, a.boom, f.boom),
            outlet_change(stick, p_in.stick, rate.stick, a.stick, f.stick),
        ),
        Links(
            by_angle.swing + rate.swing * over,
            by_angle.boom + rate.boom * over,
            by_angle.stick + rate.stick * over,
        ),
        rate,
    )
