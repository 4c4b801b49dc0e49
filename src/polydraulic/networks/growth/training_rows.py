"""Rows of a training set, block by block.

Everything that learns from rows sees them through `TrainingRows`, whether they lie in memory, come from a generator, or are read
from a file row group by row group. A block is inputs (n_row, n_input), target (n_row,) and weights (n_row,).
"""

import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError

BLOCK = 4096
SMALLEST = 4  # rows to learn from; up to three for a coefficient, a constant is all that is found
_CONSTANT = 8.0 * float(np.finfo(np.float64).eps)  # a range smaller than this share of the mean is rounding
_HEAVIEST = 1e15  # weight of all rows, and of one in terms of another: beyond it, the smallest one no longer counts
_LIGHT = 0.1  # mean weight below which rows are fewer than they look

_LEAST = 1e-280  # squares below it have lost digits, or are zero

Block = tuple[np.ndarray, np.ndarray, np.ndarray | None]


class Scaling(NamedTuple):
    """Weighted statistics of the rows: what normalizers, unitizer and domain need."""

    weight: float
    x_mean: np.ndarray
    x_scale: np.ndarray
    x_low: np.ndarray
    x_high: np.ndarray
    y_mean: float
    y_scale: float
    y_low: float
    y_high: float
    n_row: int

    @property
    def varies(self) -> np.ndarray:
        """Which inputs are not constant; shape (n_input,)."""
        return self.x_high - self.x_low > _CONSTANT * np.abs(self.x_mean)


class TrainingRows(NamedTuple):
    """Normalized rows: `blocks` starts a new pass over them each time it is called."""

    blocks: Callable[[], Iterator[Block]]
    scaling: Scaling

    def __iter__(self) -> Iterator[Block]:  # type: ignore[override]
        s = self.scaling
        for x, y, w in self.blocks():
            yield (x - s.x_mean) / s.x_scale, (y - s.y_mean) / s.y_scale, w


def rows_in_memory(X: np.ndarray, y: np.ndarray, weight: np.ndarray | None) -> TrainingRows:
    """Rows of arrays that lie in memory."""
    blocks = in_blocks(X, y, weight)
    return TrainingRows(blocks, scaling(blocks))


def in_blocks(X: np.ndarray, y: np.ndarray, weight: np.ndarray | None) -> Callable[[], Iterator[Block]]:
    """Passes over arrays."""

    def blocks() -> Iterator[Block]:
        for start in range(0, len(y), BLOCK):
            part = slice(start, start + BLOCK)
            yield X[part], y[part], None if weight is None else weight[part]

    return blocks


def rows_apart(X: np.ndarray, y: np.ndarray, weight: np.ndarray | None, block: np.ndarray) -> TrainingRows:
    """The same rows, one block for each number in `block` (n_row,), to be left out together."""
    order = np.argsort(block, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(block[order])) + 1)
    scaled = rows_in_memory(X, y, weight).scaling
    return TrainingRows(lambda: ((X[p], y[p], None if weight is None else weight[p]) for p in parts), scaled)


def sample_of(rows: TrainingRows, most: int) -> TrainingRows:
    """At most so many rows from all over, in memory, and scaled as all rows are; one pass over the others.

    One row is drawn of each of `most` stretches of equal length, so that nothing that comes back at a period is missed.
    """
    n = rows.scaling.n_row
    if n <= most:
        return rows
    chosen = ((np.arange(most) + np.random.default_rng(0).random(most)) * (n / most)).astype(np.int64)
    parts, first = [], 0
    for x, y, w in rows.blocks():
        low, high = np.searchsorted(chosen, (first, first + len(y)))
        part = chosen[low:high] - first
        parts.append((x[part], y[part], None if w is None else w[part]))
        first += len(y)
    X, y = (np.concatenate([part[place] for part in parts]) for place in (0, 1))
    drawn = [w for *_, w in parts if w is not None]
    weight = np.concatenate(drawn) if drawn else None
    total = float(len(y) if weight is None else weight.sum())
    return TrainingRows(in_blocks(X, y, weight), rows.scaling._replace(weight=total, n_row=len(y)))


def rows_from_blocks(source: Iterable[Any]) -> TrainingRows:
    """Rows of an iterable of (X, y) or (X, y, weight) that can be passed over again and again.

    Raises
    ------
    InputError
        If it can be passed over only once, holds no rows, or a block is misshapen or not finite.
    """
    if isinstance(source, Iterator):
        raise InputError("the blocks can be read only once; give a list, or an object whose __iter__ starts a new pass")

    def blocks() -> Iterator[Block]:
        for number, item in enumerate(source):
            X, y = (np.asarray(part, dtype=np.float64) for part in item[:2])
            w = None if len(item) < 3 else np.asarray(item[2], dtype=np.float64)
            of_weight = y.shape if w is None else w.shape
            if X.ndim != 2 or y.shape != (len(X),) or of_weight != y.shape:
                raise InputError(
                    f"block {number}: X {X.shape}, y {y.shape}, weight {of_weight} must be (n, k), (n,) and (n,)"
                )
            given = (X, y) if w is None else (X, y, w)
            if not all(np.all(np.isfinite(part)) for part in given) or (w is not None and np.any(w < 0.0)):
                raise InputError(f"block {number}: every value must be finite, weights not negative")
            for start in range(0, len(y), BLOCK):
                part = slice(start, start + BLOCK)
                if w is None:
                    yield X[part], y[part], None
                elif (keep := w[part] > 0.0).any():
                    yield X[part][keep], y[part][keep], w[part][keep]

    return TrainingRows(blocks, scaling(blocks))


class ParquetBlocks:
    """Blocks of a Parquet file, one row group at a time, for `AbductiveRegressor.fit_blocks`.

    Parameters
    ----------
    path : str or Path
    inputs : list of str
        Input columns.
    output : str
        Target column.
    weight : str, optional
        Column of weights.
    """

    def __init__(self, path: str | Path, inputs: list[str], output: str, weight: str | None = None) -> None:
        self.path, self.inputs, self.output, self.weight = path, inputs, output, weight

    def __iter__(self) -> Iterator[tuple[np.ndarray, ...]]:
        import pyarrow.parquet as pq

        wanted = [*self.inputs, self.output, *([self.weight] if self.weight else [])]
        with pq.ParquetFile(self.path) as file:
            missing = [name for name in wanted if name not in file.schema_arrow.names]
            if missing:
                raise InputError(f"{self.path}: no column {missing[0]!r}; the file has {file.schema_arrow.names}")
            for group in range(file.num_row_groups):
                table = file.read_row_group(group, columns=wanted)
                columns = {name: table.column(name).to_numpy() for name in wanted}
                X = np.column_stack([columns[name] for name in self.inputs])
                parts = (X, columns[self.output])
                yield (*parts, columns[self.weight]) if self.weight else parts


def scaling(blocks: Callable[[], Iterator[Block]]) -> Scaling:
    """Statistics in one pass; means and spreads of blocks are merged, so that no large sums cancel."""
    weight, mean, square, n_row, lightest, heaviest = 0.0, np.zeros(0), np.zeros(0), 0, np.inf, 0.0
    low, high = np.zeros(0), np.zeros(0)
    with np.errstate(over="ignore", invalid="ignore"):
        for x, y, w in blocks():
            if mean.size and x.shape[1] + 1 != mean.size:
                raise InputError(f"a block has {x.shape[1]} inputs, those before it have {mean.size - 1}")
            v = np.column_stack([x, y])
            total = float(len(v) if w is None else w.sum())
            n_row += len(v)
            if w is not None:
                lightest = min(lightest, float(w.min(where=w > 0.0, initial=np.inf)))
                heaviest = max(heaviest, float(w.max()))
            block_mean = (v.sum(axis=0) if w is None else w @ v) / total
            squares = (v - block_mean) ** 2
            block_square = squares.sum(axis=0) if w is None else w @ squares
            if not mean.size:
                weight, mean, square = total, block_mean, block_square
                low, high = v.min(axis=0), v.max(axis=0)
                continue
            shift = block_mean - mean
            square += block_square + shift * shift * (weight * total / (weight + total))
            mean = mean + shift * (total / (weight + total))
            weight += total
            low, high = np.minimum(low, v.min(axis=0)), np.maximum(high, v.max(axis=0))
    if not mean.size:
        raise InputError("there are no rows to learn from")
    if not 0.0 < weight <= _HEAVIEST:
        raise InputError(
            f"the weights sum to {weight:g}: a weight acts like that many repetitions of its row; divide the weights by "
            "their mean to weigh rows against each other"
        )
    check_span(lightest, heaviest)
    if SMALLEST <= weight < _LIGHT * n_row:
        warnings.warn(
            f"the weights of {n_row} rows sum to {weight:g}: a weight acts like that many repetitions of its row, and so few rows teach "
            "little; divide the weights by their mean to weigh rows against each other",
            stacklevel=2,
        )
    if not np.all(np.isfinite(mean)):
        raise InputError("the values are too large for their sums to be numbers: scale the columns")
    constant = constant_columns(low, high, mean, [*(f"input {place}" for place in range(len(mean) - 1)), "the target"])
    mean = np.where(constant, low, mean) + 0.0  # no negative zeros in files
    spread = np.where(constant, 1.0, np.sqrt(square / weight))
    lost = ~constant & (spread * spread < _LEAST)
    if lost.any():
        spread[lost] = _small_spread(blocks, weight, mean[lost], (high - low)[lost], lost)
    if not np.all(np.isfinite([*mean, *(spread * spread)])):
        raise InputError("the values are too large for their squares to be numbers: scale the columns")
    check_narrow(spread)
    return Scaling(
        weight, mean[:-1], spread[:-1], low[:-1], high[:-1],
        float(mean[-1]), float(spread[-1]), float(low[-1]), float(high[-1]), n_row,
    )  # fmt: skip


def constant_columns(low: np.ndarray, high: np.ndarray, mean: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Which columns vary by no more than rounding, (n_column,) array of bool; warns of those that were signals before they were rounded."""
    constant: np.ndarray = (high - low <= _CONSTANT * np.abs(mean)) | (high <= low)
    # a constant that was computed may differ in its last digit; more than that was a signal before it was rounded
    for place in np.flatnonzero(constant & (high - low > 1.5 * np.spacing(np.abs(mean)))).tolist():
        warnings.warn(
            f"{names[place]} varies by {high[place] - low[place]:g} about {mean[place]:g}, which is no more than rounding: it counts as "
            "constant; subtract the offset before it is rounded",
            stacklevel=3,
        )
    return constant


def check_narrow(spread: np.ndarray) -> None:
    """Refuse columns that vary so little that the inverse of it may be no number."""
    if np.any(spread < np.finfo(np.float64).smallest_normal):
        raise InputError(
            "a column varies by less than 2.2e-308, the smallest number with all its digits: scale the columns"
        )


def check_span(lightest: float, heaviest: float) -> None:
    """Refuse weights of which the smallest does not count beside the largest."""
    if not heaviest <= _HEAVIEST * lightest:
        raise InputError(
            f"the weights reach from {lightest:g} to {heaviest:g}: beside a weight that is {_HEAVIEST:g} times as large one does not count; "
            "give these rows the weight 0, which leaves them out, or a larger one"
        )


def _small_spread(
    blocks: Callable[[], Iterator[Block]], weight: float, mean: np.ndarray, width: np.ndarray, which: np.ndarray
) -> np.ndarray:
    """Spread of the columns (the target is the last) whose squares are too small, from squares in units of their width."""
    square = np.zeros(width.size)
    for x, y, w in blocks():
        squares = ((np.column_stack([x, y])[:, which] - mean) / width) ** 2
        square += squares.sum(axis=0) if w is None else w @ squares
    found: np.ndarray = width * np.sqrt(square / weight)
    return found
