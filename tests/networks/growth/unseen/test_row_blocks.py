import numpy as np
import pytest

from helpers.field_logs import FIELD_LOGS, valve_log
from polydraulic.errors import InputError
from polydraulic.networks.growth.unseen.row_blocks import STRETCHES, is_log, row_blocks

RNG = np.random.default_rng(0)
INDEPENDENT = RNG.uniform(size=(1000, 3))


@pytest.mark.parametrize("kind", FIELD_LOGS)
def test_a_log_is_known_by_the_order_of_its_rows(kind):
    X, _ = FIELD_LOGS[kind](4)
    assert is_log(X)
    assert is_log(1e6 + 1e-3 * X)
    assert is_log(np.column_stack([X, np.arange(len(X)), np.full(len(X), 3.0)]))  # time, and what does not vary
    assert is_log(np.repeat(X, 2, axis=0))
    assert not is_log(RNG.permutation(X))


def sorted_by_first(X):
    return X[np.argsort(X[:, 0])]


@pytest.mark.parametrize(
    "X",
    [
        INDEPENDENT,
        sorted_by_first(INDEPENDENT),
        np.linspace(-1.0, 1.0, 1000)[:, None],
        np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 40)] * 2), axis=-1).reshape(-1, 2),
        np.repeat(INDEPENDENT, RNG.integers(1, 30, 1000), axis=0),
        np.ones((1000, 2)),
        valve_log(4)[0][:150],
    ],
    ids=["independent", "sorted", "a sweep", "a grid", "repeated rows", "constant", "too short"],
)
def test_no_other_table_is_a_log(X):
    assert not is_log(X)
    assert row_blocks(X) is None


def test_a_log_is_cut_into_stretches_of_equal_length():
    block = row_blocks(valve_log(4)[0])
    assert np.all(np.diff(block) >= 0)
    assert np.bincount(block).tolist() == [6000 // STRETCHES] * STRETCHES


def test_groups_may_have_any_labels():
    assert row_blocks(INDEPENDENT[:4], ["b", "a", "b", "c"]).tolist() == [1, 0, 1, 2]
    assert row_blocks(valve_log(4)[0], np.arange(6000)) is None  # independent, if you say so
    assert len(np.unique(row_blocks(INDEPENDENT, np.arange(1000) // 2))) == 100
    with pytest.raises(InputError, match=r"groups has shape \(3,\); it must hold one label for each of the 4 rows"):
        row_blocks(INDEPENDENT[:4], [1, 2, 3])
    with pytest.raises(InputError, match="groups holds one label, 'a': name at least two"):
        row_blocks(INDEPENDENT[:2], ["a", "a"])
