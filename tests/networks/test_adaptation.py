import numpy as np
import pytest

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.errors import InputError
from polydraulic.networks import Adapter, Model, Network, Variable, dump_models, parse_models

RNG = np.random.default_rng(3)
X = RNG.uniform([0.0, 10.0, 5.0], [1.0, 30.0, 5.0 + 1e-300], size=(500, 3))
Y = X[:, 0] * (X[:, 1] - 10.0)
UNBOUNDED = Network((), (0.0,), (1.0,), (0.0,), (1.0,), 5.0, 1.0)
EVERYWHERE = RNG.uniform([-1.0, 0.0, 5.0], [2.0, 50.0, 5.0], size=(5000, 3))


@pytest.fixture(scope="module")
def learnt():
    return RegionRegressor(AbductiveRegressor(max_layers=2), edges={0: [0.5]}).fit(X, Y).to_model()


def span(model):
    return max(n.y_high for n in model.networks) - min(n.y_low for n in model.networks)


def worst(model, y):
    return np.abs(model.predict(X) - y).max()


def test_a_change_is_followed_and_undone(learnt):
    adapter = Adapter(learnt, trust=0.5, order=2, caution=0.1)
    changed = 0.8 * Y - 0.5 + 0.002 * (X[:, 1] - 20.0) ** 2
    adapter.update(X, changed)
    assert adapter.count == 500
    assert worst(learnt, changed) > 3.0
    assert worst(adapter.model(), changed) < 0.05
    before = adapter.snapshot()
    adapter.update(X, Y + 1.0)
    assert worst(adapter.model(), changed) > 0.2
    adapter.reset(before)
    assert worst(adapter.model(), changed) < 0.05
    adapter.reset()
    assert adapter.model() is learnt
    assert adapter.count == 0


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_adapted_model_is_what_the_coefficients_say(learnt, order):
    adapter = Adapter(learnt, trust=0.9, order=order)
    adapter.update(X, 0.7 * Y + 0.3 * X[:, 0])
    coef, model = adapter.coefficients(), adapter.model()
    inside = learnt.predict(X)
    region = (X[:, 0] > 0.5).astype(int)
    box = learnt.domain()
    t = 2.0 * (X[:, :2] - box[:2, 0]) / np.diff(box[:2]).T - 1.0
    powers = np.cos(np.arange(1, order + 1) * np.arccos(np.clip(t, -1, 1))[..., None]).reshape(len(X), -1)
    product = t[:, :1] * t[:, 1:] if order > 1 else np.empty((len(X), 0))
    low = min(n.y_low for n in learnt.networks)
    features = np.column_stack(
        [np.ones(len(X)), (inside - low - span(learnt) / 2) / (span(learnt) / 2), powers, product]
    )
    expected = inside + np.sum(features * coef[region], axis=1)
    ends = np.array([(n.y_low, n.y_high) for n in learnt.networks])[region].T
    assert np.abs(model.predict(X) - np.clip(expected, *ends)).max() < 1e-9 * span(learnt)
    assert parse_models(dump_models([model]), "m.json") == [model]


@pytest.mark.parametrize("trust", [0.05, 0.4, 1.0])
def test_the_adapted_model_stays_within_its_trust_everywhere(learnt, trust):
    adapter = Adapter(learnt, trust=trust, order=3, caution=1e-3)
    adapter.update(X, RNG.uniform(-1e3, 1e3, size=len(X)))
    moved = np.abs(adapter.model().predict(EVERYWHERE) - learnt.predict(EVERYWHERE))
    assert moved.max() <= trust * span(learnt) * (1.0 + 1e-12)
    adapter.reset()
    adapter.update(X, np.full(len(X), 1e6))
    moved = np.abs(adapter.model().predict(EVERYWHERE) - learnt.predict(EVERYWHERE))
    assert 0.5 * trust * span(learnt) < moved.max() <= trust * span(learnt) * (1.0 + 1e-12)


def test_rows_one_by_one_are_the_same_as_together_and_as_weighted_least_squares(learnt):
    one, all_at_once = (Adapter(learnt, forgetting=0.98) for _ in range(2))
    all_at_once.update(X[:60], 0.9 * Y[:60])
    for x, y in zip(X[:60], 0.9 * Y[:60], strict=True):
        one.update(x[None], [y])
    assert np.allclose(one.coefficients(), all_at_once.coefficients(), rtol=1e-9, atol=1e-12)
    rows = X[:60, 0] <= 0.5
    weight = 0.98 ** np.arange(59, -1, -1)
    assert one.snapshot().gram[0, 0, 0] == pytest.approx(weight[rows].sum())


def test_old_measurements_are_forgotten(learnt):
    adapter = Adapter(learnt, forgetting=0.99, trust=0.5)
    adapter.update(X, 0.8 * Y)
    after_change = worst(adapter.model(), Y)
    for _ in range(4):
        adapter.update(X, Y)
    assert worst(adapter.model(), Y) < 0.02 * after_change
    never = Adapter(learnt, forgetting=1.0, trust=0.5)
    never.update(X, 0.8 * Y)
    never.update(X, Y)
    assert worst(never.model(), Y) > 0.3 * after_change


def test_a_region_without_measurements_follows_the_others(learnt):
    low = X[:, 0] <= 0.5
    adapter = Adapter(learnt, trust=0.5)
    adapter.update(X[low], 0.8 * Y[low])
    errors = [np.sqrt(np.mean((model.predict(X[~low]) - 0.8 * Y[~low]) ** 2)) for model in (learnt, adapter.model())]
    assert errors[1] < 0.5 * errors[0]


def test_a_target_on_a_bound_is_met_by_an_answer_beyond_it():
    y = np.minimum(Y, 5.0)
    fitted = AbductiveRegressor(output_bounds=(0.0, 5.0)).fit(X, y).to_model()
    adapter = Adapter(fitted)
    beyond = (Y > 8.0) & (adapter._free.predict(X) > 5.0)
    assert beyond.any()
    adapter.update(X[beyond], y[beyond])
    assert adapter.model() is fitted


def test_a_product_of_two_inputs_is_learnt_with_second_powers(learnt):
    whole = AbductiveRegressor(max_layers=2).fit(X, X[:, 0] + 0.1 * X[:, 1]).to_model()
    changed = X[:, 0] + 0.1 * X[:, 1] - 0.05 * X[:, 0] * (X[:, 1] - 10.0)
    left = []
    for order in (1, 2):
        adapter = Adapter(whole, trust=0.9, order=order, caution=1e-3)
        adapter.update(X, changed)
        left.append(worst(adapter.model(), changed))
    assert left[0] > 0.1
    assert left[1] < 1e-3


def test_noise_on_a_bound_is_no_news():
    y = np.minimum(Y, 5.0)
    fitted = AbductiveRegressor(output_bounds=(0.0, 5.0)).fit(X, y).to_model()
    beyond = (Y > 8.0) & (Adapter(fitted)._free.predict(X) > 5.5)
    assert beyond.sum() > 30
    read = y[beyond] - 0.1 * np.abs(RNG.normal(size=beyond.sum()).clip(-2.9, 2.9))
    harmed, aware = Adapter(fitted), Adapter(fitted, noise=0.1)
    for adapter in (harmed, aware):
        adapter.update(X[beyond], read)
    assert aware.model() is fitted
    assert np.abs(harmed.model().predict(X) - fitted.predict(X)).max() > 0.1


def test_the_other_end_of_a_range_is_news_however_large_the_noise():
    fitted = AbductiveRegressor(output_bounds=(0.0, 5.0)).fit(X, np.minimum(Y, 5.0)).to_model()
    high = Adapter(fitted)._free.predict(X) > 2.6
    adapter = Adapter(fitted, noise=10.0)
    adapter.update(X[high], np.full(high.sum(), 4.9))
    assert adapter.model() is fitted
    adapter.update(X[high], np.zeros(high.sum()))
    assert adapter.model().predict(X[high]).mean() < fitted.predict(X[high]).mean() - 0.1


def test_weights_count_and_rows_without_weight_only_let_time_pass(learnt):
    weighted, repeated, aged = (Adapter(learnt, forgetting=forgetting) for forgetting in (1.0, 1.0, 0.9))
    weighted.update(X[:50], 0.9 * Y[:50], np.full(50, 3.0))
    for _ in range(3):
        repeated.update(X[:50], 0.9 * Y[:50])
    assert np.allclose(weighted.coefficients(), repeated.coefficients(), rtol=1e-9, atol=1e-12)
    aged.update(X[:50], 0.9 * Y[:50])
    before = aged.snapshot()
    aged.update(np.full((10, 3), np.nan), np.full(10, np.nan), np.zeros(10))
    assert aged.count == 50
    assert np.allclose(aged.snapshot().gram, 0.9**10 * before.gram, rtol=1e-12)
    assert np.allclose(aged.snapshot().moment, 0.9**10 * before.moment, rtol=1e-12)


def test_a_constant_is_moved():
    network = Network((), (0.0,), (1.0,), (2.0,), (2.0,), 5.0, 1.0, 0.0, 10.0)
    adapter = Adapter(Model((Variable("x"),), Variable("y"), (network,)))
    adapter.update(np.full((1000, 1), 2.0), np.full(1000, 6.0))
    assert adapter.model().predict([[2.0]])[0] == pytest.approx(6.0, abs=0.03)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"forgetting": 0.0}, "forgetting = 0.0"),
        ({"forgetting": 1.1}, "forgetting = 1.1"),
        ({"trust": 0.0}, "trust = 0.0"),
        ({"trust": 1.5}, "trust = 1.5"),
        ({"order": 4}, "order = 4"),
        ({"caution": 0.0}, "caution = 0.0"),
        ({"noise": -1.0}, "noise = -1.0"),
        ({"noise": np.nan}, "noise = nan"),
        ({"model": Model((Variable("x"),), Variable("y"), (UNBOUNDED,))}, "needs finite ones"),
    ],
)
def test_settings_out_of_range_are_one_clear_error(learnt, change, message):
    with pytest.raises(InputError, match=message):
        Adapter(**{"model": learnt} | change)


def test_measurements_must_be_finite_and_fit(learnt):
    adapter = Adapter(learnt)
    for x, y in ((X, Y[:5]), (X, np.where(Y > 5.0, np.nan, Y)), (X[:, :2], Y), (np.where(X > 20.0, np.inf, X), Y)):
        with pytest.raises(InputError, match="must be|finite"):
            adapter.update(x, y)
    for weight in (np.ones(3), np.full(len(X), -1.0), np.full(len(X), np.nan)):
        with pytest.raises(InputError, match="weight has shape"):
            adapter.update(X, Y, weight)
    assert adapter.count == 0
    with pytest.raises(InputError, match="snapshot is of another model"):
        adapter.reset(Adapter(learnt, order=2).snapshot())
