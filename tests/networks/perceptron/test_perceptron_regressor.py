import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.exceptions import ConvergenceWarning
from sklearn.neural_network import MLPRegressor
from sklearn.utils.estimator_checks import parametrize_with_checks

from polydraulic import RegionRegressor
from polydraulic.errors import InputError
from polydraulic.networks import Network, Node, PerceptronRegressor, check_range, hidden_unit_sweep
from polydraulic.networks.model.nodes import LINEAR, SIGMOID
from polydraulic.networks.perceptron.back_propagation import MARGIN

RNG = np.random.default_rng(5)
X = RNG.uniform(0.0, 1.0, size=(400, 2)) * [0.01, 2e7] + [0.0, 1e5]


def valve(X):
    """Flow through a metering edge, limited by the pump."""
    travel, pressure = X[:, 0] / 0.01, X[:, 1] / 2.01e7
    return 3e-3 * np.tanh(4.0 * travel**2 * np.sqrt(1.05 - pressure))


Y = valve(X)
quick = {"hidden_units": 4, "max_iter": 30, "n_starts": 1}


def rms(error):
    return float(np.sqrt(np.mean(error**2)))


@pytest.mark.parametrize("output", ["sigmoid", "linear"])
@pytest.mark.parametrize("beta", [0.5, 1.7])
def test_the_network_is_the_printed_formula(output, beta):
    model = PerceptronRegressor(output=output, beta=beta, **quick).fit(X, Y)

    def g(h):
        return 1.0 / (1.0 + np.exp(-2.0 * beta * h))

    hidden, last = model.weights_
    x = (X - X.min(axis=0)) / np.ptp(X, axis=0)
    h = g(x @ hidden[:, :-1].T + hidden[:, -1]) @ last[:-1] + last[-1]
    share = (g(h) - MARGIN) / (1.0 - 2.0 * MARGIN) if output == "sigmoid" else h
    assert model.predict(X) == pytest.approx(Y.min() + np.ptp(Y) * share, rel=1e-12)
    assert [node.kind for node in model.network_.nodes] == [SIGMOID] * 4 + [SIGMOID if output == "sigmoid" else LINEAR]


def test_saturated_units_stay_finite():
    steep = Network((Node(SIGMOID, (0,), (0.0, 1e9)),), (0.0,), (1.0,), (-1.0,), (1.0,), 0.0, 1.0)
    model = PerceptronRegressor(**quick).fit(X[:, :1], Y)
    model.network_ = steep
    assert model.predict([[-1.0], [0.0], [1.0]]) == pytest.approx([0.0, 0.5, 1.0], abs=1e-200)


def test_a_network_is_a_model_like_any_other():
    model = PerceptronRegressor(**quick).fit(X, Y).to_model()
    assert check_range(model, -0.1 * np.ptp(Y), 1.1 * Y.max()).holds is True
    regions = RegionRegressor(PerceptronRegressor(**quick), edges={0: [0.005]}).fit(X, Y)
    below = X[:, 0] <= 0.005
    alone = PerceptronRegressor(**quick).fit(X[below], Y[below])
    assert np.array_equal(regions.predict(X[below]), alone.predict(X[below]))
    with pytest.raises(InputError, match="PerceptronRegressor states no predicted squared error"):
        RegionRegressor(PerceptronRegressor(**quick)).fit(X, Y)


def test_the_loss_is_the_mean_squared_share_of_the_range():
    model = PerceptronRegressor(**quick).fit(X, Y)
    assert model.loss_ == pytest.approx(0.5 * np.mean(((model.predict(X) - Y) / np.ptp(Y)) ** 2), rel=1e-9)
    assert model.loss_ == model.history_[-1]
    assert len(model.history_) == model.n_iter_ + 1
    weights = np.concatenate([layer.ravel() for layer in model.weights_])
    costly = PerceptronRegressor(weight_cost=1e-4, **quick).fit(X, Y)
    connections = np.concatenate([costly.weights_[0][:, :-1].ravel(), costly.weights_[1][:-1]])
    fit = 0.5 * np.mean(((costly.predict(X) - Y) / np.ptp(Y)) ** 2)
    assert costly.loss_ == pytest.approx(fit + 0.5e-4 * np.sum(connections**2), rel=1e-9)
    assert np.abs(connections).max() < np.abs(weights).max()


@pytest.mark.parametrize("output", ["sigmoid", "linear"])
def test_fifteen_units_fit_a_valve_to_one_percent(output):
    model = PerceptronRegressor(output=output, max_iter=200, n_starts=1).fit(X, Y)
    fresh = np.random.default_rng(6).uniform(size=(1000, 2)) * [0.01, 2e7] + [0.0, 1e5]
    assert rms(model.predict(fresh) - valve(fresh)) < 0.01 * np.ptp(Y)


def test_units_of_the_data_do_not_matter():
    plain = PerceptronRegressor(**quick).fit(X, Y)
    other = PerceptronRegressor(**quick).fit(X * [4.0, 0.5] + [0.0, 1e6], Y * 1024.0)
    assert other.predict(X * [4.0, 0.5] + [0.0, 1e6]) / 1024.0 == pytest.approx(plain.predict(X), abs=1e-3 * np.ptp(Y))


def test_steepness_is_taken_up_by_the_starting_weights():
    plain = PerceptronRegressor(beta=0.5, **quick).fit(X, Y)
    steep = PerceptronRegressor(beta=2.0, **quick).fit(X, Y)
    assert steep.history_[0] == pytest.approx(plain.history_[0], rel=1e-9)
    assert steep.weights_[0].tolist() != plain.weights_[0].tolist()


@given(st.integers(0, 100))
def test_weights_act_like_repetitions_to_the_last_bit(seed):
    rng = np.random.default_rng(seed)
    weight = rng.integers(0, 3, 40)
    weight[:2] = 1
    repeated = rng.permutation(np.repeat(np.arange(40), weight))
    weighted = PerceptronRegressor(**quick).fit(X[:40], Y[:40], sample_weight=weight)
    twice = PerceptronRegressor(**quick).fit(X[repeated], Y[repeated])
    assert weighted.network_ == twice.network_


@pytest.mark.parametrize(
    ("scale", "offset"), [(1e-300, 0.0), (1e-200, 0.0), (1e200, 0.0), (1.0, 1e12), (1e-2, 1e12), (1.0, 1e14)]
)
def test_offsets_and_scales_of_any_size_are_learnt(scale, offset):
    unit = X / [0.01, 2e7]
    plain = rms(PerceptronRegressor(**quick).fit(unit, Y).predict(unit) - Y)
    seen = unit * scale + offset  # of which rounding takes digits
    assert rms(PerceptronRegressor(**quick).fit(seen, Y).predict(seen) - Y) < 1.5 * plain + 0.2 * Y.std()
    target = Y / Y.std() * scale + offset
    answers = PerceptronRegressor(**quick).fit(unit, target).predict(unit)
    assert np.std((answers - target) / scale) < 0.3


def test_inputs_that_cannot_be_learnt_from_are_named():
    with pytest.raises(InputError, match="a column varies by less than 2.2e-308"):
        PerceptronRegressor(**quick).fit(X * [1.0, 1e-318], Y)
    with pytest.warns(UserWarning, match=r"input 1 varies by .* about 1e\+12, which is no more than rounding"):
        PerceptronRegressor(**quick).fit(X * [1.0, 2e-11] + [0.0, 1e12], Y)


def test_a_seed_gives_the_same_network_and_others_differ():
    assert PerceptronRegressor(**quick).fit(X, Y).network_ == PerceptronRegressor(**quick).fit(X, Y).network_
    losses = {PerceptronRegressor(**quick, random_state=seed).fit(X, Y).loss_ for seed in range(3)}
    assert len(losses) == 3


def test_the_best_start_is_kept():
    many = PerceptronRegressor(**{**quick, "n_starts": 4}, random_state=np.random.RandomState(3)).fit(X, Y)
    random = np.random.RandomState(3)  # one stream, so that each fit goes on to the next start
    alone = [PerceptronRegressor(**quick, random_state=random).fit(X, Y).loss_ for _ in range(4)]
    assert many.loss_ == min(alone)
    assert len(set(alone)) == 4


@pytest.mark.parametrize(("output", "momentum"), [("sigmoid", 0.0), ("linear", 0.0), ("sigmoid", 0.5)])
def test_gradient_descent_lowers_the_loss(output, momentum):
    model = PerceptronRegressor(
        solver="gradient", output=output, momentum=momentum, max_iter=200, n_starts=1, eta=0.1
    ).fit(X, Y)
    assert model.n_iter_ == 200
    assert np.all(np.diff(model.history_[5:]) <= 0.0)
    assert model.loss_ < 0.2 * model.history_[0]


def test_quasi_newton_beats_plain_descent():
    settings = {"max_iter": 100, "n_starts": 1}
    plain = PerceptronRegressor(solver="gradient", **settings).fit(X, Y)
    assert PerceptronRegressor(**settings).fit(X, Y).loss_ < 0.1 * plain.loss_


def test_a_rate_that_is_too_large_is_named():
    with pytest.raises(InputError, match="eta = 1e.200: the loss grows without bound"):
        PerceptronRegressor(solver="gradient", output="linear", eta=1e200, n_starts=1).fit(X, Y)


def test_errors_inside_the_radius_do_not_count():
    model = PerceptronRegressor(hidden_units=8, n_starts=1, max_iter=200, zero_error_radius=0.02).fit(X, Y)
    assert model.loss_ == pytest.approx(0.0, abs=1e-8)
    assert model.n_iter_ < 200
    exact = PerceptronRegressor(hidden_units=8, n_starts=1, max_iter=200).fit(X, Y)
    assert rms(model.predict(X) - Y) > 2.0 * rms(exact.predict(X) - Y)


def test_inputs_stay_in_the_domain_and_outputs_in_their_bounds():
    model = PerceptronRegressor(output_bounds=(1e-4, 2e-3), **quick).fit(X, Y)
    far = model.predict(np.array([[50.0, 1e9], X.max(axis=0)]))
    assert far[0] == far[1]
    assert model.predict(X).min() == 1e-4
    assert model.predict(X).max() == 2e-3
    wide = PerceptronRegressor(domain=[(0.0, 0.02), (0.0, 3e7)], **quick).fit(X, Y)
    assert wide.network_.x_high == (0.02, 3e7)


def test_a_sigmoid_output_stays_near_the_range_of_the_data():
    rough = Y + RNG.normal(scale=1e-3, size=len(Y))
    spread = np.ptp(rough)
    predicted = PerceptronRegressor(n_starts=1, max_iter=100).fit(X, rough).predict(X)
    assert predicted.min() > rough.min() - 0.06 * spread
    assert predicted.max() < rough.max() + 0.06 * spread


def test_constant_columns_and_targets():
    model = PerceptronRegressor(domain=[(0.0, 0.01), (0.0, 2e7), (0.0, 9.0)], **quick)
    model.fit(np.column_stack([X, np.full(400, 7.0)]), Y)
    assert np.all(model.weights_[0][:, 2] == 0.0)
    model = PerceptronRegressor(**quick).fit(X, np.full(400, 3.5))
    assert model.predict(X[:2]).tolist() == [3.5, 3.5]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"hidden_units": 0}, "hidden_units = 0: must be a whole number, at least 1"),
        ({"hidden_units": 2.5}, "hidden_units = 2.5"),
        ({"max_iter": 0}, "max_iter = 0"),
        ({"n_starts": 0}, "n_starts = 0"),
        ({"output": "tanh"}, "output = 'tanh': must be one of"),
        ({"solver": "adam"}, "solver = 'adam': must be one of"),
        ({"beta": 0.0}, "beta = 0.0: must be above 0"),
        ({"beta": float("nan")}, "beta = nan"),
        ({"eta": -1.0}, "eta = -1.0"),
        ({"weight_cost": -1.0}, "weight_cost = -1.0: must be at least 0"),
        ({"zero_error_radius": 1.0}, "zero_error_radius = 1.0: must be at least 0 and below 1"),
        ({"momentum": 1.0}, "momentum = 1.0"),
        ({"tol": float("nan")}, "tol = nan"),
        ({"domain": [(0.0, 1.0)]}, "for each of the 2 inputs"),
        ({"output_bounds": (1.0, 0.0)}, "output_bounds"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        PerceptronRegressor(**{**quick, **settings}).fit(X, Y)


def test_bad_data_are_named():
    model = PerceptronRegressor(**quick)
    with pytest.raises(ValueError, match="NaN"):
        model.fit(np.where(X > 1e7, np.nan, X), Y)
    with pytest.raises(InputError, match="too large"):
        model.fit(X[:3], np.array([1.5e308, 0.0, -1.5e308]))
    with pytest.raises(ValueError, match="weight"):
        model.fit(X, Y, sample_weight=np.zeros(400))
    with pytest.raises(ValueError, match="[Nn]egative"):
        model.fit(X, Y, sample_weight=np.full(400, -1.0))


def test_sweep_over_hidden_units():
    points = hidden_unit_sweep(X, Y, [1, 6], max_iter=60, n_starts=1, random_state=4)
    assert [point.hidden_units for point in points] == [1, 6]
    assert points[1].training_rms < 0.5 * points[0].training_rms
    assert points[1].held_out_rms < 0.5 * points[0].held_out_rms
    assert points == hidden_unit_sweep(X, Y, [1, 6], max_iter=60, n_starts=1, random_state=4)
    order = np.random.RandomState(4).permutation(400)
    alone = PerceptronRegressor(hidden_units=6, max_iter=60, n_starts=1, random_state=4)
    alone.fit(X[order[100:]], Y[order[100:]])
    assert points[1].held_out_rms == pytest.approx(rms(alone.predict(X[order[:100]]) - Y[order[:100]]))
    with pytest.raises(InputError, match="held_out = 1.0: must leave at least 2 of the 400 rows"):
        hidden_unit_sweep(X, Y, [1], held_out=1.0)


@pytest.mark.slow
@parametrize_with_checks([PerceptronRegressor(), PerceptronRegressor(solver="gradient", output="linear", eta=0.05)])
def test_estimator_contract(estimator, check):
    check(estimator)


def dead_band(X):
    """A valve that opens with a kink: the feature that the thesis' network smoothed."""
    return 3e-3 * np.tanh(np.maximum(X[:, 0] / 0.01 - 0.33, 0.0) * 6.0 * np.sqrt(1.05 - X[:, 1] / 2.01e7))


@pytest.mark.slow
@pytest.mark.parametrize("function", [valve, dead_band])
def test_no_worse_than_another_perceptron(function):
    rng = np.random.default_rng(8)
    train, test = (rng.uniform(size=(2000, 2)) * [0.01, 2e7] + [0.0, 1e5] for _ in range(2))
    y = function(train)
    ours = PerceptronRegressor().fit(train, y)
    scaled, scaled_test = ((rows - train.mean(axis=0)) / train.std(axis=0) for rows in (train, test))
    theirs = []
    for seed in range(3):
        other = MLPRegressor(
            hidden_layer_sizes=(15,), activation="logistic", solver="lbfgs", alpha=0.0, max_iter=1000, tol=0.0,
            random_state=seed,
        )  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            other.fit(scaled, (y - y.mean()) / y.std())
        theirs.append(rms(other.predict(scaled_test) * y.std() + y.mean() - function(test)))
    assert rms(ours.predict(test) - function(test)) < 1.5 * min(theirs)
