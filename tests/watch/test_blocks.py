"""Blocks of rows, and the filters that pass over them."""

import numpy as np

from polydraulic.watch.blocks import block_shape, motion_filters, smoothing, starts_of


def test_blocks_follow_each_other_and_leave_gaps_out():
    shape = block_shape(0.02)
    assert (shape.rows, shape.inside) == (50 + 50 + 18, 50)
    time = np.arange(1000) * 0.02
    time[600:] += 5.0
    segment = np.zeros(1000)
    starts = starts_of(time, segment, shape)
    assert np.all((starts + shape.rows <= 600) | (starts >= 600))
    assert starts[0] == 0
    assert 600 in starts
    segment[300:] = 1.0
    assert not any(300 - shape.rows < s < 300 for s in starts_of(time, segment, shape).tolist())
    assert len(starts_of(time[:50], segment[:50], shape)) == 0


def test_smoothing_passes_parabolas_and_lowers_noise():
    weights, at = smoothing(7), np.arange(40.0)
    curve = 1.0 + 0.3 * at - 0.02 * at**2
    assert np.allclose(np.convolve(curve, weights[::-1], "valid"), curve[3:-3])
    assert np.sum(weights**2) < 0.5


def test_filters_of_motion_pass_cubics():
    smooth, slope, curve = motion_filters(0.02)
    at = (np.arange(len(smooth)) - len(smooth) // 2) * 0.02
    cubic = 0.5 - 2.0 * at + 3.0 * at**2 + 7.0 * at**3
    assert np.isclose(cubic @ smooth, 0.5, atol=1e-3)
    assert np.isclose(cubic @ slope, -2.0, atol=0.02)  # where they end a little is missing
    assert np.isclose(cubic @ curve, 6.0, atol=1e-2)
