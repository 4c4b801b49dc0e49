import numpy as np
import pytest

from polydraulic.measure.checks.envelope import Envelope


def test_an_envelope_holds_all_that_was_seen():
    envelope, time, value = Envelope(), np.arange(50_000) * 0.01, np.random.default_rng(0).normal(size=50_000)
    for part in np.array_split(np.arange(50_000), 37):
        envelope.add(time[part], value[part])
    first, last, low, high = envelope.intervals()
    assert len(first) <= 1500
    assert (first[0], last[-1], low.min(), high.max()) == (0.0, time[-1], value.min(), value.max())
    assert np.all(first[1:] > last[:-1])


@pytest.mark.parametrize("n", [1500, 1501, 3003, 50_001])
@pytest.mark.parametrize("block", [1, 7, 1600])
def test_each_interval_holds_what_was_seen_in_it_and_no_more(n, block):
    envelope, value = Envelope(), np.random.default_rng(n).normal(size=n)
    for start in range(0, n, block * (1 + n // 10_000)):
        part = np.arange(start, min(n, start + block * (1 + n // 10_000)))
        envelope.add(part.astype(float), value[part])
    first, last, low, high = envelope.intervals()
    a, b = first.astype(int), last.astype(int)
    assert (a[0], b[-1]) == (0, n - 1)
    assert np.array_equal(a[1:], b[:-1] + 1)  # no sample in two of them, none in none
    assert np.array_equal(low, np.minimum.reduceat(value, a))
    assert np.array_equal(high, np.maximum.reduceat(value, a))
    assert len(a) == n if n <= 1500 else 700 < len(a) <= 1500  # as fine as there is room


def test_no_sample_changes_nothing():
    envelope = Envelope()
    envelope.add(np.zeros(0), np.zeros(0))
    assert envelope.intervals().shape == (4, 0)
