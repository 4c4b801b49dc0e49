"""Small dynamic models that are exported as runs: two joints on commands that act late, one of them reading the other."""

import numpy as np

from polydraulic.networks import Dynamics, JointStrength, Lag, Model, Network, Node, Split, Variable
from polydraulic.networks.model.nodes import LINEAR

KNOWN = JointStrength(rows=20, spread=0.2, lean=0.1, memory=2000.0, noise=0.002)
NAMES = ["lift cmd", "tilt", "boom", "stick"]  # signals as a run takes them: inputs by name, outputs in their order


def joint(output, lags, coef, *, strength=None, raster=0.05, other=None):
    """A model that is linear in its lags; with `other` coefficients where the first one is above 0."""
    n = len(lags)
    networks = tuple(
        Network((Node(LINEAR, tuple(range(n)), tuple(c)),), (0.0,) * n, (1.0,) * n, (-1.5,) * n, (1.5,) * n, 0.0, 1.0, -1.4, 1.4)
        for c in (coef, other or coef)
    )  # fmt: skip
    partition, networks = (Split(0, 0.0, 0, 1), networks) if other else (0, networks[:1])
    dynamics = Dynamics(tuple(lags), (-0.2, 0.2), raster, strength)
    inputs = tuple(Variable(str(lag), "V" if lag.signal in NAMES[:2] else "rad") for lag in lags)
    return Model(inputs, Variable(output, "rad"), networks, partition, dynamics=dynamics)


def joints(**more):
    """A boom whose strength is followed, and a stick that reads it and its own command at once."""
    return [
        joint("boom", [Lag("lift cmd", 3), Lag("boom", 1)], [0.1, 1.0], strength=KNOWN, other=[0.08, 1.0], **more),
        joint("stick", [Lag("tilt", 0), Lag("boom", 2), Lag("stick", 1)], [0.05, -0.01, 0.99], **more),
    ]


def log(n, seed=0, strong=0.8):
    """Signals (n, 4) of a boom that is weaker than its model says, and a stick that is not."""
    rng = np.random.default_rng(seed)
    u, v = (np.repeat(rng.choice([-1.0, -0.4, 0.0, 0.4, 1.0], n // 8 + 1), 8)[:n] for _ in range(2))
    boom, stick = np.zeros(n), np.zeros(n)
    for t in range(3, n):
        boom[t] = np.clip(boom[t - 1] + strong * (0.1 if u[t - 3] < 0.0 else 0.08) * u[t - 3], -1.2, 1.2)
        stick[t] = 0.99 * stick[t - 1] + 0.05 * v[t] - 0.01 * boom[t - 2]
    signals = np.column_stack([u, v, boom, stick])
    signals[:, 2:] += rng.normal(0.0, 1e-3, (n, 2))
    return signals
