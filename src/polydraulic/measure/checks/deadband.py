"""Deadbands and active regions, found from an input and what it moves.

y = c + a r + b s, with r = max(u - high, 0) and s = max(low - u, 0), is fitted for every pair of edges on a grid, first over all
inputs, then nearer and nearer to the edges, where a straight line says enough, on finer grids. Before that the input is delayed and lagged as far as explains the
output best, since a valve follows its lever late. Edges get intervals from drawing blocks of time anew (moving blocks, not rows,
which are not independent).
"""

from collections.abc import Iterator, Mapping, Sequence
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
_PIECE, _PIECES = 4000, 12  # rows at least, and how many times, of a long log, that its timing is found from


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
    rates = {name: unit in _RATES for name in outputs if (unit := table.unit(name)) in _RATES + _POSITIONS}
    inputs = [name for name in inputs if table.unit(name) != "Pa" and np.ptp(table[name]) > 0.0]
    best: dict[str, Deadband] = {}
    for answer_of in _answers(table, inputs, rates, raster, 0):
        for output, answer in answer_of.items():
            if output not in best or answer.explained > best[output].explained:
                best[output] = answer
    return [best[output] for output in rates if output in best]


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
    return next((answers.get(output) for answers in _answers(table, [input_], {output: rate}, raster, seed)), None)


def _answers(
    table: Table, inputs: Sequence[str], rates: Mapping[str, bool], raster: float, seed: int
) -> Iterator[dict[str, Deadband]]:
    """Of each input, deadbands by the outputs that it explains; `rates` says of these whether they are rates, or are differentiated."""
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(table["segment"])) + 1, [len(table)]])
    segments = [
        slice(first, end) for first, end in pairwise(cuts.tolist())
        if (end - first) * raster > 2.0 * _LONGEST_DELAY and end - first > 10
    ]  # fmt: skip
    if not rates or not segments or sum(part.stop - part.start for part in segments) < 20 * _BLOCKS:
        return
    y_parts = {}
    for output, rate in rates.items():
        parts = [table[output][part] for part in segments]
        y_parts[output] = parts if rate else [differentiate(y, raster, max(0.1, 5 * raster)) for y in parts]
    for name in inputs:
        u_parts = [table[name][part] for part in segments]
        timings = _timings(u_parts, list(y_parts.values()), raster)
        found: dict[str, Deadband] = {}
        for (output, parts), timing in zip(y_parts.items(), timings, strict=True):
            if timing[2] >= _EXPLAINED:
                label = output if rates[output] else f"d({output})/dt"
                answer = _deadband(u_parts, parts, (name, label), raster, timing, seed)
                found |= {} if answer is None else {output: answer}
        yield found


def _deadband(
    u_parts: list[np.ndarray],
    y_parts: list[np.ndarray],
    names: tuple[str, str],
    raster: float,
    timing: tuple[float, float, float],
    seed: int,
) -> Deadband | None:
    delay, lag, _ = timing
    u, y = _delayed(_lagged(u_parts, raster, lag), raster, delay), _settled(y_parts, raster)
    thin = max(1, len(u) // _ROWS)
    u, y = u[::thin], y[::thin]
    centre, half = 0.5 * (u.max() + u.min()), 0.5 * np.ptp(u)
    u, scale = (u - centre) / half, float(np.std(y))
    y = y / scale
    grid = np.linspace(-0.95, 0.95, _GRID)
    moments = _moments(u, y, grid, 1)
    low, high, explained = (float(one[0]) for one in _edges(*moments, grid))
    for near in _NEAR:
        keep = (u >= low - near * (low + 1.0)) & (u <= high + near * (1.0 - high))
        if keep.sum() < 20 * _BLOCKS:
            return None
        grid = np.linspace(low - near * (low + 1.0), high + near * (1.0 - high), 2 * _GRID)
        moments = _moments(u[keep], y[keep], grid, _BLOCKS)
        low, high, _ = (float(one[0]) for one in _edges(*moments, grid))
    rng = np.random.default_rng(seed)
    chosen = np.stack([np.bincount(rng.integers(_BLOCKS, size=_BLOCKS), minlength=_BLOCKS) for _ in range(_DRAWS)])
    draws = np.stack(_edges(*moments, grid, chosen.astype(float))[:2], axis=-1)
    tail, error = 0.5 * (1.0 - CONFIDENCE), 0.5 * float(grid[1] - grid[0])
    ends = np.quantile(draws, [tail, 1.0 - tail], axis=0) + np.array([[-error], [error]])
    (low_a, high_a), (low_b, high_b) = centre + half * ends
    return Deadband(
        *names, float(centre + half * low), float(centre + half * high), (float(low_a), float(low_b)),
        (float(high_a), float(high_b)), delay, lag, explained, bool(low_b < high_a),
    )  # fmt: skip


def _lagged(u_parts: list[np.ndarray], raster: float, lag: float) -> list[np.ndarray]:
    """Inputs through a lag of first order, which begins at rest at the first value of each part.

    y[i] = k y[i-1] + (1 - k) u[i] is summed by doubling: what a sum over n samples leaves out comes k^n later. (A filter of SciPy would
    do; its import takes as long as all of this.)
    """
    if lag == 0.0:
        return u_parts
    keep = float(np.exp(-raster / lag))
    found = []
    for u in u_parts:
        y, share, reach = (1.0 - keep) * (u - u[0]), keep, 1
        while reach < len(y) and share > 1e-18:
            y[reach:] += share * y[:-reach]
            share, reach = share * share, 2 * reach
        found.append(u[0] + y)
    return found


def _delayed(u_parts: list[np.ndarray], raster: float, delay: float) -> np.ndarray:
    """Inputs, delayed; the start of each part, where nothing is known before it, is left out."""
    shift, skip = round(delay / raster), _skipped(raster)
    return np.concatenate([u[skip - shift : len(u) - shift] for u in u_parts])


def _settled(y_parts: list[np.ndarray], raster: float) -> np.ndarray:
    """Outputs beside `_delayed` inputs."""
    return np.concatenate([y[_skipped(raster) :] for y in y_parts])


def _skipped(raster: float) -> int:
    return int(_LONGEST_DELAY / raster) + 1


def _some(parts: list[np.ndarray], raster: float) -> list[np.ndarray]:
    """A part of a long log, from all over it: enough for the timing."""
    long = max(_PIECE, 4 * _skipped(raster))
    pieces = [part[at : at + long] for part in parts for at in range(0, max(1, len(part) - long // 2), long)]
    return pieces[:: max(1, len(pieces) // _PIECES)]


def _timings(
    u_parts: list[np.ndarray], y_parts: list[list[np.ndarray]], raster: float
) -> list[tuple[float, float, float]]:
    """Of each output: delay and lag with which bins of the input explain it best, and the share of variance that they explain."""
    u_parts, n_output = _some(u_parts, raster), len(y_parts)
    # the start of each part, where delayed inputs are not known, counts nothing
    counts = np.concatenate([np.arange(len(u)) >= _skipped(raster) for u in u_parts]).astype(float)
    outputs = [np.concatenate(_some(parts, raster)) for parts in y_parts]
    n_row = float(counts.sum())
    outputs = [counts * (y - float((counts * y).sum()) / n_row) for y in outputs]
    spreads = [float((y * y).sum()) / n_row for y in outputs]
    # an input stays in a bin for some rows, so that sums up to a row are read where it leaves one
    sums = np.cumsum(np.pad([counts, *outputs], ((0, 0), (1, 0))), axis=1)
    best = [(0.0, 0.0, -1.0)] * n_output
    for lag in _LAGS:
        u = np.concatenate(_lagged(u_parts, raster, lag))
        low, width = float(u.min()), float(np.ptp(u))
        if width == 0.0:
            return best
        place = np.minimum((_BINS * (u - low) / width).astype(np.int64), _BINS - 1)
        begins = np.flatnonzero(np.diff(place, prepend=-1))
        bins, ends = place[begins], np.append(begins, len(place))
        for shift in range(0, int(_LONGEST_DELAY / raster) + 1, max(1, round(0.02 / raster))):
            stays = np.diff(sums[:, np.minimum(ends + shift, len(place))])
            n, *totals = (np.bincount(bins, stay, _BINS) for stay in stays)
            for k, (total, spread) in enumerate(zip(totals, spreads, strict=True)):
                share = float((total**2 / np.maximum(n, 1.0)).sum()) / n_row / spread if spread > 0.0 else -1.0
                if share > best[k][2] + 1e-3:  # no longer delay than pays
                    best[k] = (shift * raster, lag, share)
    return best


def _moments(u: np.ndarray, y: np.ndarray, grid: np.ndarray, blocks: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sums over blocks of time for every edge: of r, r^2 and r y on both sides (block, edge, 3) each, and of the rows (block, 3).

    With r = u - e they follow from sums of 1, u, u^2, y and u y over the rows beyond e, and these from sums between edges.
    """
    ends = np.linspace(0, len(u), blocks + 1).astype(np.int64)
    block = np.repeat(np.arange(blocks), np.diff(ends))
    bins = len(grid) + 1
    place = block * bins + np.searchsorted(grid, u)
    sums = np.stack(
        [np.bincount(place, weights, blocks * bins).reshape(blocks, bins) for weights in (None, u, u * u, y, u * y)]
    )
    rows = np.stack([sums[0].sum(axis=1), sums[3].sum(axis=1), np.bincount(block, y * y, blocks)], axis=-1)
    over = sums[:, :, ::-1].cumsum(axis=2)[:, :, ::-1][:, :, 1:]  # beyond each edge
    under = sums.cumsum(axis=2)[:, :, :-1]

    def side(sums: np.ndarray, sign: float) -> np.ndarray:
        n, x, xx, z, xz = sums
        return np.stack((sign * (x - grid * n), xx - grid * (2.0 * x - grid * n), sign * (xz - grid * z)), axis=-1)

    return side(over, 1.0), side(under, -1.0), rows


def _edges(
    above: np.ndarray, below: np.ndarray, rows: np.ndarray, grid: np.ndarray, chosen: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The pairs of edges with the smallest squared error, and the shares of variance explained.

    `chosen` says how often each block is drawn, (draw, block); without, all blocks are taken once. No row is on both sides, so that the
    normal equations of c, a and b are those of c alone once each side is solved for.
    """
    drawn = np.ones((1, len(rows))) if chosen is None else chosen
    n, sy, syy = (drawn @ rows).T[:, :, None, None]

    def solved(side: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        r, rr, ry = np.einsum("db,bek->kde", drawn, side)
        rr = rr + 1e-9 * n[:, :, 0]  # a side without rows has no slope
        return r * r / rr, r * ry / rr, ry * ry / rr

    (r_low, w_low, q_low), (r_high, w_high, q_high) = solved(below), solved(above)
    left = n * (1.0 + 1e-9) - r_low[:, :, None] - r_high[:, None, :]
    rest = sy - w_low[:, :, None] - w_high[:, None, :]
    error = syy - (rest * rest / left + q_low[:, :, None] + q_high[:, None, :])
    error[:, *np.tril_indices(len(grid), -1)] = np.inf  # low above high
    best = error.reshape(len(drawn), -1).argmin(axis=1)
    low, high = np.unravel_index(best, (len(grid), len(grid)))
    spread = (syy - sy * sy / n)[:, 0, 0]
    least = error.reshape(len(drawn), -1)[np.arange(len(drawn)), best]
    return grid[low], grid[high], np.where(spread > 0.0, 1.0 - least / np.where(spread > 0.0, spread, 1.0), 0.0)
