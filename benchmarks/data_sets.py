"""Regression data sets for `networks.py`: made by formulas, shipped with scikit-learn, or read from a folder.

They are a sample of what people have and of what breaks polynomial networks. Nothing in the package is tuned to them.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from sklearn.datasets import (
    load_breast_cancer,
    load_diabetes,
    load_iris,
    load_wine,
    make_friedman1,
    make_friedman2,
    make_friedman3,
    make_regression,
)


class DataSet(NamedTuple):
    """Inputs (n_row, n_input), targets (n_row,), and whether folds take rows at random or stretch by stretch."""

    X: np.ndarray
    y: np.ndarray
    shuffle: bool = True


def all_sets(n_row, folder=None):
    """Name -> DataSet."""
    pairs = {
        "friedman1": make_friedman1(n_row, noise=1.0, random_state=0),
        "friedman2": make_friedman2(n_row, noise=100.0, random_state=0),
        "friedman3": make_friedman3(n_row, noise=0.1, random_state=0),
        "diabetes": load_diabetes(return_X_y=True),
        "iris": column(load_iris().data, 3),
        "wine": column(load_wine().data, 0),
        "breast cancer": column(load_breast_cancer().data, 26),
        "collinear": collinear(n_row),
        "constant, double": constant_double(n_row),
        "raw units": raw_units(n_row),
        "orifice": orifice(n_row),
        "heavy tails": heavy_tails(n_row),
        "few rows": few_rows(),
        "wide": wide(),
        "sparse": sparse(n_row),
        "step": step(n_row),
        "waves": waves(n_row),
    }
    pairs |= {name: pair for name, pair in from_folder(folder).items() if name not in pairs}
    sets = {name: DataSet(*pair) for name, pair in pairs.items()}
    for name, j in {"friedman1": 3, "friedman2": 2, "diabetes": 2, "orifice": 1, "heavy tails": 0, "waves": 0}.items():
        sets[f"{name}, sorted"] = in_order(sets[name], j)
    return sets


def in_order(data, j):
    """Rows sorted by column j, so that the first and the last fold ask for extrapolation, the others for a gap."""
    order = np.argsort(data.X[:, j], kind="stable")
    return DataSet(data.X[order], data.y[order], shuffle=False)


def column(table, j):
    """One column of a table from all others."""
    return np.delete(table, j, axis=1), table[:, j]


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


def constant_double(n_row):
    """A constant column, one that differs from a constant in one row of a hundred, and a column given twice."""
    X, y = make_friedman1(n_row, 5, noise=1.0, random_state=4)
    seldom = np.arange(n_row) % 100 == 50
    return np.column_stack([X, np.full(n_row, 3.0), 7.0 + seldom, X[:, 3]]), y


def orifice(n_row):
    """Turbulent flow Q = K a sqrt(dP) of oil in raw SI units: a in m2 over two decades, pressures in Pa, Q in m3/s."""
    rng = np.random.default_rng(5)
    area = 10.0 ** rng.uniform(-6.0, -4.0, n_row)
    p_in = rng.uniform(1e6, 3.5e7, n_row)
    p_out = rng.uniform(1e5, p_in)
    discharge = 0.62 * np.sqrt(2.0 / 870.0)
    return np.column_stack([area, p_in, p_out]), discharge * area * np.sqrt(p_in - p_out)


def heavy_tails(n_row):
    """Inputs with few values far out (Student's t, two degrees of freedom), where the target saturates."""
    rng = np.random.default_rng(6)
    X = rng.standard_t(2, size=(n_row, 5))
    return X, X[:, 0] + 2 * np.tanh(X[:, 1]) + np.log1p(X[:, 2] ** 2) + 0.3 * rng.normal(size=n_row)


def few_rows():
    """Sixty rows, eight columns of which three matter."""
    rng = np.random.default_rng(7)
    X = rng.normal(size=(60, 8))
    return X, 3 * X[:, 0] + 2 * X[:, 1] * X[:, 2] + rng.normal(size=60)


def wide():
    """Two hundred rows, sixty columns of which three matter."""
    rng = np.random.default_rng(8)
    X = rng.normal(size=(200, 60))
    return X, 2 * X[:, 10] + X[:, 30] ** 2 + 2 * X[:, 10] * X[:, 50] + 0.5 * rng.normal(size=200)


def waves(n_row):
    """More turns than a cubic has."""
    rng = np.random.default_rng(9)
    X = rng.uniform(-1.0, 1.0, size=(n_row, 3))
    return X, np.sin(3 * np.pi * X[:, 0]) + X[:, 1] * np.cos(2 * np.pi * X[:, 2]) + 0.1 * rng.normal(size=n_row)


def from_folder(folder):
    """Every CSV file with a line of names; the last column is the target, rows with gaps are left out."""
    found = {}
    for path in sorted(Path(folder).glob("*.csv")) if folder else []:
        table = np.genfromtxt(path, delimiter=",", skip_header=1)
        table = table[np.all(np.isfinite(table), axis=1)]
        found[path.stem] = table[:, :-1], table[:, -1]
    return found
