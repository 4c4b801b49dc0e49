"""Knots where rows ask for them: one more at a time, kept while blocks of time held out get better."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import (
    HUBER,
    CircuitModel,
    CircuitRows,
    Prior,
    fit_circuit,
    normal,
    numbers_to_values,
    weighted,
)
from polydraulic.identification.equations.fit.valve_curves import with_knot

BETTER = 5e-4  # share of the squares of the rows held out that a knot must save
SURE = 2.0  # standard errors, over blocks, by which it must
_PATIENCE = 2  # knots that may save less before growth ends
_CLOSEST = 2.5e-5  # m, between two knots
_STEPS = 15


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
    # with too few knots, those there are would leave where a valve opens for where a straight line is worst, and not come back
    model, _ = fit_circuit(model, learn, prior, 25, knots_move=False)
    best, by_block, idle = model, block_losses(model, hold), 0
    least = float(by_block.mean())
    path = [(sum(len(v.knots) for v in model.valves), least)]
    while idle < _PATIENCE:
        wider = widened(model, learn, prior, most)
        if wider is None:
            break
        model, _ = fit_circuit(wider, learn, prior, _STEPS)
        of_blocks = block_losses(model, hold)
        found, saved = float(of_blocks.mean()), by_block - of_blocks
        count = sum(len(v.knots) for v in model.valves)
        path.append((count, found))
        tell(count)
        if saved.mean() > max(BETTER * least, SURE * saved.std() / np.sqrt(max(len(saved) - 1, 1))):
            best, by_block, least, idle = model, of_blocks, found, 0
        else:
            idle += 1
    return Growth(best, least, path)


def block_losses(model: CircuitModel, rows: CircuitRows) -> np.ndarray:
    """Half the mean weighted squares of each block of time, those far off counting less, (n_block,)."""
    _, block = np.unique(rows.block, return_inverse=True)
    total, count = np.zeros(block.max(initial=-1) + 1), np.zeros(block.max(initial=-1) + 1)
    for off, _ in weighted(model, rows, []):
        size = np.abs(off)
        np.add.at(total, block, np.where(size <= HUBER, 0.5 * off * off, HUBER * (size - 0.5 * HUBER)))
        np.add.at(count, block, off != 0.0)
    return total[count > 0] / count[count > 0]


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
