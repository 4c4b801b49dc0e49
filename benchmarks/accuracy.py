"""Accuracy of abductive networks next to other learners, by cross-validation."""

import importlib
import subprocess
import sys
from time import perf_counter

import numpy as np
from scipy.stats import rankdata
from sklearn.compose import TransformedTargetRegressor
from sklearn.datasets import make_friedman1
from sklearn.ensemble import HistGradientBoostingRegressor
from sklearn.linear_model import LinearRegression, RidgeCV
from sklearn.metrics import r2_score
from sklearn.model_selection import KFold
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler

from polydraulic.networks import AbductiveRegressor

OURS = "AbductiveRegressor"
BLOW_UP = -1.0  # R2 on a fold below which a model is useless


def cubic_ridge():
    return make_pipeline(StandardScaler(), PolynomialFeatures(3, include_bias=False), RidgeCV(np.logspace(-3, 3, 7)))


def perceptron():
    net = MLPRegressor(hidden_layer_sizes=(64, 64), early_stopping=True, max_iter=1000, random_state=0)
    return TransformedTargetRegressor(make_pipeline(StandardScaler(), net), transformer=StandardScaler())


LEARNERS = {
    OURS: AbductiveRegressor,
    "cubic ridge": cubic_ridge,
    "linear": LinearRegression,
    "MLP 64x64": perceptron,
    "HistGradientBoosting": lambda: HistGradientBoostingRegressor(random_state=0),
}
FORMULA = {OURS, "cubic ridge", "linear"}
OPTIONAL = {"gmdh Mia": "gmdh.Mia()", "gmdh Ria": "gmdh.Ria()", "MARS": "pyearth.Earth(max_degree=3)"}


def with_optional(learners):
    """Add what is installed and survives a small fit in a process of its own: some crash with this NumPy."""
    learners = dict(learners)
    for name, call in OPTIONAL.items():
        module = call.partition(".")[0]
        trial = f"import {module}, numpy; X = numpy.random.rand(99, 3); {call}.fit(X, X[:, 0] * X[:, 1])"
        try:
            subprocess.run([sys.executable, "-c", trial], check=True, capture_output=True, timeout=60)
        except subprocess.SubprocessError:
            print(f"{name} is left out: {module} is not installed or does not run here")
            continue
        place = {module: importlib.import_module(module)}
        learners[name] = lambda call=call, place=place: eval(call, place)
        FORMULA.add(name)
    return learners


def cross_validated(make, X, y, folds=5):
    """R2 of each fold and the mean seconds of a fit."""
    scores, seconds = [], []
    for train, test in KFold(folds, shuffle=True, random_state=0).split(X):
        model = make()
        start = perf_counter()
        model.fit(X[train], y[train])
        seconds.append(perf_counter() - start)
        found = np.nan_to_num(np.ravel(model.predict(X[test])), posinf=1e150, neginf=-1e150)
        scores.append(r2_score(y[test], found))
    return scores, float(np.mean(seconds))


def accuracy(sets):
    """R2 and fit time of every learner on every set."""
    learners = with_optional(LEARNERS)
    for make in learners.values():  # compiling and importing are not fitting
        make().fit(*make_friedman1(100, 5, random_state=0))
    means, slower, blow_ups = [], [], []
    for set_name, (X, y) in sets.items():
        print(f"\n{set_name}: {len(X)} rows, {X.shape[1]} inputs{'':16s} mean R2   worst fold   fit time ratio")
        found = {name: cross_validated(make, X, y) for name, make in learners.items()}
        for name, (scores, seconds) in found.items():
            bad = min(scores) < BLOW_UP
            blow_ups += [f"{name} on {set_name}: {min(scores):.3g}"] if bad else []
            ratio = seconds / found[OURS][1]
            print(
                f"  {name:38s} {np.mean(scores):10.4f} {min(scores):12.4f} {ratio:12.3f}{'   BLOW-UP' if bad else ''}"
            )
        means.append([np.mean(scores) for scores, _ in found.values()])
        slower.append([seconds / found[OURS][1] for _, seconds in found.values()])
    summary(list(learners), np.array(means), np.exp(np.mean(np.log(slower), axis=0)), blow_ups)


def summary(names, means, slower, blow_ups):
    """Mean ranks over all sets, 1 the best."""
    formula = [name in FORMULA for name in names]
    overall = rankdata(-means, axis=1).mean(axis=0)
    among = np.full(len(names), np.nan)
    among[formula] = rankdata(-means[:, formula], axis=1).mean(axis=0)
    print(
        f"\nall {len(means)} sets                     mean rank   among formulas   median R2   fit time ratio (geometric mean)"
    )
    for row in zip(names, overall, among, np.median(means, axis=0), slower, strict=True):
        print("  {:28s} {:10.2f} {:14.2f} {:13.4f} {:12.3f}".format(*row))
    print("blow-ups, a fold with R2 below -1:", "; ".join(blow_ups) or "none")
