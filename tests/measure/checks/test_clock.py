import numpy as np
import pytest

from polydraulic.measure.checks.clock import Clock
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import LogBlock


def checked(time, *, blocks=1, factor=1.0, raster=None, interval=None):
    """Times that are kept, rows after a gap, and findings as (kind, rows)."""
    findings = Findings()
    clock = Clock("time", factor, raster, interval, findings)
    rows = np.arange(len(time)) + 1
    parts = [
        LogBlock(r, None if interval else t, {"a": 10.0 * r}, {"a": np.zeros(0, dtype=int)}, 1.0)
        for t, r in zip(
            np.array_split(np.asarray(time, dtype=float), blocks), np.array_split(rows, blocks), strict=True
        )
    ]
    found = list(clock.rows(iter(parts)))
    kept = np.concatenate([part.time for part in found])
    assert np.array_equal(
        np.concatenate([part.values["a"] for part in found]), 10.0 * np.concatenate([p.rows for p in found])
    )
    gaps = np.concatenate([part.rows[part.after_gap] for part in found])
    return kept, gaps.tolist(), [(f.kind, f.rows) for f in findings], clock


STEADY = np.arange(100) * 0.01


@pytest.mark.parametrize("blocks", [1, 3, 50])
def test_steady_times_raise_nothing(blocks):
    kept, gaps, findings, clock = checked(STEADY, blocks=blocks)
    assert np.array_equal(kept, STEADY)
    assert (gaps, findings) == ([], [])
    assert clock.raster == pytest.approx(0.01)


@pytest.mark.parametrize("blocks", [1, 7, 50])
def test_what_is_wrong_is_named_with_its_rows_in_any_blocks(blocks):
    ahead, back, twice, over = STEADY.copy(), STEADY.copy(), STEADY.copy(), STEADY.copy()
    ahead[40], back[40], twice[40], over[40:] = 5.0, 0.1, STEADY[39], STEADY[40:] - 0.045
    for time, finding, n in (
        (ahead, ("clock jump", [(41, 41)]), 99),
        (back, ("clock jump", [(41, 41)]), 99),
        (twice, ("time repeats", [(41, 41)]), 99),
        (np.where(np.arange(100) == 40, np.nan, STEADY), ("no time", [(41, 41)]), 99),
    ):
        kept, gaps, findings, _ = checked(time, blocks=blocks)
        assert (len(kept), gaps, findings) == (n, [], [finding])
        assert np.all(np.diff(kept) > 0.0)
    kept, _, findings, _ = checked(over, blocks=blocks)
    assert np.all(np.diff(kept) > 0.0)
    assert findings == [("overlap", [(41, 44)])]


@pytest.mark.parametrize("blocks", range(1, 31))
def test_where_blocks_end_changes_no_name(blocks):
    over, back, last = STEADY.copy(), STEADY.copy(), STEADY.copy()
    over[57:] -= 0.035
    back[57], last[-1] = 0.1, 0.1
    for time, finding in (
        (over, ("overlap", [(58, 60)])),
        (back, ("clock jump", [(58, 58)])),
        (last, ("clock jump", [(100, 100)])),
    ):
        assert checked(time, blocks=blocks)[2] == [finding]


def test_samples_are_apart_up_to_two_and_a_half_rasters():
    for lost, expected in ((1, []), (2, [51])):
        kept, gaps, findings, clock = checked(np.delete(STEADY, slice(50, 50 + lost)))
        assert gaps == expected
        assert [kind for kind, _ in findings] == ["gap"] * len(expected)
        assert clock.gaps == len(expected)
        assert len(kept) == 100 - lost


def test_intervals_that_differ_by_more_than_a_quarter_are_irregular():
    rng = np.random.default_rng(0)
    for spread, expected in ((0.1, []), (0.4, ["irregular"])):
        steps = 0.01 * (1.0 + spread * rng.choice([-1.0, 0.0, 0.0, 1.0], 1000))
        assert [kind for kind, _ in checked(np.cumsum(steps))[2]] == expected


def test_times_are_in_the_unit_of_the_log_and_compared_with_the_map():
    kept, _, findings, _ = checked(1000.0 * STEADY, factor=1e-3, raster=0.01)
    assert kept == pytest.approx(STEADY)
    assert findings == []
    assert [kind for kind, _ in checked(STEADY, raster=0.02)[2]] == ["raster"]


def test_a_log_without_a_clock_counts_rows():
    kept, _, findings, _ = checked(STEADY, interval=0.5)
    assert kept == pytest.approx(0.5 * np.arange(100))
    assert findings == []


@pytest.mark.parametrize(
    ("begin", "factor", "named"),
    [
        (0.0, 1.0, False),
        (-5.0, 1.0, False),
        (1.7e9, 1.0, False),
        (-5e8, 1.0, True),
        (1.7e18, 1.0, True),
        (1.7e12, 1e-3, False),
    ],
)
def test_times_that_cannot_be_are_named(begin, factor, named):
    times = begin + STEADY / factor
    if begin > 1e17:  # beyond any calendar: left out, so that one that can be is wanted
        times[0] = 0.0
    kept, _, findings, _ = checked(times, factor=factor)
    assert ("impossible time" in dict(findings)) == named
    assert len(kept) == (1 if begin > 1e17 else 100)


def test_rows_from_before_a_clock_was_set_are_named():
    found = dict(checked(np.concatenate([STEADY[:10], 1.7e9 + STEADY]))[2])
    assert found["impossible time"] == [(1, 10)]
