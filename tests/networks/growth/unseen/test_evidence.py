import numpy as np

from polydraulic import AbductiveRegressor
from polydraulic.networks.growth.checked_settings import checked_settings
from polydraulic.networks.growth.training_rows import rows_apart, rows_in_memory
from polydraulic.networks.growth.unseen.evidence import helps_on_others

RNG = np.random.default_rng(8)
SETTINGS = checked_settings(AbductiveRegressor())


def helps(X, y, weight=None, block=None):
    rows = rows_in_memory(X, y, weight) if block is None else rows_apart(X, y, weight, block)
    return helps_on_others(rows, SETTINGS, lambda part: np.arange(X.shape[1]), apart=block is not None)


def test_what_depends_on_the_inputs_is_told_from_what_does_not():
    X = RNG.normal(size=(200, 4))
    noise = RNG.normal(size=200)
    assert helps(X, X[:, 0] * X[:, 1] + noise)
    assert not helps(X, noise)
    assert helps(1e150 * X, 1e-150 * X[:, 2])


def test_a_weight_of_rows_that_say_something_decides():
    X = RNG.normal(size=(300, 2))
    y = np.where(np.arange(300) < 100, X[:, 0], 3.0 * RNG.normal(size=300))
    assert helps(X, y, np.where(np.arange(300) < 100, 100.0, 0.01))


def test_rows_that_are_repeated_are_left_out_together():
    """What was learnt from a row says nothing of the same row once more."""
    X, y = np.random.default_rng(2).normal(size=(15, 30)), np.random.default_rng(3).normal(size=15)
    again = np.repeat(np.arange(15), 3)[np.random.default_rng(4).permutation(45)]
    assert not helps(X, y)
    assert not helps(X, y, np.full(15, 3.0))
    assert not helps(X[again], y[again])


def test_neighbours_in_time_say_nothing_of_stretches_left_out():
    kernel, stretch = np.exp(-np.arange(160) / 40.0), np.arange(2000) * 10 // 2000
    at_random, by_stretch = 0, 0
    for _ in range(6):
        slow = np.column_stack([np.convolve(RNG.normal(size=2159), kernel, "valid") for _ in range(9)])
        X, y = slow[:, :8], slow[:, 8]
        at_random += helps(X, y)
        by_stretch += helps(X, y, block=stretch)
        assert helps(X, X[:, 0] + 0.2 * X[:, 1] ** 2 + y, block=stretch)
    assert at_random == 6
    assert by_stretch <= 3
