import numpy as np
import pytest

from polydraulic import AbductiveRegressor
from polydraulic.networks.growth.training_rows import rows_apart, rows_from_blocks, rows_in_memory
from polydraulic.networks.growth.unseen.leave_one_out import leave_blocks_out, leave_one_out
from polydraulic.networks.model.nodes import DOUBLE, design
from polydraulic.networks.model.table import Node

RNG = np.random.default_rng(2)
X = RNG.normal(size=(60, 2))
Y = X[:, 0] ** 2 - X[:, 1] + 0.3 * RNG.normal(size=60)
WIDE = (-1e9, 1e9)


def fitted(rows):
    """A Double, fitted to all rows."""
    x, y = (np.concatenate(parts) for parts in zip(*((x, y) for x, y, _ in rows), strict=True))
    return [Node(DOUBLE, (0, 1), tuple(np.linalg.lstsq(design(DOUBLE, x), y)[0].tolist()))]


def test_for_one_node_it_is_the_error_of_fits_without_each_row():
    rows = rows_in_memory(X, Y, None)
    ((x, y, _),) = list(rows)
    errors = []
    for i in range(len(y)):
        others = np.arange(len(y)) != i
        coef = np.linalg.lstsq(design(DOUBLE, x[others]), y[others])[0]
        errors.append((design(DOUBLE, x[i : i + 1]) @ coef)[0] - y[i])
    assert leave_one_out(fitted(rows), rows, WIDE) == pytest.approx(np.mean(np.square(errors)), rel=1e-6)


def test_no_network_predicts_the_mean():
    rows = rows_in_memory(X, Y, None)
    assert leave_one_out([], rows, WIDE) == pytest.approx(1.0)


def test_predictions_are_clamped():
    far = np.vstack([X, [[50.0, 50.0]]])
    rows = rows_in_memory(far, np.append(Y, 3.0), None)
    nodes = fitted(rows)
    assert leave_one_out(nodes, rows, WIDE) > 10.0 * leave_one_out(nodes, rows, (-3.0, 3.0))


def test_weights_act_like_repetitions_and_blocks_add_up():
    weight = RNG.integers(1, 4, size=60)
    twice = np.repeat(np.arange(60), weight)
    repeated, weighted = rows_in_memory(X[twice], Y[twice], None), rows_in_memory(X, Y, weight.astype(float))
    nodes = fitted(repeated)
    error = leave_one_out(nodes, repeated, WIDE)
    assert leave_one_out(nodes, weighted, WIDE) == pytest.approx(error, rel=1e-12)
    blocks = rows_from_blocks([(X[:7], Y[:7], weight[:7]), (X[7:], Y[7:], weight[7:])])
    assert leave_one_out(nodes, blocks, WIDE) == pytest.approx(error, rel=1e-9)


def test_far_rows_do_not_decide_high_powers():
    scores = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        heavy = rng.standard_t(2, size=(400, 4))
        y = heavy[:, 0] + np.log1p(heavy[:, 1] ** 2) + 0.3 * rng.normal(size=400)
        model = AbductiveRegressor(max_layers=3).fit(heavy[:300], y[:300])
        scores.append(model.score(heavy[300:], y[300:]))
        errors = [step.leave_one_out for step in model.history_ if step.accepted]
        assert model.network_.n_coefficients <= model.history_[int(np.argmin(errors))].n_coefficients
    assert min(scores) > 0.3


BLOCK = np.repeat(np.arange(6), 10)


def test_for_one_node_it_is_the_error_of_fits_without_each_block():
    weight = RNG.uniform(0.5, 2.0, size=60)
    for w in (None, weight):
        rows = rows_in_memory(X, Y, w)
        ((x, y, _),) = list(rows)
        root = np.ones(60) if w is None else np.sqrt(w)
        node = Node(DOUBLE, (0, 1), tuple(np.linalg.lstsq(design(DOUBLE, x) * root[:, None], y * root)[0]))
        expected = []
        for k in range(6):
            own, others = k == BLOCK, k != BLOCK
            coef = np.linalg.lstsq(design(DOUBLE, x[others]) * root[others, None], (y * root)[others])[0]
            expected.append(np.sum((root[own] * (design(DOUBLE, x[own]) @ coef - y[own])) ** 2) / np.sum(root**2))
        shuffled = RNG.permutation(60)
        apart = rows_apart(X[shuffled], Y[shuffled], None if w is None else w[shuffled], BLOCK[shuffled])
        assert leave_blocks_out([node], apart, WIDE) == pytest.approx(np.array(expected), rel=1e-6)
        assert leave_blocks_out([node], apart, (-0.1, 0.1)).sum() != pytest.approx(sum(expected), rel=0.1)


def test_no_network_predicts_the_mean_of_the_other_blocks():
    rows = rows_in_memory(X, Y, None)
    ((_, y, _),) = list(rows)
    expected = [np.sum((y[k == BLOCK] - y[k != BLOCK].mean()) ** 2) / 60 for k in range(6)]
    assert leave_blocks_out([], rows_apart(X, Y, None, BLOCK), WIDE) == pytest.approx(np.array(expected))
