"""Slopes of circuits that a crossover valve joins: what a source at a node, or along an orifice, changes.

Linearised as in `series.slopes`, the nodes before valves 2, 1, 4 and 3 stand in a row, with the giving pump's first bypass, the crossover and
the taking pump's first bypass between them. Two sweeps along this row say what each node sees on either side of it; pressures follow by dividers.
"""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.crossover.circuit import TO_TANK, Crossed3, Crossed4
from polydraulic.machine.circuits.crossover.nodes import CrossoverOrifice
from polydraulic.machine.circuits.series.short import Series2
from polydraulic.machine.circuits.series.slopes import (
    LinearValve,
    divider,
    fall,
    fall_before,
    in_row,
    linear,
    pump_conductance,
)
from polydraulic.machine.pump import Pump
from polydraulic.machine.valve import Orifices


class CrossedSlopes3(NamedTuple):
    """Slopes of inlet flows: by_p_i_j and by_x_i_j are those of valve i over port pressure and spool of valve j."""

    by_p_1_1: float  # m3/s/Pa
    by_p_1_2: float
    by_p_1_3: float
    by_p_2_1: float
    by_p_2_2: float
    by_p_2_3: float
    by_p_3_1: float
    by_p_3_2: float
    by_p_3_3: float
    by_x_1_1: float  # m2/s
    by_x_1_2: float
    by_x_1_3: float
    by_x_2_1: float
    by_x_2_2: float
    by_x_2_3: float
    by_x_3_1: float
    by_x_3_2: float
    by_x_3_3: float


class CrossedSlopes4(NamedTuple):
    """Slopes of inlet flows: by_p_i_j and by_x_i_j are those of valve i over port pressure and spool of valve j."""

    by_p_1_1: float  # m3/s/Pa
    by_p_1_2: float
    by_p_1_3: float
    by_p_1_4: float
    by_p_2_1: float
    by_p_2_2: float
    by_p_2_3: float
    by_p_2_4: float
    by_p_3_1: float
    by_p_3_2: float
    by_p_3_3: float
    by_p_3_4: float
    by_p_4_1: float
    by_p_4_2: float
    by_p_4_3: float
    by_p_4_4: float
    by_x_1_1: float  # m2/s
    by_x_1_2: float
    by_x_1_3: float
    by_x_1_4: float
    by_x_2_1: float
    by_x_2_2: float
    by_x_2_3: float
    by_x_2_4: float
    by_x_3_1: float
    by_x_3_2: float
    by_x_3_3: float
    by_x_3_4: float
    by_x_4_1: float
    by_x_4_2: float
    by_x_4_3: float
    by_x_4_4: float


class _Nodes(NamedTuple):
    """Pressures of the nodes before all valves."""

    at_1: float
    at_2: float
    at_3: float
    at_4: float


class _Row(NamedTuple):
    """What each node sees beside its valve's inlet, and its pressure as a share of a neighbour's that is given."""

    rest_1: float  # m3/s/Pa
    rest_2: float
    rest_3: float
    rest_4: float
    from_1_to_2: float
    from_2_to_1: float
    from_1_to_4: float
    from_4_to_1: float
    from_4_to_3: float
    from_3_to_4: float


@kernel
def _given_1(p: float, row: _Row) -> _Nodes:
    """Pressures of all nodes where that of the first valve's is given, and sources are there or beyond."""
    at_4 = p * row.from_1_to_4
    return _Nodes(p, p * row.from_1_to_2, at_4 * row.from_4_to_3, at_4)


@kernel
def _given_2(p: float, row: _Row) -> _Nodes:
    at_1 = p * row.from_2_to_1
    at_4 = at_1 * row.from_1_to_4
    return _Nodes(at_1, p, at_4 * row.from_4_to_3, at_4)


@kernel
def _given_3(p: float, row: _Row) -> _Nodes:
    at_4 = p * row.from_3_to_4
    at_1 = at_4 * row.from_4_to_1
    return _Nodes(at_1, at_1 * row.from_1_to_2, p, at_4)


@kernel
def _given_4(p: float, row: _Row) -> _Nodes:
    at_1 = p * row.from_4_to_1
    return _Nodes(at_1, at_1 * row.from_1_to_2, p * row.from_4_to_3, p)


@kernel
def _both(x: _Nodes, y: _Nodes) -> _Nodes:
    return _Nodes(x.at_1 + y.at_1, x.at_2 + y.at_2, x.at_3 + y.at_3, x.at_4 + y.at_4)


@kernel
def _own_by_p(v: LinearValve, rest: float) -> float:
    """Slope of a valve's flow over its own port pressure."""
    return -v.inlet * divider(rest, v.inlet)


@kernel
def _taken(v: LinearValve, rest: float) -> float:
    """Fall of a node's pressure by what the spool makes its inlet take."""
    return fall(v.inlet_source, v.inlet + rest)


@kernel
def _own_by_x(v: LinearValve, rest: float) -> float:
    """Slope of a valve's flow over its own spool, but for what its other orifices do."""
    return v.inlet_source * divider(rest, v.inlet)


@kernel
def crossover_4_slopes(
    cross: CrossoverOrifice,
    d_cross: float,
    k_1: Orifices,
    k_2: Orifices,
    k_3: Orifices,
    k_4: Orifices,
    d_1: Orifices,
    d_2: Orifices,
    d_3: Orifices,
    d_4: Orifices,
    s: Crossed4,
    gives: Pump,
    takes: Pump,
) -> CrossedSlopes4:
    """Slopes at a solution `s` of `crossover_4`.

    Parameters
    ----------
    cross : CrossoverOrifice
    d_cross : float, m2/s/Pa^0.5
        Slope of its conductance over the spool of valve 4.
    k_1, k_2, k_3, k_4 : Orifices, m3/s/Pa^0.5
    d_1, d_2, d_3, d_4 : Orifices, m2/s/Pa^0.5
        Slopes of the conductances over the spools.
    s : Crossed4
    gives, takes : Pump
    """
    g, t = s.giving, s.taking
    v_1 = linear(k_1, d_1, g.q_in_1, g.q_in_2 + g.circuit.q_bypass)
    v_2 = linear(k_2, d_2, g.q_in_2, g.circuit.q_bypass)
    # a small difference of flows does not tell whether the bypass' check valve is shut, pressures do
    arrives = t.circuit.p_pump > t.p_between_1
    through_3 = max(t.q_in_2 + t.circuit.q_bypass - s.q_cross, 0.0) if arrives else 0.0
    v_3 = linear(k_3, d_3, t.q_in_1, through_3)
    v_4 = linear(k_4, d_4, t.q_in_2, t.circuit.q_bypass)
    joins = linear(Orifices(0.0, cross.conductance, 0.0), Orifices(0.0, d_cross, 0.0), 0.0, s.q_cross)
    crosses, cross_source = joins.bypass, joins.bypass_source
    pump_1, pump_3 = pump_conductance(g.circuit, gives), pump_conductance(t.circuit, takes)
    # what nodes see beyond the orifices between them, from the ends of the row inwards
    whole_2, whole_3 = v_2.inlet + v_2.bypass, v_3.inlet + pump_3
    to_2, to_3 = in_row(v_1.bypass, whole_2), in_row(v_3.bypass, whole_3)
    side_1, side_4 = v_1.inlet + pump_1 + to_2, v_4.inlet + v_4.bypass + to_3
    to_1, to_4 = in_row(crosses, side_1), in_row(crosses, side_4)
    back_1, back_4 = v_1.inlet + pump_1 + to_4, v_4.inlet + v_4.bypass + to_1
    row = _Row(
        pump_1 + to_2 + to_4,
        v_2.bypass + in_row(v_1.bypass, back_1),
        pump_3 + in_row(v_3.bypass, back_4),
        v_4.bypass + to_1 + to_3,
        divider(v_1.bypass, whole_2),
        divider(v_1.bypass, back_1),
        divider(crosses, side_4),
        divider(crosses, side_1),
        divider(v_3.bypass, whole_3),
        divider(v_3.bypass, back_4),
    )
    # nodes over port pressures
    p_1 = _given_1(divider(v_1.inlet, row.rest_1), row)
    p_2 = _given_2(divider(v_2.inlet, row.rest_2), row)
    p_3 = _given_3(divider(v_3.inlet, row.rest_3), row)
    p_4 = _given_4(divider(v_4.inlet, row.rest_4), row)
    # nodes over spools, without what an inlet does to its own node: what bypasses and the crossover pass on leaves one node and enters another
    falls_1 = fall_before(v_1.bypass_source, v_1.bypass, back_1, whole_2)
    rises_2 = fall_before(v_1.bypass_source, v_1.bypass, whole_2, back_1)
    falls_2 = fall(v_2.bypass_source, v_2.inlet + row.rest_2)
    falls_3 = fall_before(v_3.bypass_source, v_3.bypass, whole_3, back_4)
    rises_4 = fall_before(v_3.bypass_source, v_3.bypass, back_4, whole_3)
    falls_4 = fall(v_4.bypass_source, v_4.inlet + row.rest_4)
    crossing_1 = fall_before(cross_source, crosses, side_1, side_4)
    crossing_4 = fall_before(cross_source, crosses, side_4, side_1)
    left_1, right_1 = _given_1(-falls_1, row), _given_2(rises_2, row)
    passed_1 = _Nodes(left_1.at_1, right_1.at_2, left_1.at_3, left_1.at_4)
    passed_2 = _given_2(-falls_2, row)
    left_3, right_3 = _given_3(-falls_3, row), _given_4(rises_4, row)
    passed_3 = _Nodes(right_3.at_1, right_3.at_2, left_3.at_3, right_3.at_4)
    left_4, right_4 = _given_1(-crossing_1, row), _given_4(crossing_4, row)
    crossed = _Nodes(left_4.at_1, left_4.at_2, right_4.at_3, right_4.at_4)
    passed_4 = _both(_given_4(-falls_4, row), crossed)
    taken_1, taken_2 = _given_1(-_taken(v_1, row.rest_1), row), _given_2(-_taken(v_2, row.rest_2), row)
    taken_3, taken_4 = _given_3(-_taken(v_3, row.rest_3), row), _given_4(-_taken(v_4, row.rest_4), row)
    x_1, x_2, x_3, x_4 = (
        _both(taken_1, passed_1),
        _both(taken_2, passed_2),
        _both(taken_3, passed_3),
        _both(taken_4, passed_4),
    )
    return CrossedSlopes4(
        _own_by_p(v_1, row.rest_1), v_1.inlet * p_2.at_1, v_1.inlet * p_3.at_1, v_1.inlet * p_4.at_1,
        v_2.inlet * p_1.at_2, _own_by_p(v_2, row.rest_2), v_2.inlet * p_3.at_2, v_2.inlet * p_4.at_2,
        v_3.inlet * p_1.at_3, v_3.inlet * p_2.at_3, _own_by_p(v_3, row.rest_3), v_3.inlet * p_4.at_3,
        v_4.inlet * p_1.at_4, v_4.inlet * p_2.at_4, v_4.inlet * p_3.at_4, _own_by_p(v_4, row.rest_4),
        _own_by_x(v_1, row.rest_1) + v_1.inlet * passed_1.at_1, v_1.inlet * x_2.at_1, v_1.inlet * x_3.at_1, v_1.inlet * x_4.at_1,
        v_2.inlet * x_1.at_2, _own_by_x(v_2, row.rest_2) + v_2.inlet * passed_2.at_2, v_2.inlet * x_3.at_2, v_2.inlet * x_4.at_2,
        v_3.inlet * x_1.at_3, v_3.inlet * x_2.at_3, _own_by_x(v_3, row.rest_3) + v_3.inlet * passed_3.at_3, v_3.inlet * x_4.at_3,
        v_4.inlet * x_1.at_4, v_4.inlet * x_2.at_4, v_4.inlet * x_3.at_4, _own_by_x(v_4, row.rest_4) + v_4.inlet * passed_4.at_4,
    )  # fmt: skip


@kernel
def crossover_3_slopes(
    cross: CrossoverOrifice,
    d_cross: float,
    k_1: Orifices,
    k_2: Orifices,
    k_3: Orifices,
    d_1: Orifices,
    d_2: Orifices,
    d_3: Orifices,
    s: Crossed3,
    gives: Pump,
    takes: Pump,
) -> CrossedSlopes3:
    """Slopes at a solution `s` of `crossover_3`; see `crossover_4_slopes`."""
    tank, still = Orifices(0.0, TO_TANK, 0.0), Orifices(0.0, 0.0, 0.0)
    giving = Series2(s.giving.q_in_1, 0.0, gives.p_return, s.giving.circuit, s.giving.status)
    whole = Crossed4(giving, s.taking, s.q_cross)
    a = crossover_4_slopes(cross, d_cross, k_1, tank, k_2, k_3, d_1, still, d_2, d_3, whole, gives, takes)
    return CrossedSlopes3(
        a.by_p_1_1, a.by_p_1_3, a.by_p_1_4, a.by_p_3_1, a.by_p_3_3, a.by_p_3_4, a.by_p_4_1, a.by_p_4_3, a.by_p_4_4,
        a.by_x_1_1, a.by_x_1_3, a.by_x_1_4, a.by_x_3_1, a.by_x_3_3, a.by_x_3_4, a.by_x_4_1, a.by_x_4_3, a.by_x_4_4,
    )  # fmt: skip
