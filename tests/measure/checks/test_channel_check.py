import numpy as np
import pytest

from polydraulic.measure.channels import Channel
from polydraulic.measure.checks.channel_check import ChannelCheck
from polydraulic.measure.checks.clock import Clock, ClockedRows
from polydraulic.measure.findings import Findings
from polydraulic.units import read_unit

N = 2000
WAVE = 50.0 + 20.0 * np.sin(np.arange(N) / 50.0) + np.random.default_rng(0).normal(0.0, 0.1, N)


def checked(value, *, text=(), **channel):
    """What is kept of a channel in bar, and its findings as (kind, rows)."""
    findings = Findings()
    clock = Clock("time", 1.0, None, None, findings)
    check = ChannelCheck(Channel("p", "p", "input", "bar", **channel), read_unit("bar"), clock, findings)
    marks = np.zeros(len(value), dtype=bool)
    marks[list(text)] = True
    rows, no = np.arange(len(value)), np.zeros(len(value), dtype=bool)
    samples = check.samples(ClockedRows(rows + 1, rows * 0.01, {"p": value}, {"p": marks}, no, 1.0))
    check.end()
    assert {f.channel for f in findings} <= {"p"}
    return samples, [(f.kind, f.rows) for f in findings], check


def test_a_healthy_channel_is_given_in_si_and_described_in_its_unit():
    samples, findings, check = checked(WAVE)
    assert findings == []
    assert samples.values == pytest.approx(1e5 * WAVE)
    assert (check.count, check.low, check.high) == (N, WAVE.min(), WAVE.max())
    assert (check.mean, check.square) == pytest.approx((WAVE.mean(), ((WAVE - WAVE.mean()) ** 2).sum()))


@pytest.mark.parametrize(
    ("value", "kind"), [(90.0, "spike"), (np.inf, "infinite"), (150.0, "implausible")], ids=["spike", "inf", "range"]
)
def test_a_bad_value_is_missing_and_named(value, kind):
    changed = WAVE.copy()
    changed[700] = value
    samples, findings, _ = checked(changed, low=0.0, high=100.0)
    assert findings == [(kind, [(701, 701)])]
    assert len(samples.values) == N - 1
    assert 7.0 not in samples.time


@pytest.mark.parametrize("number", [9.91e37, -1e30, np.finfo(float).max])
def test_numbers_that_nothing_can_have_are_no_values(number):
    changed = WAVE.copy()
    changed[[700, 701, 702]] = number
    samples, findings, check = checked(changed)
    assert findings == [("infinite", [(701, 703)]), ("dropout", [(704, 704)])]
    assert len(samples.values) == N - 3
    assert check.high == WAVE.max()


@pytest.mark.parametrize(("number", "kept"), [(9.99e29, True), (-9.99e29, True), (1e30, False)])
def test_a_value_is_below_1e30(number, kept):
    changed = WAVE.copy()
    changed[700] = number
    assert len(checked(changed, between="hold")[0].values) == N - (not kept)


def test_a_number_far_from_all_others_is_named_and_kept():
    changed = WAVE.copy()
    changed[700:705] = -9999.0
    samples, findings, _ = checked(changed)
    assert ("sentinel", [(701, 705)]) in findings
    assert len(samples.values) == N
    assert ("sentinel", [(701, 705)]) in checked(changed, between="hold")[1]


def test_a_signal_that_is_cut_off_is_clipped_and_no_sentinel():
    rest = np.random.default_rng(1).normal(0.0, 0.01, N)
    cut = np.where(np.arange(N) // 100 % 4 == 1, 5.0, rest)
    assert [kind for kind, _ in checked(cut)[1]] == ["clipped"]


def test_a_spike_stands_out_of_the_usual_range_or_of_the_noise_by_far():
    for size, found in ((1.9, []), (2.8, [])):  # within a tenth of the range, however quiet the channel is
        changed = WAVE.copy()
        changed[700] += size
        assert checked(changed)[1] == found
    step = np.where(np.arange(N) < 700, WAVE, WAVE + 40.0)
    assert checked(step)[1] == []  # a step does not come back


def test_a_held_channel_may_leap():
    changed = WAVE.copy()
    changed[700] = 90.0
    assert checked(changed, between="hold")[1] == []


def test_missing_values_are_counted_as_dropouts_with_the_row_after_each():
    changed = WAVE.copy()
    changed[700:710] = np.nan
    _, findings, check = checked(changed)
    assert findings == [("dropout", [(711, 711)])]
    assert check.lost == pytest.approx(0.11)


def test_texts_and_channels_without_values_are_named():
    changed = WAVE.copy()
    changed[5] = np.nan
    assert ("text", [(6, 6)]) in checked(changed, text=[5])[1]
    assert checked(np.full(N, np.nan))[1] == [("empty", [])]
    assert checked(np.full(N, 3.0))[1] == [("constant", [])]


def test_values_that_fit_with_another_sign_or_unit_say_so():
    assert checked(-WAVE, low=0.0, high=100.0)[1][-1][0] == "sign"
    assert checked(1e5 * WAVE, low=0.0, high=100.0)[1][-1][0] == "unit by values"
    assert checked(-WAVE, low=0.0, high=100.0, sign=-1)[1] == []


def triangle(place, size, n=1001):
    """From 0 to 100 and back by halves, and at one place more or less."""
    value = 0.5 * np.abs((np.arange(n) + 200) % 400 - 200.0)
    value[place] += size
    return value


@pytest.mark.parametrize(
    ("place", "size", "found"),
    [
        (300, 29.0, False),  # within the range, which is 100: three tenths of it
        (300, 31.5, True),
        (300, -31.5, True),
        (400, -9.0, False),  # at its ends a tenth of it, beyond them
        (400, -11.5, True),
        (200, 9.0, False),
        (200, 11.5, True),
        (200, -29.0, False),
    ],
)
def test_a_spike_is_a_tenth_of_the_range_beyond_it_or_three_tenths_within(place, size, found):
    samples, findings, _ = checked(triangle(place, size))
    assert findings == ([("spike", [(place + 1, place + 1)])] if found else [])
    assert len(samples.values) == 1001 - found


@pytest.mark.parametrize(("size", "found"), [(17.8, False), (18.2, True)])
def test_a_spike_is_ten_times_the_usual_difference(size, found):
    value = np.where(np.arange(1000) % 2, -1.0, 1.0)  # by 2 from each to the next
    value[500] += size
    assert ("spike" in dict(checked(value)[1])) == found


@pytest.mark.parametrize(("size", "found"), [(2.9, False), (3.1, True)])
def test_a_spike_is_three_times_the_smallest_difference(size, found):
    value = np.repeat(np.abs((np.arange(100) + 8) % 16 - 8.0), 20)  # from 0 to 8 by 1, and mostly still
    value[8 * 20 + 10] += size
    assert ("spike" in dict(checked(value)[1])) == found


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize(("apart", "found"), [(9.0, True), (18.0, False)])
def test_what_is_around_a_spike_is_close(side, apart, found):
    value = triangle(300, 60.0)
    value[301:] += apart if side > 0 else 0.0  # the neighbours of the spike from each other
    value[:299] -= 0.0 if side > 0 else apart  # a neighbour from its own
    assert ("spike" in dict(checked(value)[1])) == found


@pytest.mark.parametrize(
    ("n", "place", "found"),
    [(19, 10, False), (20, 10, True), (20, 2, True), (20, 17, True), (20, 1, False), (20, 18, False)],
)
def test_a_spike_needs_twenty_values_and_two_on_either_side(n, place, found):
    value = 0.01 * np.arange(float(n))
    value[place] += 50.0
    assert ("spike" in dict(checked(value)[1])) == found


@pytest.mark.parametrize(("wrong", "named"), [(100, False), (101, True)])
def test_units_are_doubted_when_most_values_are_implausible(wrong, named):
    value = np.repeat([-50.0, 5.0], [wrong, 200 - wrong])
    assert ("sign" in dict(checked(value, low=-10.0, high=100.0, between="hold")[1])) == named


@pytest.mark.parametrize(("fits", "named"), [(190, False), (191, True)])
def test_another_sign_or_unit_fits_nearly_all_values(fits, named):
    value = np.repeat([50.0, 1e9], [fits, 200 - fits])
    assert ("sign" in dict(checked(-value, low=0.0, high=100.0)[1])) == named
    found = checked(1e5 * value, low=0.0, high=100.0)[1]
    assert ("unit by values" in dict(found)) == named


@pytest.mark.parametrize(("value", "peak"), [(200.0, True), (201.0, False), (-100.0, True), (-101.0, False)])
def test_what_is_within_one_range_of_it_may_be_a_peak(value, peak):
    changed = WAVE.copy()
    changed[[700, 900]] = value, 101.0
    *_, check = checked(changed, low=0.0, high=100.0)
    (found,) = check.findings
    assert found.detail.startswith(f"range [0, 100] bar, such as {value:g}")
    assert ("if these are peaks of the signal, the range is too narrow" in found.detail) == peak
    assert (found.count, check.implausible, check.given) == (2, 2, N)


def at(time, value, after_gap=(), *, blocks=1, **channel):
    """A check of a channel at times of its own, block by block."""
    findings = Findings()
    clock = Clock("time", 1.0, None, None, findings)
    check = ChannelCheck(Channel("p", "p", "input", "bar", **channel), read_unit("bar"), clock, findings)
    marks = np.isin(np.arange(len(time)), after_gap)
    kept = []
    for part in np.array_split(np.arange(len(time)), blocks):
        clock.gaps += int(marks[part].sum())
        no = np.zeros(len(part), dtype=bool)
        kept.append(check.samples(ClockedRows(part + 1, time[part], {"p": value[part]}, {"p": no}, marks[part], 1.0)))
    check.end()
    return check, kept


@pytest.mark.parametrize(("step", "lost"), [(2.45, 0.0), (2.55, 0.0255)])
def test_a_dropout_is_longer_than_two_and_a_half_rasters_and_no_gap(step, lost):
    time = 0.01 * (np.arange(N) + (step - 1.0) * (np.arange(N) >= 600))
    check, _ = at(time, WAVE)
    assert check.lost == pytest.approx(lost)
    assert [(f.kind, f.rows) for f in check.findings] == ([("dropout", [(601, 601)])] if lost else [])
    assert at(time, WAVE, [600])[0].lost == 0.0  # every channel pauses there


@pytest.mark.parametrize("blocks", [2, 9])
def test_blocks_change_nothing(blocks):
    time, value = 0.01 * np.arange(N), WAVE.copy()
    value[700:710] = np.nan
    value[1500] = 150.0
    time[1000:] += 1.0
    whole, some = (at(time, value, [1000], blocks=n, low=0.0, high=100.0)[0] for n in (1, blocks))
    for name in ("count", "low", "high", "given", "implausible", "seen", "crc", "raster", "farthest"):
        assert getattr(some, name) == pytest.approx(getattr(whole, name)), name
    for name in ("mean", "square", "lost"):
        assert getattr(some, name) == pytest.approx(getattr(whole, name)), name
    assert whole.square == pytest.approx(((value[value < 100.0] - whole.mean) ** 2).sum())
    assert [(f.kind, f.rows) for f in some.findings] == [("implausible", [(1501, 1501)]), ("dropout", [(711, 711)])]


@pytest.mark.parametrize(("between", "kinds"), [("linear", ["raster"]), ("hold", [])])
def test_the_raster_of_a_channel_is_that_of_the_map_or_is_found(between, kinds):
    time = 0.01 * np.arange(N)
    check, _ = at(time, WAVE, raster=0.02, between=between)
    assert [f.kind for f in check.findings] == kinds
    assert check.raster == 0.02
    assert at(time, WAVE)[0].raster == pytest.approx(0.01)


def test_the_sign_of_the_map_turns_values():
    samples, _, check = checked(WAVE, sign=-1)
    assert samples.values == pytest.approx(-1e5 * WAVE)
    assert (check.low, check.high) == (-WAVE.max(), -WAVE.min())
