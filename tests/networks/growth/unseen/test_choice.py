from dataclasses import replace

import numpy as np
import pytest

from helpers.field_logs import FIELD_LOGS, held_out
from polydraulic import AbductiveRegressor
from polydraulic.networks.growth.refine import refine
from polydraulic.networks.growth.synthesis import synthesize
from polydraulic.networks.growth.training_rows import rows_apart, rows_in_memory
from polydraulic.networks.growth.unseen.choice import best_on_blocks, best_on_rows, last_layer, smallest_of_the_best
from polydraulic.networks.growth.unseen.row_blocks import row_blocks
from polydraulic.networks.model.nodes import SINGLE, design
from polydraulic.networks.model.table import Node
from polydraulic.networks.proof.bounds import model_bounds

RNG = np.random.default_rng(3)
X = RNG.uniform(-1.0, 1.0, size=(100, 1))
Y = X[:, 0] + 0.1 * RNG.normal(size=100)
ROWS = rows_in_memory(X, Y, None)
((x, y, _),) = list(ROWS)
LINE = Node(SINGLE, (0,), (0.0, float(x[:, 0] @ y / (x[:, 0] @ x[:, 0])), 0.0, 0.0))
CUBIC = Node(SINGLE, (0,), tuple(np.linalg.lstsq(design(SINGLE, x), y)[0].tolist()))
GROWN, FSE = [[], [LINE], [CUBIC]], [1.0, 0.01, 0.009]
WIDE = (-1e9, 1e9)


def test_without_a_judge_the_last_layer_is_kept():
    assert last_layer(GROWN, FSE, None)[:2] == ([CUBIC], 0.009)
    assert last_layer(GROWN, FSE, lambda nodes: ([LINE], 0.5))[:2] == ([LINE], 0.5)
    assert last_layer(GROWN[:1], FSE[:1], lambda nodes: ([LINE], 0.5))[:2] == ([], 1.0)


def test_refined_coefficients_are_kept_only_if_they_predict_unseen_rows_better():
    wrong = Node(SINGLE, (0,), (5.0, 0.0, 0.0, 0.0))
    chosen = best_on_rows(GROWN, FSE, lambda nodes: ([wrong], 0.001), ROWS, WIDE)
    assert wrong not in chosen.nodes
    assert best_on_rows(GROWN[:2], FSE[:2], lambda nodes: ([CUBIC], 0.009), ROWS, (-1.0, 1.0)).nodes in (
        [LINE],
        [CUBIC],
    )
    apart = rows_apart(X, Y, None, np.arange(100) // 10)
    assert wrong not in best_on_blocks(GROWN, FSE, lambda nodes: ([wrong], 0.001), apart, WIDE).nodes


def test_layers_behind_one_that_is_worse_are_not_judged():
    apart = rows_apart(X, Y, None, np.argsort(np.argsort(X[:, 0])) // 25)  # every block asks for extrapolation or a gap
    far = Node(SINGLE, (0,), (9.0, 0.0, 0.0, 0.0))
    chosen = best_on_blocks([[], [LINE], [far], [CUBIC]], [1.0, 0.01, 9.0, 0.009], None, apart, WIDE)
    assert chosen.nodes == [LINE]
    assert np.isnan(chosen.unseen).tolist() == [False, False, False, True]


def test_of_networks_that_are_about_as_good_the_smallest_is_taken():
    errors = [np.array(e) for e in ([9.0, 8.0, 9.0, 9.0], [1.1, 1.2, 0.8, 1.0], [0.9, 1.0, 1.1, 0.9])]
    assert smallest_of_the_best(errors) == 1
    assert smallest_of_the_best([*errors[:2], 0.5 * errors[1]]) == 2


def root_mean_square(model, X, y):
    return np.sqrt(np.mean((model.predict(X) - y) ** 2))


def test_networks_of_a_log_predict_stretches_of_time_that_they_have_not_seen():
    """Neighbours in time hide what a deep network does between its rows; shuffled rows say nothing of time."""
    X, y = (values[::3] for values in FIELD_LOGS["valve with coarse play"](1))
    held = held_out(len(y))
    mixed = np.random.default_rng(0).permutation(np.flatnonzero(~held))
    in_time, shuffled = (AbductiveRegressor().fit(X[rows], y[rows]) for rows in (~held, mixed))
    assert in_time.network_.n_coefficients < shuffled.network_.n_coefficients
    assert root_mean_square(in_time, X[held], y[held]) < 0.5 * root_mean_square(shuffled, X[held], y[held])
    place = np.searchsorted(np.flatnonzero(~held), mixed)
    named = AbductiveRegressor().fit(X[mixed], y[mixed], groups=row_blocks(X[~held])[place])
    assert named.predict(X[held]) == pytest.approx(in_time.predict(X[held]), abs=1e-3 * np.ptp(y))


@pytest.mark.parametrize("kind", FIELD_LOGS)
def test_no_network_of_a_log_leaves_the_range_of_its_rows(kind):
    """Proved, anywhere in its domain: by no more than a tenth of the range."""
    X, y = FIELD_LOGS[kind](2)
    found = model_bounds(AbductiveRegressor().fit(X, y).to_model(), max_boxes=200)
    margin = 0.1000001 * np.ptp(y)
    assert y.min() - margin <= found.low
    assert found.high <= y.max() + margin


def errors_held_out(kind, seed):
    """Of the network that default settings give; of those of one layer, two and three, as grown and refined, with their coefficients."""
    X, y = FIELD_LOGS[kind](seed)
    held = held_out(len(y))
    model = AbductiveRegressor().fit(X[~held], y[~held])
    rows, own = rows_in_memory(X[~held], y[~held], None), model.network_
    bounds = tuple((bound - own.y_mean) / own.y_scale for bound in (own.y_low, own.y_high))
    grown, _ = synthesize(rows, np.arange(X.shape[1]), model._settings())
    others = []
    for layers in (1, 2, 3):
        nodes = grown[min(layers, len(grown) - 1)]
        for found in (nodes, refine(nodes, rows, bounds, max_iterations=100)[0]):
            network = replace(own, nodes=tuple(found))
            other = replace(model.to_model(), networks=(network,))
            others.append((root_mean_square(other, X[held], y[held]), network.n_coefficients))
    return root_mean_square(model, X[held], y[held]), own.n_coefficients, np.array(others)


def over_the_best_smaller(error, size, others):
    """Error as a share of the least one of the networks with fewer coefficients; 0 if there are none."""
    return error / np.min(others[others[:, 1] < size, 0], initial=np.inf)


def test_networks_of_fewer_layers_are_what_settings_give():
    X, y = FIELD_LOGS["valve without play"](1)
    held = held_out(len(y))
    *_, others = errors_held_out("valve without play", 1)
    for layers, refined, place in ((1, False, 0), (2, True, 3)):
        other = AbductiveRegressor(max_layers=layers, leave_one_out=False, refine=refined).fit(X[~held], y[~held])
        assert others[place] == pytest.approx(
            [root_mean_square(other, X[held], y[held]), other.network_.n_coefficients], rel=1e-6
        )


@pytest.mark.slow
def test_default_settings_are_rarely_worse_than_smaller_networks_of_their_own():
    """On three times 24 logs by which nothing was chosen: those that the rule was found on have the seeds 1 to 6.

    Three of the 72 lie above 1.2: at 1.43, 1.45 and 5.2.
    """
    found = [errors_held_out(kind, seed) for seed in range(1001, 1013) for kind in FIELD_LOGS]
    share = np.array([over_the_best_smaller(*one) for one in found]).reshape(3, 24)
    assert np.all(np.count_nonzero(share <= 1.2, axis=1) >= 20)
    assert np.count_nonzero(share <= 1.2) >= 69
    errors = np.log([[error, *others[:, 0]] for error, _, others in found])
    assert np.all(errors.mean(axis=0)[0] < errors.mean(axis=0)[1:])  # than with any number of layers for all logs


@pytest.mark.slow
@pytest.mark.xfail(
    strict=True, reason="a pump whose stretches held out ask for more than ten others show: 5.2 times the best"
)
def test_default_settings_are_never_worse_than_smaller_networks_of_their_own():
    assert over_the_best_smaller(*errors_held_out("pump", 1007)) <= 1.2
