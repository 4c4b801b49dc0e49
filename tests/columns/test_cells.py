import numpy as np
import pyarrow as pa
import pytest

from polydraulic.columns.cells import numbers


@pytest.mark.parametrize(
    ("column", "values", "bad"),
    [
        (pa.array([1, None, 3]), [1.0, np.nan, 3.0], []),
        (pa.array([True, False]), [1.0, 0.0], []),
        (pa.array([" 1.5", "", "n/a", "2e3 "]), [1.5, np.nan, np.nan, 2000.0], []),
        (pa.array(["1", "open", None, "4"]), [1.0, np.nan, np.nan, 4.0], [1]),
        (pa.array(["\u20131.5", "\u22122", "3.5-", "7-", "4"]), [-1.5, -2.0, -3.5, -7.0, 4.0], []),
        (pa.array(["-7-", "1\u20132", "1\u2009234.5", "-"]), [np.nan, np.nan, 1234.5, np.nan], [0, 1]),
        (pa.array(["2", "1", "2"]).dictionary_encode(), [2.0, 1.0, 2.0], []),
        (pa.chunked_array([[1.0], [2.0, None]]), [1.0, 2.0, np.nan], []),
        (pa.array([[1.0], [2.0]]), [np.nan, np.nan], [0, 1]),
    ],
)
def test_numbers_of_any_kind(column, values, bad):
    found, places = numbers(column)
    assert np.array_equal(found, values, equal_nan=True)
    assert places.tolist() == bad


def test_times_of_every_type_are_seconds():
    stamps = pa.array(["2024-01-01 12:00:00.000", "2024-01-01 12:00:00.250"]).cast(pa.timestamp("ms"))
    for column in (
        stamps,
        stamps.cast(pa.timestamp("us")),
        stamps.cast(pa.time32("ms")),
        pa.array([10, 260], pa.duration("ms")),
    ):
        found, places = numbers(column)
        assert np.diff(found) == pytest.approx([0.25], abs=1e-6)
        assert places.size == 0
    assert numbers(pa.array([19723], pa.date32()))[0] == pytest.approx([1704067200.0])


def test_whole_numbers_above_2_53_are_rounded_and_the_outermost_are_none():
    limits = np.iinfo(np.int64)
    found, places = numbers(pa.array([2**53 + 1, limits.min, limits.max, -5, None], pa.int64()))
    assert found[:1] == pytest.approx([2.0**53], rel=1e-15)
    assert found[3] == -5.0
    assert np.isnan(found[[1, 2, 4]]).all()
    assert places.tolist() == [1, 2]
    assert numbers(pa.array([7, 2**64 - 1], pa.uint64()))[1].tolist() == [1]
