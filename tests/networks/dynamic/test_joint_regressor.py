from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from helpers.joint_log import joint_log
from polydraulic import load_models, save_models
from polydraulic.errors import InputError
from polydraulic.networks import JointRegressor, Variable, free_run, model_bounds
from polydraulic.networks.model.nodes import RAMP


def parts(log):
    return (
        log.matrix(["lever.a", "lever.b"]),
        log.matrix(["a", "b"]),
        np.cumsum(np.diff(log["time"], prepend=0.0) > 1.0),
    )


@pytest.fixture(scope="module")
def fitted():
    X, y, segments = parts(joint_log())
    return JointRegressor(horizon=100, max_terms=10, raster=0.05).fit(X, y, segments)


def test_a_new_log_is_run_for_half_a_minute(fitted):
    X, y, _ = parts(joint_log(seed=1, gap=False))
    span = np.ptp(y, axis=0)
    run = fitted.simulate(X, y, horizon=600)
    last = np.arange(fitted.warm_up_ + 599, len(y), 600)
    assert (np.abs(run - y)[last].mean(axis=0) < 0.05 * span).all()
    held = np.abs(y[600:] - y[:-600]).mean(axis=0)
    assert (np.abs(run - y)[last].mean(axis=0) < 0.15 * held).all()


def test_a_joint_rests_within_its_dead_zone_and_ends_at_its_stop(fitted):
    n = 800
    X, y = np.zeros((n, 2)), np.full((n, 2), 0.4)
    X[:, 0] = 0.15
    assert fitted.simulate(X, y)[-1] == pytest.approx([0.4, 0.4], abs=1e-9)
    X[:, 0] = 1.0
    assert fitted.simulate(X, y)[-1, 0] == pytest.approx(1.2, abs=0.02)  # the stop of the log
    X[:, 0], X[:, 1] = 0.0, 1.0
    far = fitted.simulate(X, y)[-1, 1]
    assert far + 0.02 >= 2.0
    assert far < 2.6


def test_joints_see_each_other(fitted):
    reads = [{lag.signal for lag in model.dynamics.lags} for model in fitted.models_]
    assert all({"x0", "x1"} <= read for read in reads)  # they share a pump
    assert all(model.n_coefficients < 300 for model in fitted.models_)


def test_play_is_in_the_network_as_it_was_found():
    n = 1200
    lever = np.sin(0.05 * np.arange(n)) + 0.5 * np.sin(0.131 * np.arange(n) + 1.0)
    valve, joint = 0.0, np.zeros(n)
    for t in range(1, n):
        valve = np.clip(valve, lever[t - 1] - 0.12, lever[t - 1] + 0.12)
        joint[t] = joint[t - 1] + 0.02 * (max(valve - 0.2, 0.0) - max(-0.3 - valve, 0.0))
    model = JointRegressor(horizon=100, max_terms=1).fit(lever[:, None], joint)
    assert model.responses_[0].play == pytest.approx(0.24, abs=0.05)
    first = model.warm_up_
    assert first > 2 * 16  # play is remembered for longer than the longest lag
    moved = (always_usual(model).simulate(lever[:, None], joint, horizon=1) - np.concatenate([[0.0], joint[:-1]]))[
        first:
    ]
    ramps = model.responses_[0].ramps(lever)[first:]
    powers = np.column_stack([ramps, ramps**2, ramps**3, ramps * joint[first - 1 : -1, None], ramps.prod(axis=1)])
    coef = np.linalg.lstsq(powers, moved, rcond=None)[0]
    assert np.abs(powers @ coef - moved).max() < 1e-9
    assert np.abs(model.simulate(lever[:, None], joint) - joint).max() < 0.05 * np.ptp(joint)


def test_the_model_is_one_like_any_other(fitted, tmp_path):
    names = [Variable("lever.a", "V"), Variable("lever.b", "V")], [Variable("a", "rad"), Variable("b", "m")]
    models = fitted.to_models(*names)
    save_models(models, tmp_path / "m.json")
    again = load_models(tmp_path / "m.json")
    assert [model.networks for model in again] == [model.networks for model in models]
    assert any(node.kind == RAMP for node in again[0].networks[0].nodes)
    log = joint_log(n=400, seed=2, gap=False)
    found = free_run(again, {name: log[name] for name in ("lever.a", "lever.b", "a", "b")})
    X, y, _ = parts(log)
    assert np.array_equal(np.column_stack([found["a"], found["b"]]), fitted.simulate(X, y))
    low, high = (getattr(model_bounds(models[0], max_boxes=50), end) for end in ("low", "high"))
    assert models[0].networks[0].y_low <= low < high <= models[0].networks[0].y_high


def always_usual(fitted):
    """The same joints, always as strong as in the mean."""
    found = copy(fitted)
    found.models_ = [replace(m, dynamics=replace(m.dynamics, strength=None)) for m in fitted.models_]
    return found


def test_a_slower_day_is_seen_in_measured_rows():
    days = [parts(joint_log(n=1500, seed=seed, gap=False, speed=speed)) for seed, speed in enumerate((1.0, 0.9, 1.1))]
    X, y = (np.concatenate([day[k] for day in days]) for k in (0, 1))
    fitted = JointRegressor(horizon=100, max_terms=1, raster=0.05).fit(X, y, np.repeat([0, 1, 2], 1500))
    assert all(0.05 < model.dynamics.strength.spread < 0.4 for model in fitted.models_)  # three days do not say more
    X, y, _ = parts(joint_log(seed=3, gap=False, speed=0.85))
    usual = always_usual(fitted)
    first = fitted.warm_up_ + 200
    runs = [one.simulate(X, y, horizon=200) for one in (fitted, usual)]
    assert np.array_equal(runs[0][:first], runs[1][:first])  # nothing was measured before it
    late, as_ever = (np.abs(run - y)[first + 200 :].mean(axis=0) for run in runs)
    assert (late < 0.7 * as_ever).all()
    assert np.array_equal(fitted.simulate(X, y), usual.simulate(X, y))


def test_a_gap_within_a_day_does_not_mix_its_strength_with_that_of_others():
    speeds = (1.0, 0.8, 1.2)
    days = [parts(joint_log(n=1000, seed=seed, gap=False, speed=speed)) for seed, speed in enumerate(speeds)]
    X, y = (np.concatenate([day[k] for day in days]) for k in (0, 1))
    logs = np.repeat([0, 1, 2], 1000)
    gaps = logs + (np.arange(3000) > 1100)  # a hundred rows of the second day stand before one
    learner = JointRegressor(horizon=100, max_terms=1, raster=0.05)
    strengths = [
        [model.dynamics.strength for model in learner.fit(X, y, segments, of).models_]
        for segments, of in ((logs, None), (gaps, logs), (None, logs), (gaps, None))
    ]
    days, with_gap, labelled, in_blocks = ([one.spread for one in found] for found in strengths)
    assert labelled == days
    assert with_gap == pytest.approx(days, rel=0.2)
    assert in_blocks != pytest.approx(days, rel=0.3)


def test_logs_need_a_label_for_each_row():
    X, y, segments = parts(joint_log(n=400))
    with pytest.raises(InputError, match=r"logs has shape \(3,\); it must hold one label for each of the 400 rows"):
        JointRegressor().fit(X, y, segments, [0, 1, 2])


def test_what_makes_no_sense_is_refused():
    X, y, segments = parts(joint_log(n=400))
    with pytest.raises(InputError, match="1 inputs for 2 joints"):
        JointRegressor().fit(X[:, :1], y, segments)
    with pytest.raises(InputError, match="horizon = 0: must be a whole number, at least 2"):
        JointRegressor(horizon=0).fit(X, y)
    with pytest.raises(InputError, match="1 signal_names for 4 inputs and joints"):
        JointRegressor(signal_names=["u"]).fit(X, y)
    with pytest.raises(InputError, match="y has shape"):
        JointRegressor().fit(X, y[:-1])
    with pytest.raises(InputError, match="rows are too few to choose from"):
        JointRegressor(n_blocks=40).fit(X, y, segments)
