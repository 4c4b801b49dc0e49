"""Standard errors of what was fitted to a circuit: from the slopes at the solution, and from how blocks of time pull at it.

Rows that follow each other err together, so that squares summed over rows would promise too much: the sums of whole pieces of the log say how
much the solution would move if they had been others. Pieces are short, so that there are many more of them than numbers; what their own pull on
the solution hides is added back. Bounds are left out, so that a curve that lies flat is not taken for known. A straight line between knots is no curve:
how far numbers move where there are twice as many knots is added.

What is told of a curve is its value at a travel. The place of a knot errs together with the value there, and most of both is along the curve, which is no
error of it; but where the curve bends, the one side or the other is met. A spool's travel is as wrong as its pilot's gain, all rows of it together, so
that nothing is left over of that in the flows.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import (
    CircuitModel,
    CircuitRows,
    Prior,
    fit_circuit,
    normal,
    number_of,
    numbers_to_values,
    weighted,
)
from polydraulic.identification.equations.fit.valve_curves import with_knots_between
from polydraulic.identification.equations.fit.weighing import HUBER
from polydraulic.identification.equations.numbers.estimates import unhidden

_CHUNK = 8192
_PIECES, _LEAST_ROWS = 10, 20  # pieces for each number, and rows of one at least
_STEPS = 4
_CLOSE, _SHOWN = 0.9, 6


class CircuitErrors(NamedTuple):
    """Standard errors.

    Attributes
    ----------
    valves : list of dict
        Of each valve, by ``knots``, ``inlet`` and ``bypass``, (m,) arrays in m and m3/s/Pa^0.5.
    pump : dict
        Of its free numbers, SI.
    pairs : list of (int, int, float)
        Numbers of different curves whose errors go together most, and their correlation; counted as in `Normal`.
    """

    valves: list[dict[str, np.ndarray]]
    pump: dict[str, float]
    pairs: list[tuple[int, int, float]]


def circuit_errors(model: CircuitModel, rows: CircuitRows, prior: Prior) -> CircuitErrors:
    """Standard errors at a solution.

    Parameters
    ----------
    model : CircuitModel
    rows : CircuitRows
        It was fitted to.
    prior : Prior
    """
    to_values = numbers_to_values(model, len(prior.pump))
    at = normal(model, rows, prior)
    t = to_values
    within = _within_travel(model, len(at.gradient))
    h = t.T @ (at.curvature + within) @ t
    scale = 1.0 / np.sqrt(np.maximum(np.diag(h), 1e-300))
    bread = np.linalg.pinv(h * scale[:, None] * scale, rcond=1e-12) * scale[:, None] * scale
    known = t.T @ (normal(model, rows.some(np.arange(0)), prior).curvature + within) @ t  # of what was known before
    pulls = _pulls(model, rows, list(prior.pump), _PIECES * len(h)) @ t
    meat = pulls.T @ pulls * unhidden(len(pulls), float(np.trace(bread @ (h - known))))
    data = bread @ meat @ bread
    before = bread @ known @ bread
    covariance = t @ (data + before) @ t.T
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    finer = model._replace(valves=tuple(with_knots_between(v) for v in model.valves))
    bent, _ = fit_circuit(finer, rows, prior, _STEPS, knots_move=False)
    valves: list[dict[str, np.ndarray]] = []
    place = 0
    for v, other in zip(model.valves, bent.valves, strict=True):
        m = len(v.knots)
        own = covariance[place : place + 3 * m, place : place + 3 * m]
        scale_error = v.knots * rows.noise_scale[len(valves)]
        errors = {"knots": np.hypot(sigma[place + 2 * m : place + 3 * m], scale_error)}
        for k, name in enumerate(("inlet", "bypass")):
            curve, part = getattr(v, name), slice(k * m, (k + 1) * m)
            sd = at_travel(own[part, part], own[part, 2 * m :], own[2 * m :, 2 * m :], v.knots, curve, scale_error)
            errors[name] = np.hypot(sd, np.interp(v.knots, other.knots, getattr(other, name)) - curve)
        valves.append(errors)
        place += 3 * m
    pump = {
        name: float(np.hypot(error, number_of(bent, name) - number_of(model, name)))
        for name, error in zip(prior.pump, sigma[place:].tolist(), strict=True)
    }
    return CircuitErrors(valves, pump, _pairs(model, covariance))


def _within_travel(model: CircuitModel, count: int) -> np.ndarray:
    """Information of no knot lying beyond the travel of its valve: all that there is of knots at which curves do not bend."""
    found, at = np.zeros(count), 0
    for v in model.valves:
        m = len(v.knots)
        found[at + 2 * m : at + 3 * m] = float(v.knots[-1]) ** -2
        at += 3 * m
    return np.diag(found)


def at_travel(
    of_values: np.ndarray,
    of_both: np.ndarray,
    of_places: np.ndarray,
    knots: np.ndarray,
    values: np.ndarray,
    scale_error: np.ndarray,
) -> np.ndarray:
    """Standard errors of a curve at the travels where its knots are said to be, (m,).

    Parameters
    ----------
    of_values, of_both, of_places : (m, m) array
        Covariances of values at knots, of these with places of knots, and of places.
    knots, values : (m,) array
        The curve.
    scale_error : (m,) array, m
        Of the travels themselves.
    """
    slopes = np.diff(values) / np.diff(knots)
    found = np.zeros(len(knots))
    # a knot is as often behind its place as before it
    for side in (np.append(slopes[:1], slopes), np.append(slopes, slopes[-1:])):
        of_curve = np.diag(of_values) - 2.0 * side * np.diag(of_both) + side**2 * (np.diag(of_places) + scale_error**2)
        found += 0.5 * np.maximum(of_curve, 0.0)
    return np.sqrt(found)


def _pairs(model: CircuitModel, covariance: np.ndarray) -> list[tuple[int, int, float]]:
    """Pairs of numbers of different curves with nearly the same error, the closest first."""
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    known = sigma > 1e-3 * sigma.max(initial=0.0)
    both = known[:, None] & known
    r = np.divide(covariance, sigma[:, None] * sigma, out=np.zeros_like(covariance), where=both)
    curve = np.concatenate([np.full(len(v.knots), 3 * i + k) for i, v in enumerate(model.valves) for k in range(3)])
    curve = np.concatenate([curve, np.arange(len(sigma) - len(curve)) + 3 * len(model.valves)])
    places = curve % 3 == 2
    i, j = np.nonzero(np.triu(np.abs(r) > _CLOSE, 1) & (curve[:, None] != curve) & ~(places[:, None] | places))
    order = np.argsort(-np.abs(r[i, j]))[:_SHOWN]
    return [(int(i[k]), int(j[k]), float(r[i[k], j[k]])) for k in order]


def _pulls(model: CircuitModel, rows: CircuitRows, of_pump: list[str], pieces: int) -> np.ndarray:
    """Gradient of each piece of the log, (n_piece, n_number): so many, or fewer where they would have too few rows."""
    n = len(rows.block)
    pieces = max(min(pieces, n // _LEAST_ROWS), 1)
    piece = np.arange(n) * pieces // max(n, 1)
    found = np.zeros((pieces, 3 * sum(len(v.knots) for v in model.valves) + len(of_pump)))
    for begin in range(0, n, _CHUNK):
        own = np.arange(begin, min(begin + _CHUNK, n))
        for off, slopes in weighted(model, rows.some(own), of_pump):
            robust = np.minimum(1.0, HUBER / np.maximum(np.abs(off), 1e-300))
            np.add.at(found, piece[own], slopes * (robust * off)[:, None])
    return found
