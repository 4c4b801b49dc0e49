import numpy as np

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
