"""A test that an exported watch brings along: rows of no machine, and a digest of what the package knew after each block of them."""

from collections.abc import Sequence

import numpy as np

from polydraulic.export.watch.texts import number_lines
from polydraulic.watch.kernels.numbers import HEAD_OF_LIVE
from polydraulic.watch.watch import FaultWatch
from polydraulic.watch.watched import Watched

_BLOCKS, _HELD = 40, 10  # how many, and after how many of them the first sensor stays at what it reads
_PERIODS = (3.0, 9.0)  # s, of the waves that sensors read
_FIRST, _PRIME, _MASK = 14695981039346656037, 1099511628211, 2**64 - 1  # of the digest by Fowler, Noll and Vo


def self_test_texts(watch: FaultWatch) -> dict[str, str]:
    """What a self-test of the C of a watch is filled with: rows and digests."""
    of = watch.of
    middle, half = np.array([_range_of(of, column) for column in of.columns]).T
    periods = np.linspace(*_PERIODS, len(of.columns))
    rates = np.round(65536.0 * of.shape.raster / periods).astype(np.int64)
    n_rows, held = of.shape.rows + (_BLOCKS - 1) * of.shape.inside, _HELD * of.shape.inside
    digests = _digests(watch, _rows(middle, half, rates, n_rows, held))
    return {
        "middle": number_lines(middle.tolist()),
        "half": number_lines(half.tolist()),
        "rate": number_lines(rates.tolist()),
        "digests": ",\n    ".join(f"UINT64_C({digest})" for digest in digests),
        "n_blocks": str(len(digests)),
        "n_rows": str(n_rows),
        "held": str(held),
        "n_head": str(HEAD_OF_LIVE),
        "n_sums": str(3 * len(of.directions)),
    }


def _range_of(of: Watched, column: str) -> tuple[float, float]:
    """Middle and half of a range that a sensor may read, SI."""
    name, _, what = column.rpartition(".")
    pump = next(c.pump for c in of.machine.circuits if name == c.name or name in c.functions)
    if what in ("p_a", "p_b", "p_pump"):
        return 0.4 * pump.relief, 0.3 * pump.relief
    if what in ("q_in", "q_out"):
        return 0.5 * pump.flow, 0.4 * pump.flow
    f = of.machine.function(name)
    travel, stops = 0.8 * f.valve.knots[-1], f.stops
    if what in ("spool", "voltage"):
        return 0.0, travel if what == "spool" else travel / f.pilot.gain
    return 0.5 * (stops.low + stops.high), 0.3 * (stops.high - stops.low)


def _rows(middle: np.ndarray, half: np.ndarray, rates: np.ndarray, n_rows: int, held: int) -> np.ndarray:
    """Waves of straight lines, (n_row, n_column), in the order of operations of the C."""
    at = np.tile(np.arange(n_rows)[:, None], (1, len(rates)))
    at[:, 0] = np.minimum(at[:, 0], held)
    wave = np.abs(((at * rates) & 65535) / 32768.0 - 1.0)
    return np.asarray(middle + half * (2.0 * wave - 1.0))


def _digests(watch: FaultWatch, rows: np.ndarray) -> list[int]:
    """What the package knows after each block."""
    fresh = FaultWatch(watch.of, watch.expected, watch.rate, watch.networks)
    judge, of = fresh.judge_parts, fresh.judge_parts.numbers
    sums, chances = (
        slice(of.at_sums, of.at_sums + 3 * of.directions),
        slice(of.at_chances, of.at_chances + of.directions),
    )
    found = []
    for k, row in enumerate(rows):
        blocks = fresh.blocks
        fresh.update(k * watch.of.shape.raster, row)
        if fresh.blocks > blocks:
            parts = (judge.live[:HEAD_OF_LIVE], judge.live[sums], judge.live[chances], judge.marks)
            found.append(_digest(np.concatenate([part.view(np.uint64) for part in parts]).tolist()))
    return found


def _digest(words: Sequence[int]) -> int:
    digest = _FIRST
    for word in words:
        digest = ((digest ^ word) * _PRIME) & _MASK
    return digest
