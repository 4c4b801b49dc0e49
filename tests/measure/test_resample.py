"""Rows on one raster: where channels are known, and nowhere else."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.measure.checks.channel_check import Samples
from polydraulic.measure.resample import Resampler


def rows(raster, channels, cuts=(np.inf,), partial=False):
    """Time, segment and values of `channels` (time, value, raster, between), given in parts up to `cuts`."""
    maker = Resampler(raster, [between for *_, between in channels], partial=partial)
    found, begin = [], -np.inf
    for end in cuts:
        for track, (time, value, own, _) in zip(maker.tracks, channels, strict=True):
            part = (time >= begin) & (time < end)
            track.add(Samples(time[part], value[part]), own)
        begin = end
        reach = max(track.reach for track in maker.tracks)
        found += list(maker.rows(end - reach if np.isfinite(end) else np.inf))
    if not found:
        return np.zeros(0), np.zeros(0), [np.zeros(0)] * len(channels)
    return (
        np.concatenate([t for t, _, _ in found]),
        np.concatenate([s for _, s, _ in found]),
        [np.concatenate(c) for c in zip(*(c for _, _, c in found), strict=True)],
    )


def test_a_line_stays_a_line_and_a_held_value_is_held():
    a, b = np.arange(0.0, 1.001, 0.05), np.arange(0.0, 1.001, 0.1)
    time, segment, (line, held) = rows(0.01, [(a, 3.0 * a, 0.05, "linear"), (b, np.arange(11.0), 0.1, "hold")])
    assert time == pytest.approx(np.arange(101) * 0.01)
    assert np.all(segment == 0.0)
    assert line == pytest.approx(3.0 * time)
    assert np.array_equal(held, np.floor(10.0 * time + 1e-6))


def test_a_gap_stays_a_gap():
    time = np.concatenate([np.arange(0.0, 1.001, 0.1), np.arange(2.0, 3.001, 0.1)])
    t, segment, (value,) = rows(0.1, [(time, time, 0.1, "linear")])
    assert t == pytest.approx(time)
    assert segment.tolist() == [0.0] * 11 + [1.0] * 11
    assert value == pytest.approx(time)


def test_one_missing_sample_is_bridged_and_two_are_not():
    every = np.arange(20) * 0.1
    assert len(rows(0.1, [(np.delete(every, 5), np.delete(every, 5), 0.1, "linear")])[0]) == 20
    t, segment, _ = rows(0.1, [(np.delete(every, [5, 6]), np.delete(every, [5, 6]), 0.1, "linear")])
    assert len(t) == 18
    assert segment[-1] == 1.0


@pytest.mark.parametrize("cuts", [(np.inf,), (0.95, 2.35, np.inf)])
def test_partial_rows_are_there_where_any_channel_is_known(cuts):
    always = np.arange(40) * 0.1
    late = np.concatenate([np.arange(5, 12) * 0.1, np.arange(20, 30) * 0.1])
    gap = np.concatenate([always[:25], always[32:]])
    channels = [(late, 10.0 + late, 0.1, "linear"), (gap, gap, 0.1, "linear")]
    t, segment, (a, b) = rows(0.1, channels, cuts, partial=True)
    assert np.round(t / 0.1).astype(int).tolist() == [*range(30), *range(32, 40)]
    assert segment.tolist() == [0.0] * 30 + [1.0] * 8
    assert np.flatnonzero(~np.isnan(a)).tolist() == [*range(5, 12), *range(20, 30)]
    assert np.flatnonzero(np.isnan(b)).tolist() == [25, 26, 27, 28, 29]
    assert a[5:12] == pytest.approx(10.0 + late[:7])
    assert b[:25] == pytest.approx(gap[:25])


@given(st.lists(st.sets(st.integers(0, 29), min_size=2), min_size=2, max_size=3), st.integers(1, 29))
def test_partial_rows_hold_the_whole_ones_and_do_not_depend_on_the_blocks(samples, cut):
    channels = [(np.array(sorted(own)) * 0.1, np.array(sorted(own)) * 1.0, 0.1, "linear") for own in samples]
    t, segment, values = rows(0.1, channels, partial=True)
    again = rows(0.1, channels, (cut * 0.1, np.inf), partial=True)
    assert np.array_equal(t, again[0])
    assert np.array_equal(segment, again[1])
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(values, again[2], strict=True))
    known = ~np.isnan(values)
    assert known.any(axis=0).all()
    whole_t, _, whole = rows(0.1, channels)
    keep = known.all(axis=0)
    assert np.array_equal(t[keep], whole_t)
    assert all(np.array_equal(a[keep], b) for a, b in zip(values, whole, strict=True))


def test_a_held_value_lasts_a_raster_into_a_gap():
    time = np.array([0.0, 1.0, 5.0, 6.0])
    t, segment, (value,) = rows(0.25, [(time, np.array([1.0, 2.0, 3.0, 4.0]), 1.0, "hold")])
    assert t.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 5.0, 5.25, 5.5, 5.75, 6.0, 6.25, 6.5, 6.75]
    assert value.tolist() == [1.0] * 4 + [2.0] * 4 + [3.0] * 4 + [4.0] * 4
    assert segment.tolist() == [0.0] * 8 + [1.0] * 8


def test_rows_are_where_all_channels_are():
    a = np.arange(0.0, 2.001, 0.1)
    b = np.concatenate([np.arange(0.5, 1.001, 0.1), np.arange(1.5, 3.001, 0.1)])
    t, segment, _ = rows(0.1, [(a, a, 0.1, "linear"), (b, b, 0.1, "linear")])
    assert t == pytest.approx(np.concatenate([np.arange(5, 11), np.arange(15, 21)]) * 0.1)
    assert segment.tolist() == [0.0] * 6 + [1.0] * 6


def test_a_channel_without_samples_gives_no_rows_and_lets_the_others_go():
    maker = Resampler(0.1, ["linear", "linear"])
    for block in range(20):
        time = np.arange(1000 * block, 1000 * (block + 1)) * 0.1
        maker.tracks[0].add(Samples(time, time), 0.1)
        assert list(maker.rows(time[-1] - 0.25)) == []
        assert len(maker.tracks[0].time) < 1100


def test_a_leap_of_the_clock_costs_nothing():
    time = np.concatenate([np.arange(10) * 0.1, 1e9 + np.arange(10) * 0.1])
    t, segment, _ = rows(0.1, [(time, time, 0.1, "linear")])
    assert len(t) in (19, 20)  # the second piece may begin between two places
    assert segment[-1] == 1.0


@given(
    st.lists(st.booleans(), min_size=40, max_size=40),
    st.lists(st.booleans(), min_size=40, max_size=40),
    st.lists(st.floats(0.0, 4.0), max_size=5),
    st.sampled_from(["linear", "hold"]),
)
def test_blocks_do_not_matter(a, b, cuts, between):
    time = np.arange(40) * 0.1
    channels = [
        (time[np.array(a)], np.sin(time[np.array(a)]), 0.1, "linear"),
        (time[np.array(b)], np.cos(time[np.array(b)]), 0.1, between),
    ]
    whole = rows(0.05, channels)
    parts = rows(0.05, channels, (*sorted(cuts), np.inf))
    assert np.array_equal(whole[0], parts[0])
    assert np.array_equal(whole[1], parts[1])
    assert all(np.array_equal(x, y) for x, y in zip(whole[2], parts[2], strict=True))
