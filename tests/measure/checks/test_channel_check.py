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
