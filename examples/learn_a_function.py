"""Learn a function to a tolerance, and prove that the answer can never leave its physical range."""

import numpy as np

from polydraulic import AbductiveRegressor
from polydraulic.networks import Variable, check_range, learn_from


def orifice(X):
    """Flow in l/min through an orifice that opens at 2 mm, of travel in mm and pressure drop in bar."""
    return 12.0 * np.maximum(X[:, 0] - 2.0, 0.0) * np.sqrt(X[:, 1] / 100.0)


found = learn_from(
    orifice, [(0.0, 8.0), (20.0, 200.0)], tolerance=0.5, estimator=AbductiveRegressor(output_bounds=(0.0, 120.0)),
    inputs=[Variable("travel", "mm"), Variable("drop", "bar")], output=Variable("flow", "l/min"),
)  # fmt: skip
print(f"{len(found.model.networks)} regions, largest error found {found.largest:.2f} l/min")
print(check_range(found.model, 0.0, 120.0))

X = np.random.default_rng(0).uniform([0.0, 20.0], [8.0, 200.0], size=(10_000, 2))
assert found.converged
assert np.abs(found.model.predict(X) - orifice(X)).max() < 1.0  # points that the search did not choose
assert check_range(found.model, 0.0, 120.0).holds
