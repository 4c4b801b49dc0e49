"""Slopes of the flows in `pump`: how they change with port pressures and spools, from the solution itself.

Linearised, a circuit is a network of conductances: an orifice that carries q has g = K^2 / (2 q), one that carries nothing 0, a
pump with torque limit its falling flow over pressure, an open relief valve one so large that the pressure stays. A moving
spool acts as a source, the change of flow at the same pressure drop. Nodes are solved without cancellation.
"""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.pump import Circuit, Pump
from polydraulic.machine.valve import Orifices

_FIRM = 1e30  # conductance of an open relief valve, m3/s/Pa
_FAINT = 1e-40  # and of a node that nothing leaves
_STEEPEST = 1e5  # root of a drop in Pa^0.5 that no circuit has


class SingleSlopes(NamedTuple):
    """Slopes of one actuator's inlet flow."""

    by_p: float  # m3/s/Pa
    by_spool: float  # m2/s


class SeriesSlopes(NamedTuple):
    """Slopes of two actuators' inlet flows over their own and the other's port pressure and spool."""

    first_by_p: float
    second_by_p: float
    other_by_p: float  # either flow over the other's port pressure
    first_by_first: float  # over spools
    first_by_second: float
    second_by_first: float
    second_by_second: float


@kernel
def _conductance(k: float, q: float) -> float:
    return k * k / (2.0 * q + 1e-30) if q > 0.0 else 0.0


@kernel
def _source(k: float, slope: float, q: float) -> float:
    """Change of flow over the spool at the same drop; none through a closed orifice, whose flow is a rounding of others."""
    return slope * min(q / (k + 1e-300), _STEEPEST) if q > 0.0 and k > 0.0 else 0.0


@kernel
def _pump(c: Circuit, pump: Pump) -> float:
    """Minus the slope of the pump's flow, less what the relief valve takes, over its pressure."""
    limited = pump.log_least < 0.0 and c.p_pump > pump.limit_start
    g = pump.limit_exponent * c.q_pump / max(c.p_pump, 1.0) if limited else 0.0
    return _FIRM if c.q_relief > 1e-9 * c.q_pump else g


@kernel
def single_slopes(k: Orifices, slope: Orifices, q_in: float, c: Circuit, pump: Pump) -> SingleSlopes:
    """Slopes at a solution of `series_1`; `slope` are those of the conductances over the spool."""
    g, rest = _conductance(k.inlet, q_in), _conductance(k.bypass, c.q_bypass) + _pump(c, pump)
    scale = 1.0 / (g + rest + 1e-300)
    inlet, bypass = _source(k.inlet, slope.inlet, q_in), _source(k.bypass, slope.bypass, c.q_bypass)
    return SingleSlopes(-g * rest * scale, (inlet * rest - g * bypass) * scale)


@kernel
def series_slopes(
    first: Orifices,
    second: Orifices,
    slope_first: Orifices,
    slope_second: Orifices,
    q_first: float,
    q_second: float,
    c: Circuit,
    pump: Pump,
) -> SeriesSlopes:
    """Slopes at a solution of `series_2`."""
    passed = q_second + c.q_bypass
    g1, g2 = _conductance(first.inlet, q_first), _conductance(second.inlet, q_second)
    between, tank = _conductance(first.bypass, passed), _conductance(second.bypass, c.q_bypass) + _FAINT
    pumped = _pump(c, pump) + _FAINT
    node1, node2 = g1 + pumped, g2 + tank
    scale = 1.0 / (node1 * (between + node2) + between * node2)
    alone1 = pumped * (between + node2) + between * node2
    alone2 = node1 * (between + tank) + between * tank
    inlet1, bypass1 = (
        _source(first.inlet, slope_first.inlet, q_first),
        _source(first.bypass, slope_first.bypass, passed),
    )
    inlet2 = _source(second.inlet, slope_second.inlet, q_second)
    bypass2 = _source(second.bypass, slope_second.bypass, c.q_bypass)
    return SeriesSlopes(
        -g1 * alone1 * scale,
        -g2 * alone2 * scale,
        g1 * between * g2 * scale,
        (inlet1 * alone1 - g1 * node2 * bypass1) * scale,
        -g1 * between * (inlet2 + bypass2) * scale,
        g2 * (node1 * bypass1 - between * inlet1) * scale,
        (inlet2 * alone2 - g2 * (node1 + between) * bypass2) * scale,
    )
