import numpy as np
import pytest

from polydraulic.identification.noise import noise_level, noise_of_pieces


def test_noise_is_told_from_a_smooth_signal_with_jumps():
    rng, t = np.random.default_rng(1), np.arange(20000) * 0.02
    signal = np.sin(t) + np.where(t > 200.0, 5.0, 0.0) + rng.normal(0.0, 0.03, len(t))
    assert noise_level(signal, np.zeros(len(t))) == pytest.approx(0.03, rel=0.03)


def test_rows_of_different_segments_are_not_compared():
    assert noise_level(np.arange(30.0) ** 4, np.arange(30)) == 0.0
    assert noise_level(np.ones(3), np.zeros(3)) == 0.0


def test_a_signal_without_noise_that_mostly_rests_has_some():
    signal = np.where(np.arange(1000) > 900, 2e-3, 0.0)
    assert noise_level(signal, np.zeros(1000)) == pytest.approx(2e-8)
    assert noise_level(np.ones(1000), np.zeros(1000)) == 0.0


def test_rows_of_silence_are_left_out():
    rng = np.random.default_rng(2)
    signal = rng.normal(0.0, 0.03, 20000)
    signal[::7] = np.nan
    assert noise_level(signal, np.zeros(20000)) == pytest.approx(0.03, rel=0.05)
    assert noise_level(np.full(50, np.nan), np.zeros(50)) == 0.0


def test_pieces_are_not_compared_across_their_ends():
    pieces = [level + np.random.default_rng(level).normal(0.0, 0.03, 6) for level in range(2000)]
    assert noise_of_pieces(pieces) == pytest.approx(0.03, rel=0.1)
