"""Orifice curves of a valve on shared knots, as numbers that a fit may change: rises that are never negative, and places of knots."""

from typing import NamedTuple

import numpy as np


class Curves(NamedTuple):
    """Conductances of a valve over its travel, linear between knots.

    Attributes
    ----------
    knots : (m,) array, m
        From 0, rising.
    inlet : (m,) array, m3/s/Pa^0.5
        From 0, never falling.
    bypass : (m,) array, m3/s/Pa^0.5
        Never rising.
    """

    knots: np.ndarray
    inlet: np.ndarray
    bypass: np.ndarray


class Place(NamedTuple):
    """Where travels lie among knots.

    Attributes
    ----------
    left : (n_row,) array of int
        Knot below each.
    share : (n_row,) array
        Of the way to the next one.
    """

    left: np.ndarray
    share: np.ndarray


def placed_among(knots: np.ndarray, travel: np.ndarray) -> Place:
    """Where travels, (n_row,) in m, lie; those beyond the last knot lie at it."""
    left = np.clip(np.searchsorted(knots, travel, side="right") - 1, 0, len(knots) - 2)
    share = (travel - knots[left]) / (knots[left + 1] - knots[left])
    return Place(left, np.clip(share, 0.0, 1.0))


def at_place(values: np.ndarray, place: Place) -> np.ndarray:
    """Values linear between knots, (n_row,)."""
    return values[place.left] * (1.0 - place.share) + values[place.left + 1] * place.share


def rising(count: int) -> np.ndarray:
    """From rises behind the first knot to values, (count, count - 1): the first value is 0."""
    return np.tril(np.ones((count, count)))[:, 1:]


def falling(count: int) -> np.ndarray:
    """From falls, and the last value as the last of them, to values, (count, count)."""
    return np.triu(np.ones((count, count)))


def with_knot(curves: Curves, at: float) -> Curves:
    """The same curves with one more knot."""
    place = int(np.searchsorted(curves.knots, at))
    values = (np.insert(v, place, np.interp(at, curves.knots, v)) for v in (curves.inlet, curves.bypass))
    return Curves(np.insert(curves.knots, place, at), *values)


def between(knots: np.ndarray) -> np.ndarray:
    """Knots with one more in the middle of every two, (2 m - 1,)."""
    return np.sort(np.concatenate([knots, 0.5 * (knots[1:] + knots[:-1])]))


def with_knots_between(curves: Curves) -> Curves:
    """The same curves on twice as many knots."""
    knots = between(curves.knots)
    return Curves(knots, *(np.interp(knots, curves.knots, v) for v in (curves.inlet, curves.bypass)))
