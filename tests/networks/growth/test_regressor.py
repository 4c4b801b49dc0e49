from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.errors import InputError
from polydraulic.networks import AbductiveClassifier, PerceptronRegressor, Variable
from polydraulic.networks.growth import one_output
from polydraulic.networks.growth.refine import refine

RNG = np.random.default_rng(11)
X = RNG.uniform(-1.0, 1.0, size=(200, 2))
Y = np.exp(X[:, 0]) * X[:, 1]


@pytest.fixture(scope="module")
def plain():
    return AbductiveRegressor(max_layers=2).fit(X, Y)


@given(st.floats(0.1, 1e3), st.floats(-100.0, 100.0), st.floats(0.1, 1e3))
def test_units_do_not_matter(plain, scale, shift, y_scale):
    other = AbductiveRegressor(max_layers=2).fit(X * scale + shift, Y * y_scale)
    assert other.predict(X * scale + shift) / y_scale == pytest.approx(plain.predict(X), abs=1e-5)


def test_weights_act_like_repetitions():
    weight = RNG.integers(0, 3, 200)
    repeated = np.repeat(np.arange(200), weight)
    weighted = AbductiveRegressor().fit(X, Y, sample_weight=weight)
    twice = AbductiveRegressor().fit(X[repeated], Y[repeated])
    assert weighted.predict(X) == pytest.approx(twice.predict(X), abs=1e-8)
    assert weighted.pse_ == pytest.approx(twice.pse_, rel=1e-6)


def test_inputs_stay_in_the_domain_and_outputs_in_their_bounds():
    model = AbductiveRegressor(output_bounds=(-0.5, 0.5)).fit(X, Y)
    far = model.predict(np.array([[50.0, 50.0], [X[:, 0].max(), X[:, 1].max()]]))
    assert far[0] == far[1]
    assert np.abs(model.predict(X)).max() <= 0.5
    wide = AbductiveRegressor(domain=[(-2.0, 2.0), (-1.0, 1.0)]).fit(X, Y)
    assert wide.network_.x_high == (2.0, 1.0)


def test_a_constant_column_is_never_chosen():
    model = AbductiveRegressor().fit(np.column_stack([X, np.full(200, 7.0)]), Y)
    assert all(2 not in node.inputs for node in model.network_.nodes)


def test_a_constant_target_needs_no_network():
    model = AbductiveRegressor().fit(X, np.full(200, 3.5))
    assert model.predict(X[:2]).tolist() == [3.5, 3.5]


def test_fitting_twice_gives_the_same_network():
    assert AbductiveRegressor().fit(X, Y).network_ == AbductiveRegressor().fit(X, Y).network_


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"max_layers": 0}, "max_layers = 0: must be a whole number, at least 1"),
        ({"n_survivors": 2.5}, "n_survivors = 2.5"),
        ({"cpm": -1.0}, "cpm = -1.0: must be at least 0"),
        ({"cpm": float("nan")}, "cpm = nan"),
        ({"cpm": np.inf}, "cpm = inf: must be at least 0 and finite"),
        ({"prior_variance": "half"}, "prior_variance = 'half': 'adaptive', 'half-variance' or a number"),
        ({"prior_variance": -2.0}, "prior_variance = -2.0: must be at least 0"),
        ({"prior_variance": np.inf}, "prior_variance = inf: must be at least 0 and finite"),
        ({"kinds": ("quadruple",)}, "kinds = .*must be one or more of"),
        ({"kinds": ()}, "kinds = .*must be one or more of"),
        ({"domain": [(0.0, 1.0)]}, "for each of the 2 inputs"),
        ({"output_bounds": (1.0, 0.0)}, "output_bounds"),
        ({"output_bounds": "wide"}, "output_bounds = 'wide'"),
        ({"missing": "guess"}, "missing = 'guess': must be one of"),
        ({"calibration": 1.0}, "calibration = 1.0"),
        ({"max_inputs": 0}, "max_inputs = 0"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(ValueError, match=message):
        AbductiveRegressor(**settings).fit(X, Y)


def test_outputs_stay_near_the_data_unless_told_otherwise():
    corner = np.array([[X[:, 0].max(), X[:, 1].max()]])
    y = np.where(X.sum(axis=1) > 1.0, 0.0, Y)
    model = AbductiveRegressor().fit(X, y)
    margin = 0.1 * np.ptp(y)
    assert model.network_.y_low == pytest.approx(y.min() - margin)
    assert model.network_.y_high == pytest.approx(y.max() + margin)
    assert y.min() - margin <= model.predict(corner)[0] <= y.max() + margin


def test_several_outputs_are_several_networks():
    both = np.column_stack([Y, X[:, 0]])
    model = AbductiveRegressor(max_layers=2).fit(X, both)
    assert model.predict(X).shape == (200, 2)
    alone = AbductiveRegressor(max_layers=2).fit(X, Y)
    assert model.predict(X)[:, 0] == pytest.approx(alone.predict(X), abs=1e-12)
    assert model.networks_[0] == alone.network_
    assert [m.output.name for m in model.to_models()] == ["y0", "y1"]
    assert model.fse_.shape == (2,)


def test_equations_name_every_node():
    model = AbductiveRegressor(max_layers=2).fit(X, Y)
    lines = model.equations().splitlines()
    assert len(lines) == 2 + len(model.network_.nodes) + 1
    assert lines[-1].startswith("y = ")


def test_rows_outside_the_domain_are_told():
    model = AbductiveRegressor().fit(X, Y)
    y, inside = model.predict(np.array([[0.0, 0.0], [3.0, 0.0]]), return_domain=True)
    assert y.shape == (2,)
    assert inside.tolist() == [True, False]


@pytest.mark.parametrize("coverage", [0.5, 0.9])
def test_intervals_cover_what_they_state(coverage):
    rng = np.random.default_rng(3)
    inputs = rng.uniform(-1.0, 1.0, size=(4000, 2))
    target = np.exp(inputs[:, 0]) * inputs[:, 1] + rng.standard_t(3, size=4000) * 0.2
    model = AbductiveRegressor(calibration=0.3, random_state=0, max_layers=2).fit(inputs[:1500], target[:1500])
    y, low, high = model.predict(inputs[1500:], return_interval=coverage)
    covered = np.mean((low <= target[1500:]) & (target[1500:] <= high))
    assert covered == pytest.approx(coverage, abs=0.04)
    assert np.all((low <= y) & (y <= high))


def test_intervals_need_held_out_rows():
    with pytest.raises(ValueError, match="needs at least 9 held-out rows; this model has 0"):
        AbductiveRegressor().fit(X, Y).predict(X, return_interval=0.9)
    with pytest.raises(ValueError, match="coverage = 1.0: must lie between 0 and 1"):
        AbductiveRegressor(calibration=0.2).fit(X, Y).predict(X, return_interval=1.0)


def test_missing_values_by_choice():
    holes = X.copy()
    holes[::7, 0] = np.nan
    with pytest.raises(ValueError, match="NaN"):
        AbductiveRegressor().fit(holes, Y)
    dropped = AbductiveRegressor(missing="drop").fit(holes, Y)
    kept = ~np.isnan(holes).any(axis=1)
    assert dropped.network_ == AbductiveRegressor().fit(X[kept], Y[kept]).network_
    with pytest.raises(ValueError, match="NaN"):
        dropped.predict(holes)
    imputed = AbductiveRegressor(missing="impute").fit(holes, Y)
    mean = np.nanmean(holes[:, 0])
    assert imputed.predict(np.array([[np.nan, 0.5]])) == imputed.predict(np.array([[mean, 0.5]]))
    with pytest.raises(ValueError, match="input 1 has no value at all"):
        AbductiveRegressor(missing="impute").fit(np.column_stack([X[:, 0], np.full(200, np.nan)]), Y)


def test_the_promising_of_many_inputs_are_found():
    rng = np.random.default_rng(5)
    wide = rng.normal(size=(400, 60))
    y = wide[:, 3] * wide[:, 47] + 0.5 * wide[:, 20] ** 3
    model = AbductiveRegressor(max_inputs=8, max_layers=2).fit(wide, y)
    used = {slot for node in model.network_.nodes for slot in node.inputs if slot < 60}
    assert {3, 47, 20} <= used
    assert model.score(wide, y) > 0.95


@pytest.mark.slow
def test_a_thousand_columns():
    rng = np.random.default_rng(6)
    wide = rng.normal(size=(1500, 1000))
    y = wide[:, 3] * wide[:, 777]
    model = AbductiveRegressor(max_layers=1).fit(wide, y)
    assert {slot for node in model.network_.nodes for slot in node.inputs} >= {3, 777}


def test_growth_is_logged_and_nothing_printed(caplog, capsys):
    with caplog.at_level("DEBUG", logger="polydraulic"):
        AbductiveRegressor(max_layers=2).fit(X, Y)
    told = [(record.levelname, record.getMessage().split(",")[0].split(":")[0]) for record in caplog.records]
    assert told[:2] == [("INFO", "layer 0"), ("INFO", "layer 1")]
    assert ("DEBUG", "refinement 0") in told
    assert capsys.readouterr() == ("", "")


def test_bad_data_are_named():
    with pytest.raises(ValueError, match="at least 4 rows"):
        AbductiveRegressor().fit(X[:3], Y[:3])
    with pytest.raises(ValueError, match="NaN"):
        AbductiveRegressor().fit(np.where(X > 0.99, np.nan, X), Y)
    with pytest.raises(ValueError, match="infinity"):
        AbductiveRegressor().fit(X, np.where(Y > 1.0, np.inf, Y))


def test_names_must_fit():
    with pytest.raises(ValueError, match="1 input names for a model with 2 inputs"):
        AbductiveRegressor().fit(X, Y).to_model([Variable("x")])


def test_weights_that_sum_to_less_than_a_network_needs_are_named():
    with pytest.raises(ValueError, match="the weights sum to 1: .* repetitions of its row"):
        AbductiveRegressor().fit(X, Y, np.full(200, 1.0 / 200.0))
    with pytest.raises(ValueError, match="the weights sum to 2e.302: .* divide the weights by their mean"):
        AbductiveRegressor().fit(X, Y, np.full(200, 1e300))
    with pytest.raises(ValueError, match="the weights sum to"):
        AbductiveRegressor().fit(X, Y, np.geomspace(1e-150, 1e150, 200))
    with pytest.warns(UserWarning, match="the weights of 200 rows sum to 10: .* divide the weights by their mean"):
        AbductiveRegressor().fit(X, Y, np.full(200, 0.05))


@pytest.mark.parametrize("weight", [np.geomspace(1e-290, 1e10, 200), np.where(X[:, 0] > 0.0, 1.0, 5e-324)])
def test_weights_beside_which_others_do_not_count_are_refused_by_every_learner(weight):
    edges = {1: [0.0]}
    for learner in (AbductiveRegressor(), RegionRegressor(edges=edges), AbductiveClassifier(), PerceptronRegressor()):
        with pytest.raises(InputError, match="the weights reach from .* does not count; give these rows the weight 0"):
            learner.fit(X, Y > 0.0, weight)
    with pytest.raises(InputError, match="the weights reach from"):
        AbductiveRegressor().fit_blocks([(X[:100], Y[:100], weight[:100]), (X[100:], Y[100:], weight[100:])])
    counted = np.where(weight > 1e-13 * weight.max(), weight, 0.0)
    few = AbductiveRegressor(max_layers=1).fit(X, Y, counted)
    assert np.average((few.predict(X) - Y) ** 2, weights=counted) < 0.1 * np.average(Y**2, weights=counted)


def test_offsets_and_scales_of_any_size_are_learnt():
    plain = AbductiveRegressor(max_layers=2).fit(X, Y).predict(X)
    for scale in (1e-300, 1e-200, 1e-100, 1e100):
        assert AbductiveRegressor(max_layers=2).fit(X * scale, Y).predict(X * scale) == pytest.approx(plain, abs=1e-5)
        assert AbductiveRegressor(max_layers=2).fit(X, Y * scale).predict(X) / scale == pytest.approx(plain, abs=1e-5)
    number = AbductiveRegressor(max_layers=2, prior_variance=1e-300).fit(X, Y * 1e-200)
    assert np.isfinite(number.predict(X)).all()
    rounded = X + 1e12  # to four digits
    assert AbductiveRegressor().fit(rounded, Y).score(rounded, Y) > 0.999
    assert AbductiveRegressor().fit(X, Y + 1e12).score(X, Y + 1e12) > 0.999


def test_what_cannot_be_learnt_is_named():
    with pytest.raises(ValueError, match="a column varies by less than 2.2e-308"):
        AbductiveRegressor().fit(X * 1e-312, Y)
    with pytest.warns(UserWarning, match=r"input 1 varies by .* about 1e\+12, which is no more than rounding"):
        AbductiveRegressor().fit(X * [1.0, 3e-4] + [0.0, 1e12], Y)
    AbductiveRegressor().fit(X, np.where(Y.mean() < Y, 0.1, np.nextafter(0.1, 1.0)))  # a constant and its last digit
    with pytest.warns(UserWarning, match="the target varies by"):
        AbductiveRegressor().fit(X, 1e-4 * Y + 1e12)


def test_of_very_many_rows_a_sample_does_all_but_the_last_steps(monkeypatch):
    rng = np.random.default_rng(4)
    X = rng.uniform(-1.0, 1.0, (6000, 3))
    truth = np.sin(2.0 * X[:, 0]) * X[:, 1] + X[:, 2] ** 2
    y = truth + 0.1 * rng.normal(size=6000)
    whole = AbductiveRegressor(max_layers=2).fit(X, y)
    monkeypatch.setattr(one_output, "_MANY", 5000)
    monkeypatch.setattr(one_output, "_SAMPLE", 2000)
    sampled = AbductiveRegressor(max_layers=2).fit(X, y)
    assert sampled.network_ != whole.network_
    errors = [float(np.sqrt(np.mean((model.predict(X) - truth) ** 2))) for model in (sampled, whole)]
    assert errors[0] < 1.15 * errors[1] < 0.03
    weighted = AbductiveRegressor(max_layers=2).fit(X, y, np.full(6000, 2.0))
    assert weighted.fse_ == pytest.approx(whole.fse_, rel=0.05)


def test_a_refinement_that_only_fits_its_sample_is_made_again_with_all_rows(monkeypatch):
    rng = np.random.default_rng(4)
    X = rng.uniform(-1.0, 1.0, (6000, 3))
    y = np.sin(2.0 * X[:, 0]) * X[:, 1] + X[:, 2] ** 2
    monkeypatch.setattr(one_output, "_MANY", 5000)
    monkeypatch.setattr(one_output, "_SAMPLE", 2000)
    calls = []

    def spoilt(nodes, rows, bounds, **options):
        calls.append(rows.scaling.n_row)
        found, fse = refine(nodes, rows, bounds, **options)
        return found, fse if len(calls) != 2 else 1.0

    monkeypatch.setattr(one_output, "refine", spoilt)
    model = AbductiveRegressor(max_layers=2).fit(X, y)
    assert calls == [2000, 6000, 6000]
    assert model.fse_ < 1e-4


def test_fits_of_several_threads_at_once_have_the_bits_of_one_alone():
    """Products are so large that their last digits would tell how many threads share them."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=(400, 5))
    y = x[:, 0] * x[:, 1] + np.sin(x[:, 2]) + 0.1 * rng.normal(size=400)
    weight = rng.uniform(0.0, 2.0, size=400)

    def fitted(rows):
        model = AbductiveRegressor(max_layers=2, refine=False)
        return model.fit(x[:rows], y[:rows], sample_weight=weight[:rows]).predict(x)

    sizes = [400, 350, 390, 400]
    alone = [fitted(size) for size in sizes]
    with ThreadPoolExecutor(2) as pool:
        for found, expected in zip(pool.map(fitted, sizes), alone, strict=True):
            assert np.array_equal(found, expected)
