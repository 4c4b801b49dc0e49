import numpy as np

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.networks import compiled

X = np.random.default_rng(0).uniform(-1.0, 1.0, size=(300, 2))


def test_one_row_at_a_time_gives_the_same_bits():
    model = (
        RegionRegressor(AbductiveRegressor(max_layers=2), edges={0: [0.0]}).fit(X, np.abs(X[:, 0]) * X[:, 1]).to_model()
    )
    one = compiled(model)
    points = np.vstack([X[:40], [[0.0, 0.3], [5.0, -5.0]]])
    assert np.array_equal([one(row) for row in points], model.predict(points))
