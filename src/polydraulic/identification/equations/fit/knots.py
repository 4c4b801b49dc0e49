"""Knots where rows ask for them: one more at a time, kept while blocks of time held out get better."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import (
    LEADS,
    CircuitModel,
    CircuitRows,
    Prior,
    fit_circuit,
    normal,
    numbers_to_values,
    weighted,
)
from polydraulic.identification.equations.fit.held_out import huber, surely_better
from polydraulic.identification.equations.fit.valve_curves import with_knot
from polydraulic.identification.equations.fit.weighing import HUBER

_PATIENCE = 2  # knots that may save less before growth ends
_CLOSEST = 2.5e-5  # m, between two knots
_STEPS = 15
_SHARES = (1.0, 1.6, 0.6)  # of curves to begin with
_FEW, _FIRST_STEPS = 1500, 10  # rows and steps with which these are tried


class Growth(NamedTuple):
    """A model, and half its mean weighted squares on the rows held out, by numbers of knots."""

    model: CircuitModel
    held_out: float
    path: list[tuple[int, float]]


def grow(
    model: CircuitModel,
    learn: CircuitRows,
    hold: CircuitRows,
    prior: Prior,
    most: int,
    tell: Callable[[int], object] = lambda knots: None,
) -> Growth:
    """Add knots to the curves of a circuit.

    Parameters
    ----------
    model : CircuitModel
    learn, hold : CircuitRows
    prior : Prior
    most : int
        Knots of a valve.
    tell : callable
        Told the number of knots.
    """
    # with too few knots, those there are would leave where a valve opens for where a straight line is worst, and not come back; nor would
    # clocks of sensors that answer for curves which are far off
    sure = prior._replace(pump={name: width for name, width in prior.pump.items() if name not in LEADS})
    model, _ = fit_circuit(_begun(model, learn, sure), learn, sure, 25, knots_move=False)
    model, _ = fit_circuit(model, learn, prior, _STEPS, knots_move=False)
    best, off, idle = model, left_over(model, hold), 0
    shown = max(int(np.count_nonzero(off)), 1)
    least = float(huber(off).sum()) / shown
    path = [(sum(len(v.knots) for v in model.valves), least)]
    while idle < _PATIENCE:
        wider = widened(model, learn, prior, most)
        if wider is None:
            break
        model, _ = fit_circuit(wider, learn, prior, _STEPS)
        trial = left_over(model, hold)
        found = float(huber(trial).sum()) / shown
        count = sum(len(v.knots) for v in model.valves)
        path.append((count, found))
        tell(count)
        if surely_better(off, trial, hold.block):
            best, off, least, idle = model, trial, found, 0
        else:
            idle += 1
    return Growth(best, least, path)


def _begun(model: CircuitModel, rows: CircuitRows, prior: Prior) -> CircuitModel:
    """The model, or one whose curves are all narrower or wider, whichever a few rows let come closer.

    No sensor has the pump's pressure: where all orifices are too narrow together, flows divide nearly as they do, and steps end there.
    """
    few = rows.some(np.arange(0, len(rows.travel), max(len(rows.travel) // _FEW, 1)))
    found = []
    for share in _SHARES:
        valves = tuple(v._replace(inlet=share * v.inlet, bypass=share * v.bypass) for v in model.valves)
        found.append(fit_circuit(model._replace(valves=valves), few, prior, _FIRST_STEPS, knots_move=False))
    return min(found, key=lambda one: one[1])[0]


def left_over(model: CircuitModel, rows: CircuitRows) -> np.ndarray:
    """What is left of flows in standard deviations, zero where they do not count, (n_window, n)."""
    return np.column_stack([off for off, _ in weighted(model, rows, [])])


def widened(model: CircuitModel, rows: CircuitRows, prior: Prior, most: int) -> CircuitModel | None:
    """The model with the one more knot that promises most, None where there is no room.

    What a knot promises follows from the slopes over its height, less what the other numbers can do of the same.
    """
    now = normal(model, rows, prior)
    to_values = numbers_to_values(model, len(prior.pump))
    gains: list[tuple[float, int, float]] = []
    base = to_values.T @ now.curvature @ to_values
    scale = 1.0 / np.sqrt(np.maximum(np.diag(base), 1e-300))
    for i, v in enumerate(model.valves):
        if len(v.knots) >= most:
            continue
        for left, right in zip(v.knots, v.knots[1:], strict=False):
            for share in (0.3, 0.5, 0.7):
                at = left + share * (right - left)
                if min(at - left, right - at) >= _CLOSEST:
                    gains.append((0.0, i, float(at)))
    if not gains:
        return None
    places = [(i, at) for _, i, at in gains]
    g, cross, own = _candidates(model, rows, prior, places)
    solved = np.linalg.solve(
        base * scale[:, None] * scale[None, :] + 1e-8 * np.eye(len(base)), scale[:, None] * (to_values.T @ cross)
    )
    rest = own - np.sum((to_values.T @ cross) * (scale[:, None] * solved), axis=0)
    promise = np.where(rest > 1e-6 * own, g * g / np.maximum(rest, 1e-300), 0.0)
    summed = promise[: len(places)] + promise[len(places) :]
    i, at = places[int(np.argmax(summed))]
    valves = list(model.valves)
    valves[i] = with_knot(valves[i], at)
    return model._replace(valves=tuple(valves))


def _candidates(
    model: CircuitModel, rows: CircuitRows, prior: Prior, places: list[tuple[int, float]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slope, curvature with the other numbers, and own curvature over the height of each possible knot: of inlets, then of bypasses."""
    count = 3 * sum(len(v.knots) for v in model.valves) + len(prior.pump)
    g, cross, own = np.zeros(2 * len(places)), np.zeros((count, 2 * len(places))), np.zeros(2 * len(places))
    starts = np.cumsum([0, *(3 * len(v.knots) for v in model.valves)])
    for begin in range(0, len(rows.travel), 8192):
        part = rows.some(np.arange(begin, min(begin + 8192, len(rows.travel))))
        tents = []
        for i, at in places:
            knots = model.valves[i].knots
            k = int(np.searchsorted(knots, at))
            tents.append(np.interp(part.travel[:, :, i].mean(axis=1), [knots[k - 1], at, knots[k]], [0.0, 1.0, 0.0]))
        tent = np.column_stack(tents)
        for off, slopes in weighted(model, part, list(prior.pump)):
            robust = np.minimum(1.0, HUBER / np.maximum(np.abs(off), 1e-300))
            columns = []
            for k in range(2):
                for c, (i, _) in enumerate(places):
                    m = len(model.valves[i].knots)
                    block = slopes[:, starts[i] + k * m : starts[i] + (k + 1) * m]
                    columns.append(tent[:, c] * block.sum(axis=1))
            new = np.column_stack(columns)
            g += new.T @ (robust * off)
            cross += (slopes * robust[:, None]).T @ new
            own += np.sum(new * new * robust[:, None], axis=0)
    return g, cross, own
