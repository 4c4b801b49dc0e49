"""Exact flow for a block of machines side by side: the kernels of `exact` in loops over lanes.

Machines whose pumps meet the torque limit are few as a rule; they are packed together, solved, and put back.
"""

from typing import Any

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import exp
from polydraulic.flow.lanes import (
    BYPASS,
    FLOW_SCRATCH,
    GROUP,
    INLET,
    LANES,
    OUTLET,
    P_IN,
    at,
    get,
    get_links,
    get_orifices,
    put,
    put_links,
)
from polydraulic.flow.record import BOOM, P_BETWEEN, Q_IN, SERIES, SPOOL
from polydraulic.machine.pump import (
    LIMIT_PASSES,
    Bracket,
    Circuit,
    Pump,
    limit_series,
    limit_single,
    limits,
    series_at,
    single_at,
    unlimited,
)
from polydraulic.machine.state import Links
from polydraulic.machine.valve import Orifices, orifices

# scratch of packed machines: number of the lane, inlet, bypass and pressure of one or two valves, pump, bracket, results
_LANE, _FIRST, _SECOND = FLOW_SCRATCH, FLOW_SCRATCH + 1, FLOW_SCRATCH + 4
_PUMP, _BRACKET, _RESULT = FLOW_SCRATCH + 7, FLOW_SCRATCH + 13, FLOW_SCRATCH + 18


@kernel
def _put_circuit(rows: np.ndarray, row: int, lane: int, circuit: Circuit) -> None:
    put(rows, row, lane, circuit.q_pump)
    put(rows, row + 1, lane, circuit.q_bypass)
    put(rows, row + 2, lane, circuit.q_relief)
    put(rows, row + 3, lane, circuit.p_pump)


@kernel
def _valves(model: Any, own: Any, rows: np.ndarray) -> None:
    for lane in range(LANES):
        valves = at(own, model, lane).valves
        spool = get_links(rows, SPOOL, lane)
        swing = orifices(spool.swing, valves.swing)
        boom = orifices(spool.boom, valves.boom)
        stick = orifices(spool.stick, valves.stick)
        put_links(rows, INLET, lane, Links(swing.inlet, boom.inlet, stick.inlet))
        put_links(rows, BYPASS, lane, Links(swing.bypass, boom.bypass, stick.bypass))
        put_links(rows, OUTLET, lane, Links(swing.outlet, boom.outlet, stick.outlet))


@kernel
def _boom(model: Any, own: Any, rows: np.ndarray, whole: bool) -> None:
    for lane in range(LANES):
        pump = at(own, model, lane).boom_pump
        found = single_at(pump.flow, get_orifices(rows, 1, lane), get(rows, P_IN + 1, lane), pump)
        put(rows, Q_IN + 1, lane, found.q_in)
        if whole:
            _put_circuit(rows, BOOM, lane, found.circuit)


@kernel
def _series(model: Any, own: Any, rows: np.ndarray, whole: bool) -> None:
    for lane in range(LANES):
        pump = at(own, model, lane).series_pump
        swing, stick = get_orifices(rows, 0, lane), get_orifices(rows, 2, lane)
        found = series_at(pump.flow, swing, stick, get(rows, P_IN, lane), get(rows, P_IN + 2, lane), pump)
        put(rows, Q_IN, lane, found.q_first)
        put(rows, Q_IN + 2, lane, found.q_second)
        if whole:
            put(rows, P_BETWEEN, lane, found.p_between)
            _put_circuit(rows, SERIES, lane, found.circuit)


@kernel
def _put_pump(rows: np.ndarray, place: int, pump: Pump) -> None:
    put(rows, _PUMP, place, pump.flow)
    put(rows, _PUMP + 1, place, pump.relief)
    put(rows, _PUMP + 2, place, pump.p_return)
    put(rows, _PUMP + 3, place, pump.limit_start)
    put(rows, _PUMP + 4, place, pump.limit_exponent)
    put(rows, _PUMP + 5, place, pump.log_least)


@kernel
def _get_pump(rows: np.ndarray, place: int) -> Pump:
    return Pump(
        get(rows, _PUMP, place),
        get(rows, _PUMP + 1, place),
        get(rows, _PUMP + 2, place),
        get(rows, _PUMP + 3, place),
        get(rows, _PUMP + 4, place),
        get(rows, _PUMP + 5, place),
    )


@kernel
def _put_bracket(rows: np.ndarray, place: int, x: Bracket) -> None:
    put(rows, _BRACKET, place, x.y)
    put(rows, _BRACKET + 1, place, x.low)
    put(rows, _BRACKET + 2, place, x.high)
    put(rows, _BRACKET + 3, place, x.off_low)
    put(rows, _BRACKET + 4, place, x.off_high)


@kernel
def _get_bracket(rows: np.ndarray, place: int, low_unknown: bool) -> Bracket:
    return Bracket(
        get(rows, _BRACKET, place),
        get(rows, _BRACKET + 1, place),
        get(rows, _BRACKET + 2, place),
        get(rows, _BRACKET + 3, place),
        get(rows, _BRACKET + 4, place),
        low_unknown,
    )


@kernel
def _pack(rows: np.ndarray, place: int, lane: int, link: int, first: int) -> None:
    put(rows, first, place, get(rows, INLET + link, lane))
    put(rows, first + 1, place, get(rows, BYPASS + link, lane))
    put(rows, first + 2, place, get(rows, P_IN + link, lane))


@kernel
def _packed(rows: np.ndarray, place: int, first: int) -> Orifices:
    return Orifices(get(rows, first, place), get(rows, first + 1, place), 0.0)


@kernel
def _begin(rows: np.ndarray, place: int, lane: int, pump: Pump) -> None:
    put(rows, _LANE, place, float(lane))
    _put_pump(rows, place, pump)
    _put_bracket(rows, place, unlimited(pump))


@kernel
def _fill_up(rows: np.ndarray, count: int) -> int:
    """Repeat the first packed machine until whole groups are full; how many groups there are."""
    n_group = (count + GROUP - 1) // GROUP
    for place in range(count, n_group * GROUP):
        for row in range(_LANE, _RESULT):
            put(rows, row, place, get(rows, row, 0))
    return n_group


@kernel
def _limit_boom(model: Any, own: Any, rows: np.ndarray) -> None:
    count = 0
    for lane in range(LANES):
        pump = at(own, model, lane).boom_pump
        if limits(get(rows, BOOM + 3, lane), pump):
            _begin(rows, count, lane, pump)
            _pack(rows, count, lane, 1, _FIRST)
            count += 1
    for group in range(_fill_up(rows, count)):
        part = rows[group * GROUP :]
        for i in range(LIMIT_PASSES):
            for place in range(GROUP):
                x, p = _get_bracket(part, place, i == 0), get(part, _FIRST + 2, place)
                _put_bracket(part, place, limit_single(x, _packed(part, place, _FIRST), p, _get_pump(part, place)))
        for place in range(GROUP):
            pump, p = _get_pump(part, place), get(part, _FIRST + 2, place)
            Q = pump.flow * exp(get(part, _BRACKET, place))
            found = single_at(Q, _packed(part, place, _FIRST), p, pump)
            put(part, _RESULT, place, found.q_in)
            _put_circuit(part, _RESULT + 1, place, found.circuit)
    for place in range(count):
        lane = int(get(rows, _LANE, place))
        put(rows, Q_IN + 1, lane, get(rows, _RESULT, place))
        for i in range(4):
            put(rows, BOOM + i, lane, get(rows, _RESULT + 1 + i, place))


@kernel
def _limit_series(model: Any, own: Any, rows: np.ndarray) -> None:
    count = 0
    for lane in range(LANES):
        pump = at(own, model, lane).series_pump
        if limits(get(rows, SERIES + 3, lane), pump):
            _begin(rows, count, lane, pump)
            _pack(rows, count, lane, 0, _FIRST)
            _pack(rows, count, lane, 2, _SECOND)
            count += 1
    for group in range(_fill_up(rows, count)):
        part = rows[group * GROUP :]
        for i in range(LIMIT_PASSES):
            for place in range(GROUP):
                first, second = _packed(part, place, _FIRST), _packed(part, place, _SECOND)
                p_first, p_second = get(part, _FIRST + 2, place), get(part, _SECOND + 2, place)
                x = _get_bracket(part, place, i == 0)
                _put_bracket(part, place, limit_series(x, first, second, p_first, p_second, _get_pump(part, place)))
        for place in range(GROUP):
            first, second, pump = _packed(part, place, _FIRST), _packed(part, place, _SECOND), _get_pump(part, place)
            p_first, p_second = get(part, _FIRST + 2, place), get(part, _SECOND + 2, place)
            found = series_at(pump.flow * exp(get(part, _BRACKET, place)), first, second, p_first, p_second, pump)
            put_links(part, _RESULT, place, Links(found.q_first, found.q_second, found.p_between))
            _put_circuit(part, _RESULT + 3, place, found.circuit)
    for place in range(count):
        lane = int(get(rows, _LANE, place))
        put(rows, Q_IN, lane, get(rows, _RESULT, place))
        put(rows, Q_IN + 2, lane, get(rows, _RESULT + 1, place))
        put(rows, P_BETWEEN, lane, get(rows, _RESULT + 2, place))
        for i in range(4):
            put(rows, SERIES + i, lane, get(rows, _RESULT + 3 + i, place))


@kernel
def exact_lanes(model: Any, own: Any, rows: np.ndarray, whole: bool) -> None:
    """Flows of a block of machines.

    Parameters
    ----------
    model : ExactFlow
    own : None or flat array of rows
        The models of the machines where they differ; see `lanes.at`.
    rows : flat array
        Reads the rows SPOOL and P_IN, writes Q_IN, OUTLET and, for `whole`, those of the circuits; uses the scratch rows.
    whole : bool
        Whether pump flows and pressures are wanted.
    """
    _valves(model, own, rows)
    limited = False
    for lane in range(LANES):
        m = at(own, model, lane)
        limited = limited or m.boom_pump.log_least < 0.0 or m.series_pump.log_least < 0.0
    if whole or limited:
        _boom(model, own, rows, True)
        _series(model, own, rows, True)
    else:
        _boom(model, own, rows, False)
        _series(model, own, rows, False)
    if limited:
        _limit_boom(model, own, rows)
        _limit_series(model, own, rows)
