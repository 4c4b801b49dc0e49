"""A pump with constant flow and a relief valve, and what becomes of the flow that no actuator takes."""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.valve import orifice_flow


class Pump(NamedTuple):
    """Flow in m3/s, relief setting and return-line pressure in Pa."""

    flow: float
    relief: float
    p_return: float


class Circuit(NamedTuple):
    """Flows and pressure at one pump: pump = actuators + bypass + relief."""

    q_pump: float
    q_bypass: float
    q_relief: float
    p_pump: float  # 0 where a flow model does not give it


@kernel
def share_surplus(q_in: float, k_in: float, p_in: float, k_bypass: float, pump: Pump) -> Circuit:
    """Share the flow that does not enter the actuator between bypass and relief valve, and find the pump pressure.

    The pressure follows from the wider of the two orifices that carry flow, which avoids cancellation.
    """
    surplus = pump.flow - q_in
    q_bypass = min(surplus, orifice_flow(k_bypass, pump.relief - pump.p_return))
    q_relief = surplus - q_bypass
    through_inlet = q_in / (k_in + 1e-300)
    through_bypass = q_bypass / (k_bypass + 1e-300)
    from_inlet = q_in > 0.0 and (k_in >= k_bypass or q_bypass <= 0.0)
    p = p_in + through_inlet * through_inlet if from_inlet else pump.p_return + through_bypass * through_bypass
    p = pump.relief if q_relief > 1e-9 * pump.flow else p  # less is rounding
    return Circuit(pump.flow, q_bypass, q_relief, p)


@kernel
def single_circuit(k_in: float, k_bypass: float, p_in: float, pump: Pump) -> float:
    """Flow into one actuator in m3/s: Eqs (1)-(3) solved in closed form.

    Eliminating the pump pressure leaves a quadratic in the flow; written with the root in the denominator it has no
    cancellation, and its special cases (inlet shut, bypass shut, either check valve closed) are exactly those in which
    it leaves [0, Q], so that a clamp decides them. The relief valve bounds the pressure, hence the flow.
    """
    Q = pump.flow
    a, b = k_in * k_in, k_bypass * k_bypass
    drop = p_in - pump.p_return
    root = sqrt(max(b * (Q * Q + (a - b) * drop), 0.0))
    q = k_in * (Q * Q - b * drop) / (k_in * Q + root + 1e-300)
    return min(min(max(q, 0.0), Q), orifice_flow(k_in, pump.relief - p_in))
