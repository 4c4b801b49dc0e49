import numpy as np

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.networks import DynamicRegressor
from polydraulic.networks.dynamic.refine_free_run import refine_over_steps


def noisy(n=400):
    """First order, measured with noise: one-step fits take the pole for too fast."""
    rng = np.random.default_rng(2)
    u, y = rng.choice([-1.0, 1.0], size=(n, 1)), np.zeros(n)
    for t in range(1, n):
        y[t] = 0.95 * y[t - 1] + 0.1 * u[t - 1, 0]
    return u, y + rng.normal(scale=0.1, size=n), y


def test_refinement_over_steps_mends_what_noise_does_to_one_step_fits():
    u, measured, y = noisy()
    fixed = {"input_lags": [1], "output_lags": [1], "increments": False}
    errors = []
    for horizon in (None, 40):
        model = DynamicRegressor(AbductiveRegressor(max_layers=1), horizon=horizon, **fixed).fit(u, measured)
        errors.append(np.sqrt(np.mean((model.simulate(u, y) - y) ** 2)))
    assert errors[1] < 0.5 * errors[0]


def test_all_networks_of_a_model_move_and_nothing_else():
    u, measured, _ = noisy()
    learner = RegionRegressor(AbductiveRegressor(max_layers=1), edges={0: [0.0]})
    model = DynamicRegressor(learner, input_lags=[1], output_lags=[1], increments=False, horizon=None).fit(u, measured)
    (before,) = model.models_
    signals = np.column_stack([u, measured])
    (after,) = refine_over_steps([before], ["x0", "y"], signals, [(1, 400)], 40)
    assert after.partition == before.partition
    for old, new in zip(before.networks, after.networks, strict=True):
        assert (old.x_mean, old.y_high, len(old.nodes)) == (new.x_mean, new.y_high, len(new.nodes))
        for a, b in zip(old.nodes, new.nodes, strict=True):
            assert (a.kind, a.inputs) == (b.kind, b.inputs)
            assert [c == 0.0 for c in a.coef] == [c == 0.0 for c in b.coef]
            assert a.coef != b.coef
