import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.measure.checks.clock import Clock, day_zero
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
    assert {f.channel for f in findings} <= {"time"}
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


@pytest.mark.parametrize("blocks", [1, 7])
def test_a_log_without_a_clock_counts_rows(blocks):
    kept, _, findings, _ = checked(STEADY, interval=0.5, blocks=blocks)
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


@pytest.mark.parametrize(("lost", "gap"), [(2.45, []), (2.55, [51])])
def test_a_gap_is_longer_than_two_and_a_half_rasters(lost, gap):
    time = np.where(np.arange(100) < 50, STEADY, STEADY + 0.01 * (lost - 1.0))
    _, gaps, findings, clock = checked(time)
    assert gaps == gap
    assert clock.lost == pytest.approx(0.01 * lost if gap else 0.0)
    assert "gap" in dict(findings) or not gap


@pytest.mark.parametrize(("share", "kinds"), [(0.24, []), (0.26, ["irregular"])])
def test_an_interval_is_irregular_beyond_a_quarter_of_the_usual_one(share, kinds):
    steps = 0.01 * (1.0 + share * np.resize([0.0, 1.0, 0.0, -1.0], 200))
    assert [kind for kind, _ in checked(np.cumsum(steps))[2]] == kinds


@pytest.mark.parametrize(("n", "odd", "named"), [(401, 5, False), (401, 6, True), (2001, 20, False), (2001, 21, True)])
def test_a_hundredth_of_the_intervals_may_be_irregular_and_five_in_any_case(n, odd, named):
    steps = np.full(n, 0.01)
    steps[10 : 10 + 4 * odd : 4] = 0.015
    _, _, findings, clock = checked(np.cumsum(steps))
    assert dict(findings) == ({"irregular": [(r, r) for r in range(11, 11 + 4 * min(odd, 20), 4)]} if named else {})
    if named:
        (found,) = clock.findings
        assert (found.count, found.detail) == (odd, "usual interval 0.01 s")


@pytest.mark.parametrize(("off", "named"), [(0.19, False), (0.21, True), (-0.19, False), (-0.21, True)])
def test_a_raster_is_another_beyond_a_fifth_of_that_of_the_map(off, named):
    *_, clock = checked((1.0 + off) * STEADY, raster=0.01)
    assert [f.kind for f in clock.findings] == ["raster"] * named
    for found in clock.findings:
        assert found.detail.startswith(f"found {0.01 * (1.0 + off):.4g} s, the map says 0.01 s: check")


DAY, BORN, END = 86_400.0, 315_532_800.0, 4_102_444_800.0  # 1980 and 2100


@pytest.mark.parametrize(
    ("times", "named"),
    [
        ([-DAY, 0.0], []),
        ([-DAY - 1.0, 0.0], [(1, 1)]),
        ([BORN, BORN + 1.0], []),  # a clock that shows no date: s since it began
        ([BORN - 1.0, BORN, BORN], []),
        ([BORN - 1.0, BORN + 1.0, BORN + 2.0], [(1, 1)]),
        ([BORN, BORN + 1.0, 1.7e9], []),
        ([1.7e9, END], []),
        ([1.7e9, END + 1.0], [(2, 2)]),
        ([0.0, END + 1.0], [(2, 2)]),
    ],
)
def test_dates_lie_between_1980_and_2100_and_other_clocks_begin_at_most_a_day_early(times, named):
    assert dict(checked(times)[2]).get("impossible time", []) == named


@pytest.mark.parametrize(("far", "kept"), [(0.99e12, 2), (1.01e12, 1)])
def test_times_beyond_any_calendar_are_left_out(far, kept):
    assert len(checked([1.7e9, far])[0]) == kept


def test_a_clock_that_shows_dates_is_held_to_them_in_every_block():
    findings = Findings()
    clock = Clock("time", 1.0, None, None, findings, dates=True)
    list(clock.rows(iter([LogBlock(np.arange(1, 4), np.array([5.0, 6.0, 7.0]), {}, {}, 1.0)])))
    assert [(f.kind, f.rows) for f in findings] == [("impossible time", [(1, 3)])]


def test_gaps_are_counted_and_added_up():
    time = np.where(np.arange(100) < 30, STEADY, STEADY + 0.05) + np.where(np.arange(100) < 60, 0.0, 0.1)
    _, gaps, findings, clock = checked(time, blocks=4)
    assert (gaps, findings) == ([31, 61], [("gap", [(31, 31), (61, 61)])])
    (found,) = clock.findings
    assert found.detail == "2 gap(s), 0.17 s in all; the row after each is named"


def test_texts_keep_their_rows_when_rows_are_left_out():
    time = np.array([0.0, 1.0, np.nan, 3.0, 4.0, 5.0])
    text = np.arange(6)
    for ends in ((6,), (2, 6), (3, 5, 6)):
        clock, begins = Clock("time", 1.0, None, None, Findings()), (0, *ends[:-1])
        blocks = [
            LogBlock(
                text[a:b] + 1,
                time[a:b],
                {"p": 2.0 * text[a:b]},
                {"p": np.flatnonzero(np.isin(text[a:b], [2, 4]))},
                b / 6,
            )
            for a, b in zip(begins, ends, strict=True)
        ]
        parts = list(clock.rows(iter(blocks)))
        assert np.concatenate([part.rows[part.text["p"]] for part in parts]).tolist() == [5]
        assert np.concatenate([part.values["p"] for part in parts]).tolist() == [0.0, 2.0, 6.0, 8.0, 10.0]
        assert parts[-1].done == 1.0
        assert (clock.first, clock.last, clock.raster) == (0.0, 5.0, 1.0)


def test_a_block_may_be_empty():
    none = LogBlock(np.arange(0), np.zeros(0), {"p": np.zeros(0)}, {"p": np.arange(0)}, 0.5)
    some = [
        LogBlock(np.arange(n, n + 2), np.arange(n, n + 2.0), {"p": np.ones(2)}, {"p": np.arange(0)}, 1.0)
        for n in (1, 3)
    ]
    found = list(Clock("time", 1.0, None, None, Findings()).rows(iter([none, some[0], none, some[1]])))
    assert np.concatenate([part.time for part in found]).tolist() == [1.0, 2.0, 3.0, 4.0]
    assert all(len(part.rows) for part in found)
    assert list(Clock("time", 1.0, None, None, Findings()).rows(iter([none]))) == []


@pytest.mark.parametrize("blocks", [1, 2, 9])
def test_every_jump_is_named(blocks):
    time = STEADY.copy()
    time[[30, 60, 80]] = 0.1
    assert checked(time, blocks=blocks)[2] == [("clock jump", [(31, 31), (61, 61), (81, 81)])]


@pytest.mark.parametrize("blocks", [1, 3, 40])
def test_the_first_twenty_irregular_intervals_are_shown(blocks):
    steps = np.full(1000, 0.01)
    steps[10:122:4] = 0.015
    _, _, findings, clock = checked(np.cumsum(steps), blocks=blocks)
    assert findings == [("irregular", [(row, row) for row in range(11, 91, 4)])]
    assert [found.count for found in clock.findings] == [28]


def test_days_count_from_the_zero_of_their_calendar():
    day = 19_813.5  # since 1970, of 2024
    for zero in (0.0, 25_569.0, 719_529.0, 2_440_587.5):
        assert day_zero(day + zero) == zero
        kept, _, findings, _ = checked(day + zero + STEADY / 86_400.0, factor=86_400.0)
        assert kept == pytest.approx(day * 86_400.0 + STEADY, abs=1e-4)
        assert [kind for kind, _ in findings if kind != "irregular"] == []
    for none in (-1.0, 0.5, 99.0, 100_000.0, 1e7):
        assert day_zero(none) == 0.0


@pytest.mark.parametrize("zero", [25_569.0, 719_529.0, 2_440_587.5])
@pytest.mark.parametrize(("day", "known"), [(3651.0, False), (3652.0, True), (47_482.0, True), (47_483.0, False)])
def test_days_of_a_calendar_lie_between_1980_and_2100(zero, day, known):
    assert day_zero(zero + day) == (zero if known else 0.0)


@pytest.mark.parametrize(("raster", "named"), [(5.0, False), (5.01, True), (2e-5, False), (1.99e-5, True)])
def test_rows_that_come_five_hundred_times_less_or_more_often_than_those_of_the_table_are_in_another_unit(
    raster, named
):
    for declared in (None, raster):
        *_, clock = checked(raster * np.arange(20), raster=declared)
        clock.raster = raster  # as the map says it, without the rounding of sums
        clock.compare_table(0.01)
        assert [(f.kind, f.detail) for f in clock.findings] == [
            ("raster", f"found {raster:.4g} s, the table has a row every 0.01 s: check the unit of time")
        ] * (named and declared is None)


@pytest.mark.parametrize(("every", "refused"), [(99.0, False), (101.0, True)])
def test_ten_thousand_rows_from_one_sample_to_the_next_are_refused(every, refused):
    for declared in (None, every):
        *_, clock = checked(every * np.arange(5), raster=declared)
        if refused and declared is None:
            with pytest.raises(
                InputError, match="raster = 0.01 s: samples come every 101 s, .* 10100 rows from one to"
            ):
                clock.check_table(0.01)
        else:
            clock.check_table(0.01)


def test_a_clock_that_ticks_more_slowly_than_rows_come_is_named():
    _, _, findings, clock = checked(np.floor(STEADY / 0.1))
    assert [kind for kind, _ in findings] == ["time repeats"]
    assert "interval between rows" in str(next(iter(clock.findings)))
    _, _, _, clock = checked(np.repeat(STEADY, 2)[:-1])
    assert "interval between rows" not in str(next(iter(clock.findings)))


@pytest.mark.parametrize("blocks", [1, 3, 50])
@pytest.mark.parametrize(
    ("size", "step", "factor"), [(2**16, 400, 1e-3), (2**32, 10_000, 1e-6), (2**32 / 1e6, 0.01, 1.0)]
)
def test_a_counter_that_runs_over_goes_on(blocks, size, step, factor):
    true = 0.999 * size + step * np.arange(300.0 if step == 400 else 1000.0)
    read = np.round(np.mod(true, size), 6)
    kept, gaps, findings, _ = checked(read, blocks=blocks, factor=factor)
    assert kept == pytest.approx(true * factor, rel=1e-9)
    anew = np.flatnonzero(np.diff(read) < 0.0) + 2
    assert anew.size
    assert (gaps, findings) == ([], [("counter", [(row, row) for row in anew.tolist()])])


@pytest.mark.parametrize("blocks", [1, 3])
def test_what_to_do_about_times_that_begin_anew_or_fall_is_said(blocks):
    def said(time):
        return checked(time, blocks=blocks)[3].findings.of("overlap")[0].detail

    twice = said(np.concatenate([STEADY, STEADY[:50]]))
    assert twice.startswith(
        "in row 101 the time falls from 0.99 to 0 s; if recordings were put one behind the other, cut"
    )
    assert said(STEADY[::-1]).endswith("times fall from row to row: turn the rows of the log round, the last one first")


@pytest.mark.parametrize(("begin", "named"), [(135_958.5, True), (5_958.5, True), (135_958.5 + 7.0, False)])
def test_times_of_day_in_one_number_are_told_by_their_gaps(begin, named):
    second = 0.01 * np.arange(300)
    time = begin + second + np.where(second >= 1.5, 40.0 + 4000.0 * (begin < 6000.0), 0.0)
    (gap,) = checked(time)[3].findings.of("gap")
    assert gap.rows == [(151, 151)]
    assert ("are no seconds; write 13:59:59" in gap.detail) == named
