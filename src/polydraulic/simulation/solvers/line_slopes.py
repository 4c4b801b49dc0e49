"""One actuator's two lines linearised: their slopes, and how the outlet is eliminated from (e - J) k = right."""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.hose import LineStep


class Hoses(NamedTuple):
    """The lines of one link: d(p_in)/dt = gain_in (q_in - push_in w - leakage (p_in - p_out) - external p_in), and the outlet alike.

    `push` is the torque that a pressure exerts on the joint, over the pressure, and also the volume that a radian draws.
    """

    gain_in: float  # 1/C, 0 where a bound holds the pressure
    gain_out: float
    push_in: float  # m3/rad
    push_out: float
    turn_in: float  # slope of push over the angle
    turn_out: float
    leakage: float
    external: float  # leakage
    outlet: float  # slope of q_out over p_out, m3/s/Pa
    draw: float  # joint rate


@kernel
def hoses_at(
    spool: float, p_a: float, p_b: float, a: float, b: float, turn_a: float, turn_b: float,
    free_a: float, free_b: float, k_out: float, draw: float, line: LineStep,
) -> Hoses:  # fmt: skip
    """Lines at a state; `turn_` are slopes of the levers `a` and `b`, `free_` 0 where a bound holds a pressure, `draw` is the joint's rate."""
    forward = spool >= 0.0
    root = sqrt(max((p_b if forward else p_a) - line.p_return, 0.0))
    gain_a, gain_b = free_a * line.gain_a, free_b * line.gain_b
    return Hoses(
        gain_a if forward else gain_b,
        gain_b if forward else gain_a,
        a if forward else -b,
        -b if forward else a,
        turn_a if forward else -turn_b,
        -turn_b if forward else turn_a,
        line.leakage,
        line.external,
        0.5 * k_out / root if root > 0.0 else 0.0,
        draw,
    )


@kernel
def outlet_root(spool: float, p_a: float, p_b: float, line: LineStep) -> float:
    """Root of the drop over the outlet: its flow over its conductance."""
    return sqrt(max((p_b if spool >= 0.0 else p_a) - line.p_return, 0.0))


class EliminatedOutlet(NamedTuple):
    """A link's lines without its outlet: pivot k_in = right + feel k_rate (+ the other's k_in)."""

    over_out: float  # one over the outlet's pivot
    pivot: float
    feel_in: float  # of the inlet over the joint rate, with what comes by the angle
    feel_out: float
    feel: float  # of the inlet, with what comes by the outlet


@kernel
def eliminate_outlet(e: float, own: float, h: Hoses) -> EliminatedOutlet:
    """Lines without the outlet; `e` in 1/s, `own` is the slope of q_in over p_in."""
    over_out = 1.0 / (e + h.gain_out * (h.outlet + h.leakage + h.external))
    feel_in = -h.gain_in * (h.push_in + h.turn_in * h.draw / e)
    feel_out = -h.gain_out * (h.push_out + h.turn_out * h.draw / e)
    back = h.gain_in * h.leakage * over_out
    pivot = e + h.gain_in * (h.leakage + h.external - own) - back * h.gain_out * h.leakage
    return EliminatedOutlet(over_out, pivot, feel_in, feel_out, feel_in + back * feel_out)


@kernel
def torque_change(k_in: float, k_rate: float, h: Hoses, x: EliminatedOutlet) -> float:
    """Change of torque that comes with changes of the inlet pressure and of the rate."""
    k_out = x.over_out * (h.gain_out * h.leakage * k_in + x.feel_out * k_rate)
    return h.push_in * k_in + h.push_out * k_out


class LineSides(NamedTuple):
    """Right sides of a link's inlet, without its outlet, and of its outlet."""

    inlet: float
    outlet: float


@kernel
def line_sides(p_in: float, p_out: float, by_angle: float, h: Hoses, x: EliminatedOutlet) -> LineSides:
    """Right sides at right sides of both pressures, and with what the angle brings by itself, in rad."""
    outlet = p_out - h.gain_out * h.turn_out * h.draw * by_angle
    inlet = p_in - h.gain_in * h.turn_in * h.draw * by_angle
    return LineSides(inlet + h.gain_in * h.leakage * x.over_out * outlet, outlet)


@kernel
def outlet_change(side: LineSides, k_in: float, k_rate: float, h: Hoses, x: EliminatedOutlet) -> float:
    """Change of the outlet pressure that comes with changes of the inlet pressure and of the rate."""
    return x.over_out * (side.outlet + h.gain_out * h.leakage * k_in + x.feel_out * k_rate)
