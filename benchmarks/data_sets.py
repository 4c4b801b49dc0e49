"""Regression data sets for `networks.py`: made by formulas, shipped with scikit-learn, or read from a folder."""

from pathlib import Path

import numpy as np
from sklearn.datasets import load_diabetes, make_friedman1, make_friedman2, make_friedman3, make_regression


def all_sets(n_row, folder=None):
    """Name -> (X, y)."""
    made = {
        "friedman1": make_friedman1(n_row, noise=1.0, random_state=0),
        "friedman2": make_friedman2(n_row, noise=100.0, random_state=0),
        "friedman3": make_friedman3(n_row, noise=0.1, random_state=0),
        "diabetes": load_diabetes(return_X_y=True),
        "collinear": collinear(n_row),
        "raw units": raw_units(n_row),
        "sparse": sparse(n_row),
        "step": step(n_row),
    }
    return made | from_folder(folder)


def collinear(n_row):
    """Six columns, each of them three times with hardly any difference, and their sum."""
    X, y = make_regression(n_row, 6, n_informative=4, noise=20.0, random_state=0)
    tiny = np.random.default_rng(0).normal(scale=1e-6, size=(n_row, 12))
    X = np.hstack([X, np.hstack([X, X]) + tiny, X.sum(axis=1, keepdims=True)])
    return X, y + 0.1 * y.std() * X[:, 0] * X[:, 1]


def raw_units(n_row):
    """Columns far from zero, lognormal columns, pressures and micrometres."""
    rng = np.random.default_rng(1)
    z = rng.normal(size=(n_row, 6))
    X = np.column_stack([1000 + z[:, 0], np.exp(z[:, 1]), np.exp(z[:, 2]), 2e7 + 1e6 * z[:, 3], 1e-6 * z[:, 4:]])
    y = z[:, 0] * z[:, 3] + np.sqrt(X[:, 1]) + np.log1p(X[:, 2]) + 0.5 * z[:, 4] ** 2
    return X, 1e4 * (y + 0.2 * rng.normal(size=n_row))


def sparse(n_row):
    """Twenty columns of which most values are zero; three of them matter."""
    rng = np.random.default_rng(2)
    X = rng.normal(size=(n_row, 20)) * (rng.uniform(size=(n_row, 20)) < 0.2)
    return X, 2 * X[:, 0] + X[:, 1] ** 2 + 4 * X[:, 0] * X[:, 2] + 0.3 * rng.normal(size=n_row)


def step(n_row):
    """Jumps, which no polynomial follows."""
    rng = np.random.default_rng(3)
    X = rng.uniform(-1.0, 1.0, size=(n_row, 4))
    return X, np.sign(X[:, 0]) + (X[:, 1] > 0.3) * X[:, 2] + 0.1 * rng.normal(size=n_row)


def from_folder(folder):
    """Every CSV file with a line of names; the last column is the target, rows with gaps are left out."""
    found = {}
    for path in sorted(Path(folder).glob("*.csv")) if folder else []:
        table = np.genfromtxt(path, delimiter=",", skip_header=1)
        table = table[np.all(np.isfinite(table), axis=1)]
        found[path.name] = table[:, :-1], table[:, -1]
    return found
