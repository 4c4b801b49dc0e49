from dataclasses import replace

import numpy as np
import pytest

from polydraulic.networks import Dynamics, JointStrength, Lag, Model, Network, Node, Variable, free_run
from polydraulic.networks.dynamic.free_run import prepare_loop, strengths_before
from polydraulic.networks.dynamic.joint_strength import (
    Belief,
    after_window,
    learn_strength,
    strength_numbers,
    windows_of,
)
from polydraulic.networks.model.nodes import LINEAR

KNOWN = JointStrength(rows=20, spread=0.2, lean=0.1, memory=2000.0, noise=0.002)


def stretch(rng, both, lean, noise, n=400):
    """Windows of a joint that moves to and fro with a strength of its own, some of them through soil."""
    up, down = rng.uniform(0.0, 0.1, n), rng.uniform(0.0, 0.1, n)
    travel = (1.0 + both + lean) * up - (1.0 + both - lean) * down
    path = up + down
    errors = rng.normal(size=n) * np.sqrt(noise * path) * np.where(rng.uniform(size=n) < 0.05, 6.0, 1.0)
    return np.column_stack([up - down, path, travel + errors])


def test_how_stretches_differ_is_found():
    rng = np.random.default_rng(0)
    stretches = [stretch(rng, rng.normal(0.0, 0.1), rng.normal(0.0, 0.03), 1e-4, n=100) for _ in range(30)]
    found = learn_strength(stretches, 32, 200, 1.0)
    assert found.spread == pytest.approx(0.1, rel=0.3)
    assert found.lean == pytest.approx(0.03, rel=0.3)
    assert 0.3e-4 < found.noise < 3e-4  # of errors of which some are six times as large
    assert found.memory > 100 * 32  # none of them changed
    assert learn_strength([np.zeros((5, 3))], 32, 200, 1.0) is None
    assert learn_strength([], 32, 200, 1.0) is None
    assert learn_strength([np.zeros((0, 3))], 32, 200, 1.0) is None
    assert learn_strength([np.zeros((0, 3)), *stretches, np.zeros((0, 3))], 32, 200, 1.0) == found


def test_the_belief_is_that_of_least_squares_where_nothing_fades_and_errors_are_small():
    rng = np.random.default_rng(1)
    strength = replace(KNOWN, memory=1e12)
    windows = stretch(rng, 0.1, -0.05, 0.0, n=6)
    belief = Belief(0.0, 0.0, strength.spread**2, 0.0, strength.lean**2)
    for net, path, travel in windows:
        belief = after_window(belief, strength_numbers(strength), net, path, travel)
    X, y = windows[:, :2], windows[:, 2] - windows[:, 0]
    weighed = X.T / (strength.noise * windows[:, 1])
    covariance = np.linalg.inv(weighed @ X + np.diag([strength.spread**-2, strength.lean**-2]))
    assert belief[:2] == pytest.approx(covariance @ (weighed @ y), abs=1e-9)
    assert belief[2:] == pytest.approx([covariance[0, 0], covariance[0, 1], covariance[1, 1]], abs=1e-9)


def test_a_joint_that_soil_stopped_is_hardly_believed_to_be_weaker_and_rest_forgets():
    numbers = strength_numbers(KNOWN)
    start = Belief(0.0, 0.0, KNOWN.spread**2, 0.0, KNOWN.lean**2)
    slower = after_window(start, numbers, 0.1, 0.1, 0.09)
    stopped = after_window(start, numbers, 0.1, 0.1, 0.0)
    assert -0.09 < slower.both < -0.01
    assert 5.0 * slower.both < stopped.both < slower.both  # least squares would move ten times as far
    rested = slower
    for _ in range(2000):
        rested = after_window(rested, numbers, 0.0, 0.0, 0.0)
    assert rested == pytest.approx((0.0, 0.0, KNOWN.spread**2, 0.0, KNOWN.lean**2), abs=1e-6)


def test_windows_add_up_rates_and_leave_out_what_is_not_usable():
    rates, usable = np.tile([0.1, -0.2], 10), np.ones(20, dtype=bool)
    usable[9] = False
    joint = np.arange(20.0)
    found = windows_of(rates, joint, usable, 1, 20, 4)
    assert found.shape == (4, 3)
    assert found[[0, 1, 3]] == pytest.approx(np.array([[-0.2, 0.6, 4.0]] * 3))
    assert not found[2].any()


def joint(strength):
    """A joint that moves by a tenth of its command."""
    node = Node(LINEAR, (0, 1), (0.1, 1.0))
    network = Network((node,), (0.0, 0.0), (1.0, 1.0), (-1.0, -10.0), (1.0, 10.0), 0.0, 1.0, -10.0, 10.0)
    lags = (Lag("u", 0), Lag("y", 1))
    return Model(
        tuple(Variable(str(lag)) for lag in lags), Variable("y"), (network,), dynamics=Dynamics(lags, strength=strength)
    )


def travelled(up, down, n=600):
    """Commands, and a joint that is so strong each way."""
    u = np.sign(np.sin(0.05 * np.arange(n)))
    step = 0.1 * u * np.where(u > 0.0, up, down)
    return u, np.cumsum(step) - step[0]


def test_a_run_goes_by_how_strong_measured_rows_show_the_joint():
    u, y = travelled(0.8, 0.9)
    model, plain = joint(KNOWN), joint(None)
    loop = prepare_loop([model], ["u", "y"])
    (found,) = strengths_before(loop, np.column_stack([u, y]), [(400, 600)], [1])
    assert found[0] == pytest.approx([0.8, 0.9], abs=0.01)
    runs = [free_run([one], {"u": u, "y": y}, horizon=200)["y"] for one in (model, plain)]
    assert np.array_equal(*(run[:201] for run in runs))  # nothing was measured before it
    late = [np.abs(run - y)[401:].max() for run in runs]
    assert late[0] < 0.1 * late[1]
    assert np.array_equal(*(free_run([one], {"u": u, "y": y})["y"] for one in (model, plain)))


def test_windows_share_what_rows_before_them_show():
    u, y = travelled(0.8, 0.9)
    loop, signals = prepare_loop([joint(KNOWN)], ["u", "y"]), np.column_stack([u, y])
    windows, since = [(a, a + 50) for a in range(1, 550, 7)] + [(100, 150), (300, 350)], [1] * 79 + [1, 50]
    together = strengths_before(loop, signals, windows, since)
    alone = np.concatenate([strengths_before(loop, signals, [w], [s]) for w, s in zip(windows, since, strict=True)])
    assert np.array_equal(together, alone)
    assert np.array_equal(together[0], np.ones((1, 2)))


def test_strengths_and_runs_stay_within_bounds():
    u, y = travelled(0.01, 0.01)
    signals = np.column_stack([u, y])
    sure = prepare_loop([joint(replace(KNOWN, spread=5.0, noise=1e-6))], ["u", "y"])
    assert strengths_before(sure, signals, [(500, 600)], [1]).tolist() == [[[0.5, 0.5]]]
    model = joint(KNOWN)
    model = replace(model, dynamics=replace(model.dynamics, step=(-0.05, 0.05)))
    fast = np.cumsum(0.2 * u)
    run = free_run([model], {"u": u, "y": fast}, horizon=100)["y"]
    inside = np.arange(len(run)) % 100 != 1
    assert np.abs(np.diff(run, prepend=0.0))[inside].max() <= 0.05 + 1e-12
    far = free_run([joint(KNOWN)], {"u": np.ones(600), "y": 0.15 * np.arange(600.0) - 80.0}, horizon=300)["y"]
    assert far.max() <= 10.0


def test_a_joint_at_its_end_says_nothing_of_its_strength():
    u, y = np.ones(200), np.full(200, 10.0)
    loop = prepare_loop([joint(KNOWN)], ["u", "y"])
    found = strengths_before(loop, np.column_stack([u, y]), [(150, 200)], [1])
    assert found.tolist() == [[[1.0, 1.0]]]
