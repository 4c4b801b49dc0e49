"""Numbers of a machine as coordinates without bounds: positive ones stay positive, curves stay monotone.

A coordinate is counted in standard deviations of a number's prior, so that one step means about as much for each of them.
"""

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError

_KNOT = re.compile(r"(?P<curve>.+\.valve\.(?P<name>inlet|bypass|outlet_positive|outlet_negative))\[(?P<place>\d+)\]")
_ANY_SIGN = re.compile(r"\.(cg|at|base|rod_pin|hinge|knee|pin)\.|\.inertia\.(xy|xz|yz)$|\.stops\.|\.initial\.(angle|position)$")
_ROUND = 0.05  # of the spread, within which a number near zero is rounded off


class Unbounded(NamedTuple):
    """Numbers that are to be found.

    Attributes
    ----------
    paths : tuple of str
    start, spread : (n,) array, SI
        Mean and standard deviation of the prior.
    signed : (n,) array of bool
        Whether a number may have any sign.
    below : (n,) array of int
        Place of the number above which one lies, as the next knot of its curve; -1 for none.
    floor : (n,) array
        Least value of the others that have no sign: that of the neighbouring knot, or zero.
    """

    paths: tuple[str, ...]
    start: np.ndarray
    spread: np.ndarray
    signed: np.ndarray
    below: np.ndarray
    floor: np.ndarray


def unbounded(values: Mapping[str, float], spreads: Mapping[str, float]) -> Unbounded:
    """Coordinates of numbers.

    Parameters
    ----------
    values : mapping from path to value, SI
        All numbers of the machine.
    spreads : mapping from path to standard deviation, SI
        Of those that are to be found.

    Raises
    ------
    InputError
        An unknown path, a spread that is not positive.
    """
    for path, spread in spreads.items():
        if path not in values:
            raise InputError(f"free number {path!r}: the machine has no such number")
        if not 0.0 < spread < np.inf:
            raise InputError(f"free number {path!r}: its spread is {spread:g}; it must be positive and finite")
    paths = tuple(spreads)
    below, floor = np.full(len(paths), -1), np.zeros(len(paths))
    for k, path in enumerate(paths):
        if match := _KNOT.fullmatch(path):
            step = 1 if match["name"] == "bypass" else -1  # a bypass falls over the travel, all others rise
            neighbour = f"{match['curve']}[{int(match['place']) + step}]"
            if neighbour in paths:
                below[k] = paths.index(neighbour)
            else:
                floor[k] = values.get(neighbour, 0.0)
    start = np.array([float(values[path]) for path in paths])
    signed = np.array([bool(_ANY_SIGN.search(path)) for path in paths])
    return Unbounded(paths, start, np.array([float(s) for s in spreads.values()]), signed, below, floor)


def to_unbounded(numbers: Unbounded, values: np.ndarray) -> np.ndarray:
    """Coordinates of values, (n,)."""
    under = np.where(numbers.below >= 0, values[numbers.below], numbers.floor)
    rise = np.maximum(values - under, 1e-3 * _ROUND * numbers.spread)
    edge = _ROUND * numbers.spread
    return np.asarray(np.where(numbers.signed, values - numbers.start, rise - edge**2 / rise) / numbers.spread)


def from_unbounded(numbers: Unbounded, coordinates: np.ndarray) -> np.ndarray:
    """Values of coordinates, (n,); a rise r above what lies below has the coordinate r - edge^2 / r, for r > 0."""
    u, edge = coordinates * numbers.spread, _ROUND * numbers.spread
    rise = 0.5 * (u + np.sqrt(u * u + 4.0 * edge * edge))
    rise = np.where(rise > 1e-12 * edge, rise, 1e-12 * edge)
    found = np.where(numbers.signed, numbers.start + u, np.nan)
    for k in _lowest_first(numbers.below):
        if not numbers.signed[k]:
            found[k] = rise[k] + (found[numbers.below[k]] if numbers.below[k] >= 0 else numbers.floor[k])
    return found


def slopes_of_values(numbers: Unbounded, coordinates: np.ndarray) -> np.ndarray:
    """Slopes of values over coordinates, (n, n)."""
    u, edge = coordinates * numbers.spread, _ROUND * numbers.spread
    own = np.where(numbers.signed, 1.0, 0.5 * (1.0 + u / np.sqrt(u * u + 4.0 * edge * edge))) * numbers.spread
    found = np.diag(own)
    for k in _lowest_first(numbers.below):
        if numbers.below[k] >= 0:
            found[k] += found[numbers.below[k]]
    return found


def _lowest_first(below: Sequence[int] | np.ndarray) -> list[int]:
    """Places in an order in which each comes after what lies below it."""

    def depth(k: int) -> int:
        count = 0
        while below[k] >= 0:
            k, count = int(below[k]), count + 1
        return count

    return sorted(range(len(below)), key=depth)
