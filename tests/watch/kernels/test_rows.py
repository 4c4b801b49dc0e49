"""Rows fill a block; gaps, other rasters and what is no number are told apart."""

import numpy as np

from polydraulic.watch.kernels.rows import (
    FULL,
    MOST_GAPS,
    NEVER_APART,
    NO_NUMBER,
    OTHER_RASTER,
    TAKEN,
    keep_rows,
    take_row,
)

RASTER, N = 0.1, 5


def taken(times, values=(1.0, 2.0)):
    rows, counts = np.zeros(3 * N), np.zeros(2, dtype=np.int64)
    return [take_row(t, np.array(values), N, rows, 0, counts, RASTER) for t in times], rows.reshape(N, 3), counts


def test_a_block_fills_and_the_next_one_keeps_what_it_needs():
    became, rows, counts = taken(np.arange(N) * RASTER)
    assert became == [TAKEN] * (N - 1) + [FULL]
    assert np.array_equal(rows[:, 0], np.arange(N) * RASTER)
    assert np.all(rows[:, 1:] == [1.0, 2.0])
    keep_rows(rows.ravel(), 0, N, 2, 3, counts)
    assert rows[0, 0] == 2 * RASTER
    assert counts.tolist() == [N - 2, 0]


def test_a_gap_begins_a_new_block():
    became, rows, counts = taken([0.0, 0.1, 0.2, 1.0, 1.1])
    assert became == [TAKEN] * 5
    assert rows[0, 0] == 1.0
    assert counts.tolist() == [2, 0]


def test_what_cannot_be_taken_is_told():
    assert taken([0.0], (np.nan, 1.0))[0] == taken([np.inf])[0] == taken([0.0], (1.0, -np.inf))[0] == [NO_NUMBER]
    assert taken(np.arange(N) * 0.5 * RASTER)[0][-1] == OTHER_RASTER
    assert taken(np.arange(MOST_GAPS + 2) * 2.0 * RASTER)[0][-2:] == [TAKEN, NEVER_APART]
