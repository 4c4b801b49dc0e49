"""Standard errors of what was fitted to a circuit: from the slopes at the solution, and from how blocks of time pull at it.

Rows that follow each other err together, so that squares summed over rows would promise too much: the sums of whole blocks say how much
the solution would move if they had been others. Bounds are left out, so that a curve that lies flat is not
taken for known.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import (
    HUBER,
    CircuitModel,
    CircuitRows,
    Prior,
    normal,
    numbers_to_values,
    weighted,
)

_CHUNK = 8192
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
    h = t.T @ at.curvature @ t
    scale = 1.0 / np.sqrt(np.maximum(np.diag(h), 1e-300))
    bread = np.linalg.pinv(h * scale[:, None] * scale, rcond=1e-12) * scale[:, None] * scale
    pulls = _pulls(model, rows, list(prior.pump)) @ t
    meat = pulls.T @ pulls
    data = bread @ meat @ bread
    known = normal(model, rows.some(np.arange(0)), prior).curvature  # of what was known before
    before = bread @ (t.T @ known @ t) @ bread
    covariance = t @ (data + before) @ t.T
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    valves, place = [], 0
    for v in model.valves:
        m = len(v.knots)
        parts = [sigma[place + k * m : place + (k + 1) * m] for k in range(3)]
        valves.append(dict(zip(("inlet", "bypass", "knots"), parts, strict=True)))
        place += 3 * m
    return CircuitErrors(valves, dict(zip(prior.pump, sigma[place:].tolist(), strict=True)), _pairs(model, covariance))


def _pairs(model: CircuitModel, covariance: np.ndarray) -> list[tuple[int, int, float]]:
    """Pairs of numbers of different curves with nearly the same error, the closest first."""
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    known = sigma > 1e-3 * sigma.max(initial=0.0)
    r = covariance / np.maximum(sigma[:, None] * sigma, 1e-300)
    curve = np.concatenate([np.full(len(v.knots), 3 * i + k) for i, v in enumerate(model.valves) for k in range(3)])
    curve = np.concatenate([curve, np.arange(len(sigma) - len(curve)) + 3 * len(model.valves)])
    places = curve % 3 == 2
    i, j = np.nonzero(
        np.triu(np.abs(r) > _CLOSE, 1)
        & (curve[:, None] != curve)
        & (known[:, None] & known)
        & ~(places[:, None] | places)
    )
    order = np.argsort(-np.abs(r[i, j]))[:_SHOWN]
    return [(int(i[k]), int(j[k]), float(r[i[k], j[k]])) for k in order]


def _pulls(model: CircuitModel, rows: CircuitRows, of_pump: list[str]) -> np.ndarray:
    """Gradient of each block of time, (n_block, n_number)."""
    blocks, number = np.unique(rows.block, return_inverse=True)
    count = 3 * sum(len(v.knots) for v in model.valves) + len(of_pump)
    found = np.zeros((len(blocks), count))
    for begin in range(0, len(rows.block), _CHUNK):
        part = slice(begin, begin + _CHUNK)
        for off, slopes in weighted(model, rows.some(np.arange(len(rows.block))[part]), of_pump):
            robust = np.minimum(1.0, HUBER / np.maximum(np.abs(off), 1e-300))
            np.add.at(found, number[part], slopes * (robust * off)[:, None])
    return found
