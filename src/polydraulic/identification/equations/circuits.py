"""A circuit as a whole: what sensors say of it, its curves with knots where they are asked for, and the outlets of its valves."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.identification.equations.fit.beyond import beyond, shutting
from polydraulic.identification.equations.fit.circuit_fit import (
    LEADS,
    CircuitModel,
    CircuitRows,
    Prior,
    conductances,
    fit_circuit,
    mean_flows,
    measured_flows,
    pump_with,
)
from polydraulic.identification.equations.fit.circuit_slopes_at import circuit_slopes_at
from polydraulic.identification.equations.fit.knots import grow
from polydraulic.identification.equations.fit.outlet_fit import OutletPrior, bent_knots, fit_outlet, outlet_rows
from polydraulic.identification.equations.fit.relief import seen_relief
from polydraulic.identification.equations.fit.uncertainty import CircuitErrors, circuit_errors
from polydraulic.identification.equations.fit.valve_curves import Curves, placed_among
from polydraulic.identification.equations.observations import WINDOW, Balance, balance, blocks_of_time, windows
from polydraulic.identification.equations.sensors import Signals
from polydraulic.machine.pump import limited_pump
from polydraulic.machine.valve import spool_edges
from polydraulic.parameters.layout.parts import MOST_KNOTS, SupplyCircuit, ValveCurves
from polydraulic.parameters.layout.schema import LayoutMachine

LEARN_ROWS, HOLD_ROWS, ALL_ROWS = 16000, 8000, 40000
LAST_ROWS = 20  # beyond which travel counts as never seen
_FEWEST, _LEAST_HELD = 500, 20
_SPREAD = 1.0  # of a curve, as a share
_PUMP_ROWS = 200
_STEPS = 6
_GROWING, _FITTED = 0.6, 0.8  # shares of the time: until knots are placed, and until outlets follow
_LEAD = 0.02  # s, by which clocks of sensors may be apart
_BELOW = 0.97  # of the relief setting: above, a flow falls from all to nothing within what a sensor can tell


class ValveFound(NamedTuple):
    """What was found of a valve.

    Attributes
    ----------
    curves : ValveCurves
    errors : dict
        By curve, standard errors at the knots.
    seen : (float, float), m
        Least travel at which it is open, and largest, that the log has.
    pressure : (float, float), Pa
        At the pressurised port while it is open.
    q_in_left, q_out_left : float, m3/s
        Root mean square of what is left of flows on blocks held out; nan where there is none.
    rows : int
    outlets : tuple of bool
        Whether the outlets for positive and negative spools were fitted.
    """

    curves: ValveCurves
    errors: dict[str, np.ndarray]
    seen: tuple[float, float]
    pressure: tuple[float, float]
    q_in_left: float
    q_out_left: float
    rows: int
    outlets: tuple[bool, bool]


class CircuitFound(NamedTuple):
    """What was found of a circuit.

    Attributes
    ----------
    valves : dict from function to ValveFound
    pump : dict from key to (value, standard error), SI
    path : list of (number of knots, error held out)
        Of growth.
    rows : int
    trades : list of str
        Which numbers trade against each other, in words.
    """

    valves: dict[str, ValveFound]
    pump: dict[str, tuple[float, float]]
    path: list[tuple[int, float]]
    rows: int
    trades: list[str]


PUMP_KEYS = {"flow": "flow", "relief": "relief", "limit_start": "torque_limit_start"}


def balances(
    machine: LayoutMachine, names: tuple[str, ...], signals: dict[str, Signals], segment: np.ndarray, raster: float
) -> dict[str, Balance]:
    """Flows of functions, all in rows where all are measured, all in windows elsewhere."""
    measured = all("q_in" in signals[name].values for name in names)
    long = 1 if measured else max(3, round(WINDOW / raster) + 1)
    rows = windows(segment, long)
    return {n: balance(machine.function(n), machine.tank.floor, signals[n], rows, raster, measured) for n in names}


def circuit_rows(
    names: tuple[str, ...],
    signals: dict[str, Signals],
    of: dict[str, Balance],
    time: np.ndarray,
) -> CircuitRows:
    """What a circuit is fitted to."""
    rows = of[names[0]].rows
    travel, p_in, p_rate = (np.empty((*rows.shape, len(names))) for _ in range(3))
    for k, name in enumerate(names):
        spool, rates = signals[name].values["spool"], signals[name].rates
        p_a, p_b = (signals[name].values[port] for port in ("p_a", "p_b"))
        travel[:, :, k] = np.abs(spool)[rows]
        p_in[:, :, k] = np.where(spool > 0.0, p_a, p_b)[rows]
        p_rate[:, :, k] = np.where(spool > 0.0, rates["p_a"], rates["p_b"])[rows]
    one_side = np.column_stack([of[name].known_in for name in names])
    noise = {what: np.array([signals[name].noise[what] for name in names]) for what in ("spool", "p_a")}
    return CircuitRows(
        travel,
        p_in,
        p_rate,
        np.column_stack([of[name].q_in for name in names]),
        np.stack([of[name].rates_in for name in names], axis=1),
        one_side,
        blocks_of_time(time)[rows[:, 0]],
        noise["spool"],
        noise["p_a"],
        np.array([of[name].noise_in for name in names]),
        np.array([signals[name].scale for name in names]),
    )


def identify_circuit(
    machine: LayoutMachine,
    circuit: SupplyCircuit,
    signals: dict[str, Signals],
    time: np.ndarray,
    segment: np.ndarray,
    raster: float,
    free_pump: dict[str, float],
    tell: Callable[[float, str], object],
) -> CircuitFound | str:
    """Curves of all valves of a circuit, and numbers of its pump; or why there are none.

    Parameters
    ----------
    machine : LayoutMachine
        As far as it is known.
    circuit : SupplyCircuit
    signals : dict from function to Signals
        In rows in which spools and pressures of all functions have a value.
    time, segment : (n_row,) array
    raster : float, s
    free_pump : dict
        Numbers of the pump that are free, with their spreads in SI.
    tell : callable
        Told about which share is done, and what is being done.
    """
    names = circuit.functions
    of = balances(machine, names, signals, segment, raster)
    rows = circuit_rows(names, signals, of, time)
    valves = [machine.function(name).valve for name in names]
    last = [float(np.sort(rows.travel[:, :, k].max(axis=1))[-LAST_ROWS]) for k in range(len(names))]
    last = [min(x, v.knots[-1]) for x, v in zip(last, valves, strict=True)]
    rows = rows._replace(travel=np.minimum(rows.travel, np.array(last)))
    before = CircuitModel(
        tuple(cut_curves(v, x) for v, x in zip(valves, last, strict=True)),
        limited_pump(circuit.pump.flow, circuit.pump.relief, machine.tank.return_pressure, circuit.pump),
    )
    opens = np.array([spool_edges(v)[0] for v in valves])
    awake = np.flatnonzero((rows.travel.max(axis=1) > 0.8 * opens).any(axis=1) & rows.known.any(axis=1))
    rng = np.random.default_rng(0)

    def drawn(keep: np.ndarray, most: int) -> CircuitRows:
        chosen = keep if len(keep) <= most else np.sort(rng.permutation(keep)[:most])
        return rows.some(chosen)

    held = rows.block[awake] % 5 == 4
    relief = seen_relief(before, rows.some(awake), opens, free_pump["relief"]) if "relief" in free_pump else None
    if relief is not None:
        before = before._replace(pump=pump_with(before.pump, "relief", relief[0]))
    calm = rows.p_in.max(axis=(1, 2), where=rows.travel > opens, initial=0.0) < _BELOW * before.pump.relief
    rows = rows._replace(known=rows.known & calm[:, None])
    known = np.array([np.count_nonzero(rows.known[awake[part]]) for part in (held, ~held)])
    if known.min() < _LEAST_HELD:
        return f"only {known[1]} rows or windows say something of it, and {known[0]} of the blocks held out; {_LEAST_HELD} at least"
    leads = dict.fromkeys(LEADS if rows.q_rates.any() else LEADS[:1], _LEAD)
    prior = Prior(before, _SPREAD, {key: width for key, width in free_pump.items() if key == "flow"} | leads)
    most = MOST_KNOTS - _further_knots(valves, last)
    fewest = sum(len(v.knots) for v in before.valves) - 2
    tell(0.0, "first knots")
    grown = grow(
        before,
        drawn(awake[~held], LEARN_ROWS),
        drawn(awake[held], HOLD_ROWS),
        prior,
        most,
        lambda n: tell(_GROWING * (1.0 - 0.7 ** (n - fewest)), f"{n} knots"),
    )
    without, hold = grown.model, rows.some(awake[held])
    left = mean_flows(without, hold) - measured_flows(without, hold)
    shown = hold.known & (hold.travel.max(axis=1) > opens)
    q_in_left = [
        float(np.sqrt(np.mean(left[shown[:, k], k] ** 2))) if shown[:, k].any() else float("nan")
        for k in range(len(names))
    ]
    tell(_GROWING, "all rows")
    every = drawn(awake, ALL_ROWS)
    prior = prior._replace(
        pump={key: free_pump[key] for key in shown_by(grown.model, every, opens) if key in free_pump} | leads
    )
    model, _ = fit_circuit(grown.model, every, prior, _STEPS)
    spread = circuit_errors(model, every, prior)
    found = {}
    for k, name in enumerate(names):
        tell(_FITTED + (1.0 - _FITTED) * k / len(names), f"{name}: outlets")
        s, b = signals[name], of[name]
        if b.rows.shape[1] > 1:
            s, b = with_clocks(s, b, model)
        found[name] = _valve(
            machine, name, model.valves[k], spread.valves[k], s, b, rows, k, last[k], q_in_left[k], most
        )  # fmt: skip
    pump = {key: (float(getattr(model.pump, key)), error) for key, error in spread.pump.items() if key not in LEADS}
    if relief is not None:
        pump["relief"] = relief
    return CircuitFound(found, pump, grown.path, len(awake), traded(names, model, spread))


def with_clocks(s: Signals, b: Balance, model: CircuitModel) -> tuple[Signals, Balance]:
    """Pressures, and flows balanced from these and positions, as if all clocks were that of the spools."""
    leads = (model.lead, model.lead_position)
    moved = {port: s.values[port] + model.lead * s.rates[port] for port in ("p_a", "p_b")}
    return (
        s._replace(values=s.values | moved),
        b._replace(q_in=b.q_in + b.rates_in @ leads, q_out=b.q_out + b.rates_out @ leads),
    )


def _further_knots(valves: list[ValveCurves], last: list[float]) -> int:
    """Knots at most that a valve has beyond the travel of the log, and one at which its bypass shuts."""
    return max(sum(k > x + 1e-6 for k in v.knots) + 1 for v, x in zip(valves, last, strict=True))


def shown_by(model: CircuitModel, rows: CircuitRows, opens: np.ndarray) -> list[str]:
    """Numbers of the pump that enough rows show: its flow, and its torque limit above where that starts."""
    n = len(model.valves)
    travel, p_in = rows.travel.reshape(-1, n), rows.p_in.reshape(-1, n)
    places = [placed_among(v.knots, travel[:, i]) for i, v in enumerate(model.valves)]
    at = circuit_slopes_at(*conductances(model, places), p_in, model.pump)
    moved = (travel > opens).any(axis=1)
    limited = moved & (at.p_pump > 1.02 * model.pump.limit_start) & (model.pump.log_least < 0.0)
    found = [("flow", moved), ("limit_start", limited)]
    return [name for name, seen in found if np.count_nonzero(seen) >= _PUMP_ROWS]


def traded(names: tuple[str, ...], model: CircuitModel, errors: CircuitErrors) -> list[str]:
    """Which numbers trade against each other, in words."""
    places = [
        (name, key, knot)
        for name, v in zip(names, model.valves, strict=True)
        for key in ("inlet", "bypass", "knots")
        for knot in v.knots
    ]
    words = [f"functions.{name}.valve.{key} at {amount(float(knot), 'm')}" for name, key, knot in places] + [
        f"pump.{key}" for key in errors.pump
    ]
    return [
        f"{words[i]} trades against {words[j]}: their errors are correlated by {r:.2f}, the log knows their combination better than each"
        for i, j, r in errors.pairs
    ]


def cut_curves(valve: ValveCurves, last: float) -> Curves:
    """Inlet and bypass as far as the log has travel, as a start: never falling, and never rising."""
    knots = np.array([k for k in valve.knots if k < last - 1e-6] + [last])
    inlet, bypass = (np.interp(knots, valve.knots, c) for c in (valve.inlet, valve.bypass))
    inlet[0] = 0.0
    return Curves(knots, np.maximum.accumulate(inlet), np.maximum.accumulate(bypass[::-1])[::-1])


def _rising_from_zero(valve: ValveCurves, key: str, knots: np.ndarray) -> np.ndarray:
    found = np.maximum.accumulate(np.interp(knots, valve.knots, getattr(valve, key)))
    found[0] = 0.0
    return found


def _valve(
    machine: LayoutMachine, name: str, curves: Curves, errors: dict[str, np.ndarray], s: Signals, b: Balance, rows: CircuitRows, k: int, last: float,
    q_in_left: float, most: int,
) -> ValveFound:  # fmt: skip
    old = machine.function(name).valve
    block = np.zeros(int(b.rows.max()) + 1, dtype=np.int64)
    block[b.rows[:, 0]] = rows.block
    opens = spool_edges(old)[0]
    # windows blur by how much clocks are apart: outlets have those of the inlets
    measured = b.rows.shape[1] == 1
    sides = [outlet_rows(s, b, block, forward, opens, rates=measured) for forward in (True, False)]
    sides = [side._replace(travel=np.minimum(side.travel, last)) for side in sides]
    fitted = [len(side.q_out) >= _FEWEST // (1 if measured else 10) for side in sides]
    before = {key: _rising_from_zero(old, key, curves.knots) for key in ("outlet_positive", "outlet_negative")}
    priors = [OutletPrior(machine.tank.return_pressure, curves.knots, v, _SPREAD) for v in before.values()]
    knots, places = curves.knots, {float(x): float(e) for x, e in zip(curves.knots, errors["knots"], strict=True)}
    own: list[set[float]] = []
    for side, prior, use in zip(sides, priors, fitted, strict=True):
        bent = bent_knots(side, knots, prior, most) if use else knots
        own.append(set(bent.tolist()) - set(knots.tolist()))
        knots = bent
    values = {key: np.interp(knots, curves.knots, getattr(curves, key)) for key in ("inlet", "bypass")}
    spread = {key: np.interp(knots, curves.knots, error) for key, error in errors.items()}
    left = []
    for side, key, prior, use, moved in zip(sides, before, priors, fitted, own, strict=True):
        if not use:
            values[key], spread[key] = np.interp(knots, curves.knots, before[key]), np.full(len(knots), np.nan)
            continue
        # a knot of another curve is no bend of this one
        sure = np.array([np.inf if x in moved else places.get(x, 0.0) for x in knots.tolist()])
        found = fit_outlet(side, knots, prior, sure)
        values[key], spread[key] = found.values, found.errors
        left.append(found.held_out)
    more = np.array([x for x in old.knots if x > knots[-1] + 1e-6])
    old_knots = np.array(old.knots)
    shut = shutting(knots, values["bypass"], old_knots, np.array(old.bypass), opens)
    more = more if shut is None else np.sort(np.append(more, shut[0]))
    far_on = {key: beyond(knots, v, old_knots, np.array(getattr(old, key)), more) for key, v in values.items()}
    if shut is not None:
        far_on["bypass"] = shut[1]
    whole = {key: [*v.tolist(), *far_on[key].tolist()] for key, v in values.items()}
    whole |= {key: np.maximum.accumulate(whole[key]).tolist() for key in whole if key != "bypass"}
    open_rows = rows.travel[:, :, k].max(axis=1) > opens
    pressures = rows.p_in[open_rows, :, k]
    far = {key: np.concatenate([v, np.full(len(more), np.nan)]) for key, v in spread.items()}
    return ValveFound(
        ValveCurves(
            (*knots.tolist(), *more.tolist()),
            *(tuple(whole[key]) for key in ("inlet", "bypass", "outlet_positive", "outlet_negative")),
        ),
        far,
        (opens, last),
        (float(pressures.min()), float(pressures.max())) if pressures.size else (0.0, 0.0),
        q_in_left,
        float(np.sqrt(np.mean(np.square(left)))) if left else float("nan"),
        int(open_rows.sum()),
        (fitted[0], fitted[1]),
    )
