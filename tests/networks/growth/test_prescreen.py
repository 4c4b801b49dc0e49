import numpy as np

from polydraulic.networks.growth.prescreen import promising_inputs
from polydraulic.networks.growth.training_rows import BLOCK, rows_in_memory

RNG = np.random.default_rng(3)
X = RNG.uniform(-1.0, 1.0, (600, 30))
Y = X[:, 4] + 2.0 * X[:, 11] * X[:, 27] + 0.05 * RNG.normal(size=600)


def test_inputs_that_explain_something_alone_or_in_pairs_are_seen():
    found = promising_inputs(rows_in_memory(X, Y, None), 3)
    assert found.tolist() == [4, 11, 27]


def test_so_many_are_chosen_in_rising_order():
    found = promising_inputs(rows_in_memory(X, Y, None), 12)
    assert len(found) == 12
    assert np.all(np.diff(found) > 0)
    assert {4, 11, 27} <= set(found)


def test_rows_without_weight_do_not_count():
    doubled = np.concatenate([X, X])
    other = np.concatenate([Y, X[:, 0] * 10.0])
    weight = np.repeat([1.0, 0.0], 600)
    assert promising_inputs(rows_in_memory(doubled, other, weight), 3).tolist() == [4, 11, 27]


def test_of_many_rows_some_from_all_over_are_enough():
    many = RNG.uniform(-1.0, 1.0, (5 * BLOCK, 10))
    late = np.where(np.arange(len(many)) < 3 * BLOCK, many[:, 2], 3.0 * many[:, 7])
    assert promising_inputs(rows_in_memory(many, late, None), 2).tolist() == [2, 7]
