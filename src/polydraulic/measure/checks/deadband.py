"""Deadbands and active regions, found from an input and what it moves.

y = c + a r + b s, with r = max(u - high, 0) and s = max(low - u, 0), is fitted for every pair of edges on a grid, first over all
inputs, then nearer and nearer to the edges, where a straight line says enough, on finer grids. Before that the input is delayed and lagged as far as explains the
output best, since a valve follows its lever late. Edges get intervals from drawing blocks of time anew (moving blocks, not rows,
which are not independent).
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.smoothing import differentiate
from polydraulic.tables import Table
from polydraulic.units import Conversion

CONFIDENCE = 0.95
_RATES = ("m3/s", "m/s", "rad/s", "1")
_POSITIONS = ("m", "rad")
_EXPLAINED = 0.4  # share of the variance, at least
_GRID, _BINS, _BLOCKS, _DRAWS = 31, 40, 40, 200
_LONGEST_DELAY, _LAGS = 0.4, (0.0, 0.03, 0.06, 0.1, 0.15, 0.25, 0.4)  # s
_NEAR = (0.6, 0.35)  # share of each active region that the second and third fit look at
_ROWS = 200_000
_PIECE, _PIECES = 4000, 12  # rows, of a long log, that its timing is found from


class Deadband(NamedTuple):
    """A deadband of `input`, in which `output` does not answer.

    Attributes
    ----------
    input, output : str
        `output` is ``d(name)/dt`` where a position was differentiated.
    low, high : float
        Edges, in the input's unit: the active regions lie below and above.
    low_interval, high_interval : (float, float)
        In which they lie at the level `CONFIDENCE`, as far as the spread between blocks of time tells.
    delay, lag : float, s
        By which the output follows the input.
    explained : float
        Share of the output's variance.
    found : bool
        Whether the intervals of the two edges are apart: that there is a deadband at all.
    """

    input: str
    output: str
    low: float
    high: float
    low_interval: tuple[float, float]
    high_interval: tuple[float, float]
    delay: float
    lag: float
    explained: float
    found: bool

    def statement(self, unit: Conversion | None = None) -> str:
        """In words, in a unit of the log if given."""
        if not self.found:
            return f"{self.output} over {self.input}: no significant deadband"
        edges = [self.low, *self.low_interval, self.high, *self.high_interval]
        low, a, b, high, c, d = edges if unit is None else [unit.from_si(edge) for edge in edges]
        return (
            f"{self.output} answers {self.input} below {low:.4g} ({a:.4g} to {b:.4g}) and above {high:.4g} ({c:.4g} to {d:.4g})"
            f"{'' if unit is None else f' {unit.unit}'}, {CONFIDENCE:.0%} intervals; delay {self.delay:.2g} s, lag {self.lag:.2g} s; "
            f"explains {self.explained:.0%} of the variance"
        )


def find_deadbands(table: Table, inputs: Sequence[str], outputs: Sequence[str], raster: float) -> list[Deadband]:
    """Deadbands of the inputs that explain the outputs best, one for each output that is a rate, a flow or a position.

    Parameters
    ----------
    table : Table
        Imported: with the columns ``time`` and ``segment``.
    inputs, outputs : sequence of str
    raster : float, s
    """
    found = []
    inputs = [name for name in inputs if table.unit(name) != "Pa"]
    for output in outputs:
        unit = table.unit(output)
        if unit not in _RATES + _POSITIONS:
            continue
        rate = unit in _RATES
        answers = [deadband(table, name, output, raster, rate=rate) for name in inputs if np.ptp(table[name]) > 0.0]
        best = max((a for a in answers if a is not None), key=lambda a: a.explained, default=None)
        if best is not None:
            found.append(best)
    return found


def deadband(
    table: Table, input_: str, output: str, raster: float, *, rate: bool = True, seed: int = 0
) -> Deadband | None:
    """Find the deadband of one input; None if it does not explain the output, or the rows are too few.

    Parameters
    ----------
    table : Table
        Imported: with the columns ``time`` and ``segment``.
    input_, output : str
    raster : float, s
    rate : bool
        False for a position, which is differentiated.
    seed : int
        Of the draws.
    """
    if raster <= 0.0:
        raise InputError(f"raster = {raster} s: must be positive")
    segments = [
        part for part in np.split(np.arange(len(table)), np.flatnonzero(np.diff(table["segment"])) + 1)
        if len(part) * raster > 2.0 * _LONGEST_DELAY and len(part) > 10
    ]  # fmt: skip
    if not segments or sum(map(len, segments)) < 20 * _BLOCKS:
        return None
    u_parts = [table[input_][part] for part in segments]
    y_parts = [table[output][part] for part in segments]
    if not rate:
        y_parts = [differentiate(y, raster, max(0.1, 5 * raster)) for y in y_parts]
    delay, lag, share = _timing(u_parts, y_parts, raster)
    if share < _EXPLAINED:
        return None
    u, y = _aligned(u_parts, y_parts, raster, delay, lag)
    thin = max(1, len(u) // _ROWS)
    u, y = u[::thin], y[::thin]
    centre, half = 0.5 * (u.max() + u.min()), 0.5 * np.ptp(u)
    u, scale = (u - centre) / half, float(np.std(y))
    y = y / scale
    grid = np.linspace(-0.95, 0.95, _GRID)
    moments = _moments(u, y, grid, 1)
    low, high, explained = _edges(*moments, grid)
    for near in _NEAR:
        keep = (u >= low - near * (low + 1.0)) & (u <= high + near * (1.0 - high))
        if keep.sum() < 20 * _BLOCKS:
            return None
        grid = np.linspace(low - near * (low + 1.0), high + near * (1.0 - high), 2 * _GRID)
        moments = _moments(u[keep], y[keep], grid, _BLOCKS)
        low, high, _ = _edges(*moments, grid)
    rng = np.random.default_rng(seed)
    draws = np.array([_edges(*moments, grid, rng.integers(_BLOCKS, size=_BLOCKS))[:2] for _ in range(_DRAWS)])
    tail, error = 0.5 * (1.0 - CONFIDENCE), 0.5 * float(grid[1] - grid[0])
    ends = np.quantile(draws, [tail, 1.0 - tail], axis=0) + np.array([[-error], [error]])
    (low_a, high_a), (low_b, high_b) = centre + half * ends
    label = output if rate else f"d({output})/dt"
    return Deadband(
        input_, label, float(centre + half * low), float(centre + half * high), (float(low_a), float(low_b)),
        (float(high_a), float(high_b)), delay, lag, explained, bool(low_b < high_a),
    )  # fmt: skip


def _aligned(
    u_parts: list[np.ndarray], y_parts: list[np.ndarray], raster: float, delay: float, lag: float
) -> tuple[np.ndarray, np.ndarray]:
    """Inputs, delayed and lagged, next to outputs; the start of each segment, where neither is known, is left out."""
    from scipy.signal import lfilter

    shift, skip = round(delay / raster), int(_LONGEST_DELAY / raster) + 1
    keep = np.exp(-raster / lag) if lag > 0.0 else 0.0
    inputs = []
    for u in u_parts:
        follows = u if lag == 0.0 else lfilter([1.0 - keep], [1.0, -keep], u, zi=[keep * u[0]])[0]
        inputs.append(follows[skip - shift : len(u) - shift])
    return np.concatenate(inputs), np.concatenate([y[skip:] for y in y_parts])


def _some(parts: list[np.ndarray]) -> list[np.ndarray]:
    """A part of a long log, from all over it: enough for the timing."""
    pieces = [part[at : at + _PIECE] for part in parts for at in range(0, max(1, len(part) - _PIECE // 2), _PIECE)]
    return pieces[:: max(1, len(pieces) // _PIECES)]


def _timing(u_parts: list[np.ndarray], y_parts: list[np.ndarray], raster: float) -> tuple[float, float, float]:
    """Delay and lag with which bins of the input explain the output best, and the share of variance that they explain."""
    best = (0.0, 0.0, -1.0)
    u_parts, y_parts = _some(u_parts), _some(y_parts)
    for lag in _LAGS:
        for shift in range(0, int(_LONGEST_DELAY / raster) + 1, max(1, round(0.02 / raster))):
            u, y = _aligned(u_parts, y_parts, raster, shift * raster, lag)
            spread = float(np.var(y))
            if spread == 0.0 or np.ptp(u) == 0.0:
                return best
            place = np.minimum((_BINS * (u - u.min()) / np.ptp(u)).astype(np.int64), _BINS - 1)
            n, total = np.bincount(place, minlength=_BINS), np.bincount(place, weights=y, minlength=_BINS)
            share = float((total**2 / np.maximum(n, 1)).sum() / len(y) - y.mean() ** 2) / spread
            if share > best[2] + 1e-3:  # no longer delay than pays
                best = (shift * raster, lag, share)
    return best


def _moments(u: np.ndarray, y: np.ndarray, grid: np.ndarray, blocks: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sums over blocks of time for every edge: both sides (block, edge, 3) each, and of the rows (block, 3)."""
    ends = np.linspace(0, len(u), blocks + 1).astype(np.int64)
    above, below = np.empty((blocks, len(grid), 3)), np.empty((blocks, len(grid), 3))
    rows = np.empty((blocks, 3))
    for b, (first, end) in enumerate(pairwise(ends)):
        x, z = u[first:end], y[first:end]
        rows[b] = len(z), z.sum(), z @ z
        for e, edge in enumerate(grid):
            for side, r in ((above, np.maximum(x - edge, 0.0)), (below, np.maximum(edge - x, 0.0))):
                side[b, e] = r.sum(), r @ r, r @ z
    return above, below, rows


def _edges(
    above: np.ndarray, below: np.ndarray, rows: np.ndarray, grid: np.ndarray, draw: np.ndarray | None = None
) -> tuple[float, float, float]:
    """The pair of edges with the smallest squared error over the blocks drawn, and the share of variance explained."""
    chosen = slice(None) if draw is None else draw
    a, b, (n, sy, syy) = above[chosen].sum(axis=0), below[chosen].sum(axis=0), rows[chosen].sum(axis=0)
    i, j = np.triu_indices(len(grid))  # low edge, high edge
    matrix, right = np.zeros((len(i), 3, 3)), np.empty((len(i), 3))
    matrix[:, 0, 0], right[:, 0] = n, sy
    for at, side in ((1, a[j]), (2, b[i])):
        matrix[:, 0, at] = matrix[:, at, 0] = side[:, 0]
        matrix[:, at, at], right[:, at] = side[:, 1], side[:, 2]
    matrix += 1e-9 * n * np.eye(3)  # a side without rows has no slope
    solution = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
    error = syy - np.einsum("ki,ki->k", solution, right)
    best = int(np.argmin(error))
    spread = syy - sy * sy / n
    return float(grid[i[best]]), float(grid[j[best]]), float(1.0 - error[best] / spread) if spread > 0.0 else 0.0
