"""Subsystem 3, the hoses: net flow -> line pressure (Eqs 4 and 6), with leakage from line to line and to the tank.

Step: the pressurised side is explicit, since its flow hardly depends on the pressure while the bypass is open. The
outlet is the stiff side and is solved implicitly in closed form: with s = sqrt(P_o - P_e) and Q_o = k s,
s^2 + (dt k / C) s = P_o - P_e + dt inflow / C. A floor (make-up valves) and a relief valve bound the pressures.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.parameters.schema import Line, Tank


class LineStep(NamedTuple):
    """The two hoses of an actuator prepared for one step size."""

    gain_a: float  # dt / C_A
    gain_b: float
    leakage: float
    external: float  # leakage
    relief: float
    floor: float
    p_return: float


class Ports(NamedTuple):
    """Pressures at the pressurised port and at the outlet, Pa."""

    p_in: float
    p_out: float


class Pressures(NamedTuple):
    """Line pressures at A and B after a step, and the outlet flow during it."""

    p_a: float
    p_b: float
    q_out: float


def prepare_line(line: Line, tank: Tank, dt: float) -> LineStep:
    """Precompute what does not change from step to step."""
    return LineStep(
        dt / line.compliance_a,
        dt / line.compliance_b,
        line.leakage,
        line.external_leakage,
        line.relief,
        tank.floor,
        tank.return_pressure,
    )


@kernel
def ports(spool: float, p_a: float, p_b: float) -> Ports:
    """Which line the valve feeds: A for a positive spool, B for a negative one."""
    return Ports(p_a if spool >= 0.0 else p_b, p_b if spool >= 0.0 else p_a)


@kernel
def _bounded(p: float, line: LineStep) -> float:
    return min(max(p, line.floor), line.relief)


@kernel
def line_step(
    spool: float,
    p_a: float,
    p_b: float,
    q_in: float,
    k_out: float,
    swept_a: float,
    swept_b: float,
    line: LineStep,
) -> Pressures:
    """Line pressures after one step.

    Parameters
    ----------
    spool : float, m
        Its sign says which line is fed.
    p_a, p_b : float, Pa
    q_in : float, m3/s
        Flow from the valve into the pressurised line.
    k_out : float, m3/s/Pa^0.5
        Conductance of the outlet orifice.
    swept_a, swept_b : float, m3/s
        Flow that the moving actuator draws from line A and from line B.
    """
    forward = spool >= 0.0
    leak = line.leakage * (p_a - p_b)
    drawn_a, drawn_b = swept_a + leak + line.external * p_a, swept_b - leak + line.external * p_b

    p_in = p_a if forward else p_b
    gain_in = line.gain_a if forward else line.gain_b
    drawn_in = drawn_a if forward else drawn_b
    p_in = _bounded(p_in + gain_in * (q_in - drawn_in), line)

    p_out = p_b if forward else p_a
    gain_out = line.gain_b if forward else line.gain_a
    drawn_out = drawn_b if forward else drawn_a
    c = gain_out * k_out
    shut = p_out - line.p_return - gain_out * drawn_out  # drop over the outlet if it were shut
    rest = max(shut, 0.0)
    s = 2.0 * rest / (c + sqrt(c * c + 4.0 * rest) + 1e-300)
    q_out = k_out * s
    p_out = _bounded(p_out - gain_out * (drawn_out + q_out), line)

    return Pressures(p_in if forward else p_out, p_out if forward else p_in, q_out)


@kernel
def rest_outlet(k: float, p_out: float, line: LineStep) -> float:
    """Flow in m3/s from a line whose pressure stays as it is."""
    return k * sqrt(max(p_out - line.p_return, 0.0))
