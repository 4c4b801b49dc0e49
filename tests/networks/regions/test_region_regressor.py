import numpy as np
import pytest

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.errors import InputError
from polydraulic.networks import Split

RNG = np.random.default_rng(3)
X = RNG.uniform(-1.0, 1.0, size=(400, 2))
Y = X[:, 0] * X[:, 1] + X[:, 0]
STEP = np.where(X[:, 0] > 0.2, X[:, 1], 2.0)
quick = AbductiveRegressor(max_layers=1, kinds=("single", "double"))


def test_regions_fit_each_cell_alone():
    y = np.where(X[:, 0] > 0.2, X[:, 1] ** 3, 5.0)
    model = RegionRegressor(edges={0: [0.2]}).fit(X, y)
    assert model.predict(X) == pytest.approx(y, abs=1e-9)
    assert len(model.estimators_) == 2
    assert model.to_model().training["pse"][0] == 0.0


def test_region_domains_meet_at_the_edge():
    base = AbductiveRegressor(domain=[(-1.0, 1.0), (-1.0, 1.0)])
    model = RegionRegressor(base, edges={0: [0.2]}).fit(X, Y)
    assert [e.network_.x_high[0] for e in model.estimators_] == [0.2, 1.0]
    assert [e.network_.x_low[0] for e in model.estimators_] == [-1.0, 0.2]


@pytest.mark.parametrize(
    ("edges", "message"),
    [
        ({0: [0.5, 0.1]}, "must be rising finite numbers"),
        ({0: [float("nan")]}, "must be rising finite numbers"),
        ({5: [0.0]}, r"edges name the input 5; the inputs are \['x0', 'x1'\]"),
        ({"speed": [0.0]}, "edges name the input 'speed'"),
        ({0: [2.0]}, r"no rows with x0 in \(2, inf\)"),
        ({0: [X[:, 0].max() - 1e-9]}, r"region x0 in \(.*inf\): .*sample"),
    ],
)
def test_bad_edges_are_named(edges, message):
    with pytest.raises(ValueError, match=message):
        RegionRegressor(edges=edges).fit(X, Y)


def test_the_border_of_two_laws_is_found():
    found = RegionRegressor(quick).fit(X, STEP)
    assert isinstance(found.partition_, Split)
    assert found.partition_.axis == 0
    below, above = X[X[:, 0] <= 0.2, 0].max(), X[X[:, 0] > 0.2, 0].min()
    assert below < found.partition_.at < above
    assert found.predict(X) == pytest.approx(STEP, abs=1e-9)


def test_one_law_is_left_whole():
    noisy = Y + 0.1 * RNG.normal(size=len(Y))
    assert RegionRegressor(quick).fit(X, noisy).partition_ == 0
    assert RegionRegressor(quick, max_regions=1).fit(X, STEP).partition_ == 0
    assert RegionRegressor(quick, min_rows=201).fit(X, STEP).partition_ == 0
    assert RegionRegressor(quick, tolerance=10.0).fit(X, STEP).partition_ == 0


def test_regions_hold_so_many_rows():
    y = np.floor(3.0 * X[:, 0]) + np.floor(2.0 * X[:, 1])
    model = RegionRegressor(quick, max_regions=4, min_rows=60).fit(X, y)
    rows = [
        np.all((low < X) & (high >= X), axis=1).sum() for low, high in (b.T for b in model.to_model().region_boxes())
    ]
    assert len(rows) == 4
    assert min(rows) >= 60
    assert sum(rows) == len(X)


def test_other_rows_are_learnt_in_the_same_regions():
    found = RegionRegressor(quick).fit(X, STEP)
    other = found.refitted(X, 2.0 * STEP)
    assert other.partition_ == found.partition_
    assert other.predict(X) == pytest.approx(2.0 * STEP, abs=1e-9)
    assert found.predict(X) == pytest.approx(STEP, abs=1e-9)
    with pytest.raises(ValueError, match="1 features"):
        found.refitted(X[:, :1], STEP)
    with pytest.raises(InputError, match="no rows with"):
        found.refitted(X[X[:, 0] < 0.1], STEP[X[:, 0] < 0.1])


def test_found_regions_of_several_outputs_are_shared():
    Ys = np.column_stack([STEP, Y])
    found = RegionRegressor(quick).fit(X, Ys)
    one, other = found.to_models()
    assert one.partition == other.partition
    assert found.predict(X) == pytest.approx(np.column_stack([one.predict(X), other.predict(X)]))
    assert found.predict(X)[:, 0] == pytest.approx(STEP, abs=1e-9)
    assert found.score(X, Ys) > 0.99


def test_weights_act_like_repetitions_of_rows():
    weight = RNG.integers(0, 3, len(X))
    twice = np.repeat(np.arange(len(X)), weight)
    weighted = RegionRegressor(quick).fit(X, STEP, sample_weight=weight)
    repeated = RegionRegressor(quick).fit(X[twice], STEP[twice])
    assert weighted.partition_.at == pytest.approx(repeated.partition_.at)
    assert weighted.predict(X) == pytest.approx(repeated.predict(X), abs=1e-8)


def test_intervals_are_as_wide_as_each_region_needs():
    rng = np.random.default_rng(11)
    X = rng.uniform(-1.0, 1.0, size=(4000, 1))
    y = np.abs(X[:, 0]) + np.where(X[:, 0] > 0.0, 0.2, 0.02) * rng.normal(size=4000)
    base = AbductiveRegressor(max_layers=1, calibration=0.4, random_state=0)
    model = RegionRegressor(base, edges={0: [0.0]}).fit(X[:2000], y[:2000])
    estimate, low, high, inside = model.predict(X[2000:], return_interval=0.9, return_domain=True)
    assert np.all((low < estimate) & (estimate < high))
    assert inside.mean() > 0.99
    width = high - low
    right = X[2000:, 0] > 0.0
    assert width[right].min() > 5.0 * width[~right].max()
    for side in (right, ~right):
        assert np.mean(((low <= y[2000:]) & (y[2000:] <= high))[side]) == pytest.approx(0.9, abs=0.05)
    assert model.predict(np.array([[3.0]]), return_domain=True)[1].tolist() == [False]


def test_borrowed_rows_come_from_across_the_border():
    alone = RegionRegressor(quick, edges={0: [0.2]}).fit(X, STEP)
    borrowing = RegionRegressor(quick, edges={0: [0.2]}, borrow=0.2).fit(X, STEP)
    assert borrowing.estimators_[1].network_.x_low[0] < 0.2 < alone.estimators_[1].network_.x_low[0]
    assert np.abs(borrowing.predict(X) - STEP).max() > 0.1  # the other side's law is seen


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"max_regions": 0}, "max_regions = 0: must be a whole number"),
        ({"min_rows": 1.5}, "min_rows = 1.5"),
        ({"borrow": -0.1}, "borrow = -0.1"),
        ({"tolerance": float("nan")}, "tolerance = nan"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        RegionRegressor(**settings).fit(X, Y)
