"""Learn a formula from a noisy table, with intervals that hold."""

import numpy as np

from polydraulic import AbductiveRegressor

rng = np.random.default_rng(0)
X = rng.uniform([500.0, 0.0], [2000.0, 40.0], size=(2000, 2))  # speed in rpm, load in N m
power = 1e-3 * X[:, 0] * X[:, 1] * (1.0 - 0.004 * X[:, 1]) + rng.normal(0.0, 0.3, 2000)

seen, new = slice(0, 1500), slice(1500, None)
learner = AbductiveRegressor(calibration=0.2, random_state=0).fit(X[seen], power[seen])
print(learner.equations())
estimate, low, high = learner.predict(X[new], return_interval=0.9)
rms = np.sqrt(np.mean((estimate - power[new]) ** 2))
covered = np.mean((low <= power[new]) & (power[new] <= high))
print(f"rms error {rms:.2f} on rows not seen, of which {covered:.0%} lie in their 90 % interval")

assert rms < 1.1 * 0.3  # little more than the noise, which nobody can predict
assert 0.85 < covered < 0.95
