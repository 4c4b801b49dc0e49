"""Numbers of a machine as coordinates without bounds: whatever they are, the machine is possible.

A number is a sum of coordinates that have any sign and of rises that are positive: a knot of a curve is its neighbour and a rise, static
friction is Coulomb friction and a rise, moments of inertia are sums of second moments. A coordinate is counted in standard
deviations of the number's prior, so that a step of one means about as much for each of them.
"""

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine

_KNOT = re.compile(r"(?P<curve>.+\.(inlet|bypass|outlet_positive|outlet_negative|conductance))\[(?P<place>\d+)\]")
_MOMENT = re.compile(r"(?P<link>links\.[^.]+\.inertia)\.(?P<key>xx|yy|zz)")
_ROUND = 0.05  # of the spread: a rise that is much smaller is rounded off


class Unbounded(NamedTuple):
    """Numbers that are to be found: values = sums @ parts + known, where parts are coordinates or rises.

    Attributes
    ----------
    paths : tuple of str
    start, spread : (n,) array, SI
        Mean and standard deviation of the prior.
    rises : (n,) array of bool
        Which parts are positive.
    sums : (n, n) array
    known : (n,) array
        What numbers that are not to be found add.
    """

    paths: tuple[str, ...]
    start: np.ndarray
    spread: np.ndarray
    rises: np.ndarray
    sums: np.ndarray
    known: np.ndarray


def unbounded(machine: LayoutMachine, spreads: Mapping[str, float]) -> Unbounded:
    """Coordinates of numbers around those of a machine.

    Parameters
    ----------
    machine : LayoutMachine
        Its numbers are the means of the priors.
    spreads : mapping from path to standard deviation, SI
        Of the numbers that are to be found; the path of a table stands for all of its numbers that are not zero.

    Raises
    ------
    InputError
        No number to be found, an unknown path, a spread that is not positive.
    """
    numbers = {number.path: number for number in machine.numbers}
    if not spreads:
        raise InputError("no number is free: name one at least that is to be found")
    each: dict[str, float] = {}
    for path, spread in spreads.items():
        of_table = [
            number.path for number in machine.numbers if number.path.startswith(f"{path}[") and number.value != 0.0
        ]
        if path not in numbers and not of_table:
            raise InputError(f"free number {path!r}: the machine has no such number")
        each |= dict.fromkeys(of_table or [path], float(spread))
        if not 0.0 < spread < np.inf:
            raise InputError(f"free number {path!r}: its spread is {spread:g}; it must be positive and finite")
    paths = tuple(each)
    quantities = [numbers[path].quantity for path in paths]
    bounded = [
        q.low > -np.inf or q.above > -np.inf or bool(_MOMENT.fullmatch(p))
        for q, p in zip(quantities, paths, strict=True)
    ]
    sums, known = np.eye(len(paths)), np.zeros(len(paths))
    for k in _neighbours_first(paths):
        under = _under(paths[k])
        if under in paths:
            sums[k] += sums[paths.index(under)]
            known[k] = known[paths.index(under)]
        elif under in numbers:
            known[k] = numbers[under].value
    for link in {match["link"] for path in paths if (match := _MOMENT.fullmatch(path))}:
        own = [f"{link}.{key}" for key in ("xx", "yy", "zz")]
        if all(path in paths for path in own):
            places = [paths.index(path) for path in own]
            sums[np.ix_(places, places)] = 1.0 - np.eye(3)  # xx is the second moments of y and z
    start = np.array([numbers[path].value for path in paths])
    return Unbounded(paths, start, np.array(list(each.values())), np.array(bounded), sums, known)


def to_unbounded(numbers: Unbounded, values: np.ndarray) -> np.ndarray:
    """Coordinates of values, (n,); a rise r has the coordinate r - edge^2 / r, so that it grows evenly where it is not small."""
    parts, edge = np.linalg.solve(numbers.sums, values - numbers.known), _ROUND * numbers.spread
    rise = np.maximum(parts, 1e-3 * edge)
    return np.asarray(np.where(numbers.rises, rise - edge * edge / rise, parts) / numbers.spread)


def from_unbounded(numbers: Unbounded, coordinates: np.ndarray) -> np.ndarray:
    """Values of coordinates, (n,)."""
    return np.asarray(numbers.sums @ _parts(numbers, coordinates)[0] + numbers.known)


def with_rises_open(numbers: Unbounded, coordinates: np.ndarray) -> np.ndarray:
    """Coordinates, (n,), at which no rise is closed: where one is, it hardly depends on its coordinate, and no step of a search opens it again."""
    return np.where(numbers.rises, np.maximum(coordinates, 0.0), coordinates)


def slopes_of_values(numbers: Unbounded, coordinates: np.ndarray) -> np.ndarray:
    """Slopes of values over coordinates, (n, n)."""
    return np.asarray(numbers.sums * _parts(numbers, coordinates)[1])


def _parts(numbers: Unbounded, coordinates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts, and their slopes over the coordinates."""
    u, edge = coordinates * numbers.spread, _ROUND * numbers.spread
    root = np.sqrt(u * u + 4.0 * edge * edge)
    rise = np.where(u > 0.0, 0.5 * (root + u), 2.0 * edge * edge / (root + np.abs(u)))  # without cancellation
    return np.where(numbers.rises, rise, u), np.where(numbers.rises, rise / root, 1.0) * numbers.spread


def _under(path: str) -> str | None:
    """The number that one lies above: the neighbouring knot where a curve is lower, or Coulomb friction."""
    if path.endswith(".friction.static"):
        return path.replace("static", "coulomb")
    if match := _KNOT.fullmatch(path):
        step = 1 if match["curve"].endswith("bypass") else -1  # a bypass closes over the travel, all others open
        return f"{match['curve']}[{int(match['place']) + step}]"
    return None


def _neighbours_first(paths: tuple[str, ...]) -> list[int]:
    """Places of the numbers, each after the one that it lies above."""

    def depth(path: str) -> int:
        count, under = 0, _under(path)
        while under in paths:
            count, under = count + 1, _under(under)
        return count

    return sorted(range(len(paths)), key=lambda k: depth(paths[k]))
