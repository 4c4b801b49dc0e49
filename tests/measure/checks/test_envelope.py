import numpy as np

from polydraulic.measure.checks.envelope import Envelope


def test_an_envelope_holds_all_that_was_seen():
    envelope, time, value = Envelope(), np.arange(50_000) * 0.01, np.random.default_rng(0).normal(size=50_000)
    for part in np.array_split(np.arange(50_000), 37):
        envelope.add(time[part], value[part])
    first, last, low, high = envelope.intervals()
    assert len(first) <= 1500
    assert (first[0], last[-1], low.min(), high.max()) == (0.0, time[-1], value.min(), value.max())
    assert np.all(first[1:] > last[:-1])
