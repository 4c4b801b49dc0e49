"""Local clocks that pass midnight or are changed by an hour, in blocks of any size."""

import numpy as np
import pytest

from polydraulic.columns.local_clock import LocalClock

TRUE = 86_000.0 + np.arange(1000.0)


class Notes:
    def __init__(self):
        self.rows = {}

    def add(self, kind, channel="", detail=""):
        raise AssertionError(kind)

    def add_rows(self, kind, channel, rows, detail=""):
        if rows.size:
            self.rows.setdefault(kind, []).extend(rows.tolist())


def went_on(given, of_day, blocks):
    notes = Notes()
    clock = LocalClock("t", of_day, notes)
    numbers = np.arange(len(given)) + 1
    parts = zip(np.array_split(given, blocks), np.array_split(numbers, blocks), strict=True)
    return np.concatenate([clock.times(t, rows) for t, rows in parts]), notes.rows


@pytest.mark.parametrize("blocks", [1, 3, 1000])
def test_times_of_day_go_on_after_midnight(blocks):
    found, rows = went_on(TRUE % 86400.0, True, blocks)
    assert np.array_equal(found, TRUE)
    assert rows == {"midnight": [401]}


@pytest.mark.parametrize("blocks", [1, 3])
def test_a_night_without_rows_is_a_gap_of_hours(blocks):
    evening, morning = 61_200.0 + np.arange(10.0), 25_200.0 + np.arange(10.0)
    found, rows = went_on(np.concatenate([evening, morning]), True, blocks)
    assert found[10:] == pytest.approx(morning + 86400.0)
    assert rows == {"midnight": [11]}


@pytest.mark.parametrize("blocks", [1, 3])
def test_a_clock_set_back_by_an_hour_goes_on(blocks):
    given = np.where(np.arange(1000) < 500, TRUE, TRUE - 3600.0)
    found, rows = went_on(given, False, blocks)
    assert np.array_equal(found, TRUE)
    assert rows == {"clock change": [501]}


def test_a_clock_set_ahead_is_named_and_stays_a_gap():
    given = np.where(np.arange(1000) < 500, TRUE, TRUE + 3600.0)
    found, rows = went_on(given, False, 1)
    assert np.array_equal(found, given)
    assert rows == {"clock change": [501]}


def test_single_rows_that_are_off_change_nothing():
    given = TRUE.copy()
    given[[100, 300]] = [10.0, np.nan]
    given[200] -= 3600.0
    found, rows = went_on(given, True, 1)
    assert np.array_equal(found, given, equal_nan=True)
    assert rows == {}


@pytest.mark.parametrize("blocks", [1, 3, 1000])
@pytest.mark.parametrize("day", [0.0, 1.7e9 // 86400.0 * 86400.0])
def test_a_clock_of_twelve_hours_goes_on_after_one(blocks, day):
    true = day + 46_400.0 + np.arange(1000.0)  # 12:53 in the afternoon
    given = np.where(true < day + 46_800.0, true, true - 43_200.0)
    found, rows = went_on(given, day == 0.0, blocks)
    assert np.array_equal(found, true)
    assert rows == {"twelve hours": [401]}
