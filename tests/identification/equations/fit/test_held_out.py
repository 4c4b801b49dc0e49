import numpy as np
import pytest

from polydraulic.identification.equations.fit.held_out import huber, surely_better

BLOCK = np.repeat(np.arange(4), 500)


def noise(seed):
    return np.random.default_rng(seed).normal(size=len(BLOCK))


def test_what_few_rows_show_by_far_is_no_chance():
    before = noise(1)
    before[700:720] += 8.0  # in one block of four, one piece of ten
    assert surely_better(before, noise(1), BLOCK)


def test_what_noise_saves_is_chance():
    better = 0
    for seed in range(40):
        wrong = 0.05 * np.sin(0.01 * np.arange(len(BLOCK)) + seed)  # of a model that is no nearer
        better += surely_better(noise(seed), noise(seed) + wrong, BLOCK)
    assert better <= 4


def test_far_rows_count_less():
    assert huber(np.array([0.0, 2.0, 10.0])).tolist() == [0.0, 2.0, 18.0]


@pytest.mark.parametrize(("before", "better"), [(1.49, False), (1.51, True)])
def test_noise_saves_half_of_what_is_surely_better(before, better):
    """Of `k` rows of one piece k (b^2 - a^2) / 2 is saved, and noise saves k a (b - a): b = 3 a is two standard deviations."""
    rows = np.isin(np.arange(20), [2, 3])
    assert surely_better(before * rows, 0.5 * rows, np.zeros(20, dtype=int)) == better


@pytest.mark.parametrize(
    ("rows", "together"), [([2, 3], True), ([8, 9], True), ([18, 19], True), ([1, 2], False), ([9, 10], False)]
)
def test_rows_of_a_tenth_of_a_block_may_err_together(rows, together):
    """Of rows that err each by themselves the half of what is saved is noise's at b = 1.83 a, of rows that do together at 3 a."""
    there = np.isin(np.arange(20), rows)
    for block in (np.zeros(20, dtype=int), np.full(20, 7)):
        assert surely_better(1.4 * there, 0.5 * there, block) != together


@pytest.mark.parametrize(("e", "share", "better"), [(0.0216, 4.9e-4, False), (0.0221, 5.1e-4, True)])
def test_a_knot_saves_five_ten_thousandths(e, share, better):
    """Pairs of rows in which noise saves nothing: (1 + e) e = (1 - d) d."""
    after = np.tile([1.0 + e, 0.5 + np.sqrt(0.25 - e - e * e)], 20)
    assert 1.0 - np.mean(after**2) == pytest.approx(share, rel=0.01)
    assert surely_better(np.ones(40), after, np.zeros(40, dtype=int)) == better
