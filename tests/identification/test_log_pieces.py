"""Logs on an even raster."""

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.identification.log_pieces import (
    even_pieces,
    in_si,
    raster_of,
    raster_segments,
    segment_column,
    weighted_sums,
)
from polydraulic.tables import Table


def table_of(time, **more):
    return Table({"time": time, "x": 2.0 * time, **more}, {"time": "s", "x": "m"})


def test_gaps_and_segments_end_a_piece():
    time = np.arange(500) * 0.02
    kept = (time < 6.0) | (time > 6.5)
    pieces = even_pieces(table_of(time[kept], segment=np.where(time[kept] < 3.0, 0.0, 1.0)), ["x"])
    assert [round(float(at[-1] - at[0]), 2) for at, _ in pieces] == [2.98, 2.98, 3.46]


@pytest.mark.parametrize(("step", "pieces"), [(1.49, 1), (1.51, 2)])
def test_rows_more_than_one_and_a_half_rasters_apart_end_a_piece(step, pieces):
    time = 0.1 * np.cumsum([0.0, *[1.0] * 9, step, *[1.0] * 9])
    assert len(even_pieces(table_of(time), ["x"])) == pieces


def test_an_uneven_clock_becomes_even():
    time = np.arange(200) * 0.02 + np.random.default_rng(0).uniform(0.0, 0.004, 200)
    ((at, values),) = even_pieces(table_of(time), ["x"])
    assert np.ptp(np.diff(at)) < 1e-12
    assert np.allclose(values[:, 0], 2.0 * at)


def test_times_that_fall_and_other_units_are_refused():
    with pytest.raises(
        InputError, match="does not rise from row to row: 2 s is followed by 1 s in row 3, and so in 1 of 3"
    ):
        raster_of(table_of(np.array([0.0, 2.0, 1.0])))
    with pytest.raises(InputError, match="column 'x' is in 'm'.*this in 'rad'"):
        in_si(table_of(np.arange(3.0)), {"x": "rad"})


def test_the_raster_is_that_within_segments():
    ends = table_of(np.array([0.0, 0.1, 5.0, 5.1, 9.0]), segment=np.array([0.0, 0.0, 1.0, 1.0, 2.0]))
    assert raster_of(ends) == pytest.approx(0.1)
    with pytest.raises(InputError, match="no two rows of the log follow each other"):
        raster_of(table_of(np.array([0.0, 0.1]), segment=np.array([0.0, 1.0])))


def test_missing_values_of_what_is_needed_end_a_piece_and_others_stay_missing():
    nan, time = np.nan, np.arange(10.0)
    x = np.where(np.isin(time, [4.0]), nan, time)
    y = np.where(np.isin(time, [2.0, 8.0]), nan, time)
    table = table_of(time, x=x, y=y).partial()
    (first, a), (second, b) = even_pieces(table, ["x"], ["y"])
    assert first.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert second.tolist() == [5.0, 6.0, 7.0, 8.0, 9.0]
    assert np.array_equal(a[:, 1], [0.0, 1.0, nan, 3.0], equal_nan=True)
    assert np.array_equal(b[:, 1], [5.0, 6.0, 7.0, nan, 9.0], equal_nan=True)
    assert len(even_pieces(table, ["x", "y"])) == 4
    with pytest.raises(InputError, match="no row of the log has a value of all of z"):
        even_pieces(table_of(time, z=np.full(10, nan)).partial(), ["z"])


def test_weighted_sums_are_of_whole_stretches():
    values = np.arange(10.0).reshape(5, 2)
    assert weighted_sums(values, np.array([0.5, 0.0, 0.5])).tolist() == [[2.0, 3.0], [4.0, 5.0], [6.0, 7.0]]


def test_stretches_end_at_gaps_and_at_ends_of_segments():
    time = np.array([0.0, 0.1, 0.2, 0.5, 0.6, 0.7])
    assert raster_segments(Table({"time": time}, {})).tolist() == [0, 0, 0, 1, 1, 1]
    both = Table({"time": time, "segment": np.array([0.0, 0.0, 0.0, 0.0, 3.0, 3.0])}, {})
    assert raster_segments(both).tolist() == [0, 0, 0, 1, 2, 2]
    assert segment_column(both).tolist() == [0.0, 0.0, 0.0, 0.0, 3.0, 3.0]
    assert segment_column(Table({"time": time}, {})).tolist() == [0.0] * 6
