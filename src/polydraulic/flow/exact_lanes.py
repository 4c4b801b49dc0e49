"""Exact flow for a block of machines side by side: the kernels of `exact` in loops over lanes.

Machines whose pumps meet the torque limit are few as a rule; they are packed together, solved, and put back.
"""

from typing import Any

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import exp
from polydraulic.flow.lanes import (
    BOOM,
    BYPASS,
    FLOW_SCRATCH,
    INLET,
    LANES,
    OUTLET,
    P_BETWEEN,
    P_IN,
    Q_IN,
    SERIES,
    SPOOL,
    at,
    get,
    get_links,
    get_orifices,
    put,
    put_links,
)
from polydraulic.machine.pump import (
    LIMIT_PASSES,
    Bracket,
    Circuit,
    limit_series,
    limit_single,
    limits,
    series_at,
    single_at,
    unlimited,
)
from polydraulic.machine.state import Links
from polydraulic.machine.valve import Orifices, orifices

_GROUP = 16
# scratch: the number of a packed machine's lane, inlet, bypass and pressure of one or two valves, the bracket of the search, results
_LANE, _PACKED, _BRACKET, _RESULT = FLOW_SCRATCH, FLOW_SCRATCH + 1, FLOW_SCRATCH + 7, FLOW_SCRATCH + 12


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
def _put_bracket(rows: np.ndarray, lane: int, x: Bracket) -> None:
    put(rows, _BRACKET, lane, x.y)
    put(rows, _BRACKET + 1, lane, x.low)
    put(rows, _BRACKET + 2, lane, x.high)
    put(rows, _BRACKET + 3, lane, x.off_low)
    put(rows, _BRACKET + 4, lane, x.off_high)


@kernel
def _get_bracket(rows: np.ndarray, lane: int, low_unknown: bool) -> Bracket:
    return Bracket(
        get(rows, _BRACKET, lane),
        get(rows, _BRACKET + 1, lane),
        get(rows, _BRACKET + 2, lane),
        get(rows, _BRACKET + 3, lane),
        get(rows, _BRACKET + 4, lane),
        low_unknown,
    )


@kernel
def _pack(rows: np.ndarray, place: int, lane: int, link: int, number: int) -> None:
    put(rows, _PACKED + 3 * number, place, get(rows, INLET + link, lane))
    put(rows, _PACKED + 3 * number + 1, place, get(rows, BYPASS + link, lane))
    put(rows, _PACKED + 3 * number + 2, place, get(rows, P_IN + link, lane))


@kernel
def _packed_orifices(rows: np.ndarray, number: int, lane: int) -> Orifices:
    return Orifices(get(rows, _PACKED + 3 * number, lane), get(rows, _PACKED + 3 * number + 1, lane), 0.0)


@kernel
def _fill_up(rows: np.ndarray, count: int) -> int:
    """Repeat the first packed machine until whole groups are full; how many groups there are."""
    n_group = (count + _GROUP - 1) // _GROUP
    for place in range(count, n_group * _GROUP):
        for row in range(_LANE, _RESULT):
            put(rows, row, place, get(rows, row, 0))
    return n_group


@kernel
def _limit_boom(model: Any, own: Any, rows: np.ndarray) -> None:
    count = 0
    for lane in range(LANES):
        pump = at(own, model, lane).boom_pump
        if limits(get(rows, BOOM + 3, lane), pump):
            put(rows, _LANE, count, float(lane))
            _pack(rows, count, lane, 1, 0)
            _put_bracket(rows, count, unlimited(pump))
            count += 1
    n_group = _fill_up(rows, count)
    for group in range(n_group):
        part = rows[group * _GROUP :]
        for i in range(LIMIT_PASSES):
            for place in range(_GROUP):
                pump = at(own, model, int(get(part, _LANE, place))).boom_pump
                k, p = _packed_orifices(part, 0, place), get(part, _PACKED + 2, place)
                _put_bracket(part, place, limit_single(_get_bracket(part, place, i == 0), k, p, pump))
        for place in range(_GROUP):
            pump = at(own, model, int(get(part, _LANE, place))).boom_pump
            k, p = _packed_orifices(part, 0, place), get(part, _PACKED + 2, place)
            found = single_at(pump.flow * exp(get(part, _BRACKET, place)), k, p, pump)
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
            put(rows, _LANE, count, float(lane))
            _pack(rows, count, lane, 0, 0)
            _pack(rows, count, lane, 2, 1)
            _put_bracket(rows, count, unlimited(pump))
            count += 1
    n_group = _fill_up(rows, count)
    for group in range(n_group):
        part = rows[group * _GROUP :]
        for i in range(LIMIT_PASSES):
            for place in range(_GROUP):
                pump = at(own, model, int(get(part, _LANE, place))).series_pump
                first, second = _packed_orifices(part, 0, place), _packed_orifices(part, 1, place)
                p_first, p_second = get(part, _PACKED + 2, place), get(part, _PACKED + 5, place)
                x = _get_bracket(part, place, i == 0)
                _put_bracket(part, place, limit_series(x, first, second, p_first, p_second, pump))
        for place in range(_GROUP):
            pump = at(own, model, int(get(part, _LANE, place))).series_pump
            first, second = _packed_orifices(part, 0, place), _packed_orifices(part, 1, place)
            p_first, p_second = get(part, _PACKED + 2, place), get(part, _PACKED + 5, place)
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
