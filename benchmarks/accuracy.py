"""Accuracy of abductive networks next to other learners, by cross-validation: Markdown tables.

All learners fit one fold, then the next, so that times are compared fold by fold; those of `.venv-peers` follow, each through
all folds in a process of its own.
"""

import sys
from typing import NamedTuple

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

from polydraulic import AbductiveRegressor
from polydraulic.thesis.timing import Ratio, ratio_of, timed
from separate import fit_separately, separate_learners
from show import table

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
NO_FORMULA = {"MLP 64x64", "HistGradientBoosting"}


class Outcome(NamedTuple):
    """R2 of each fold (minus infinity without a prediction), CPU seconds of each fit (NaN without one, or no time), and what went wrong."""

    scores: np.ndarray
    seconds: list[float]
    failure: str = ""


def folds_of(data, count=5):
    """(X_train, y_train, X_test, y_test) of each fold; training rows in random order, as some learners test on the last."""
    rng = np.random.default_rng(0)
    for train, test in KFold(count, shuffle=data.shuffle, random_state=0 if data.shuffle else None).split(data.X):
        train = rng.permutation(train)
        yield data.X[train], data.y[train], data.X[test], data.y[test]


def fit_fold_by_fold(folds):
    """Learner -> predictions and CPU seconds of each fold."""
    found = {name: [] for name in LEARNERS}
    for X_train, y_train, X_test, _ in folds:
        for name, make in LEARNERS.items():
            model = make()
            _, seconds = timed(lambda model=model, X=X_train, y=y_train: model.fit(X, y))
            found[name].append((np.ravel(model.predict(X_test)), seconds))
    return found


def outcome(found, folds):
    if isinstance(found, str):
        return Outcome(np.full(len(folds), -np.inf), [np.nan] * len(folds), found)
    scores = [
        r2_score(fold[3], np.nan_to_num(predicted, nan=1e150, posinf=1e150, neginf=-1e150))
        for fold, (predicted, _) in zip(folds, found, strict=True)
    ]
    # a clock that has stood still has measured nothing
    return Outcome(np.array(scores), [seconds if seconds > 0.0 else np.nan for _, seconds in found])


def accuracy(sets, peers):
    """Cross-validate every learner on every set and print tables."""
    separate = separate_learners() if peers else []
    names = [*LEARNERS, *separate]
    for make in LEARNERS.values():  # compiling and importing are not fitting
        for n_input in (5, 32):
            make().fit(*make_friedman1(100, n_input, random_state=0))
    found = {}
    for set_name, data in sets.items():
        folds = list(folds_of(data))
        fitted = fit_fold_by_fold(folds)
        for name in separate:
            fitted[name] = fit_separately(name, [fold[:3] for fold in folds])
        found[set_name] = {name: outcome(answers, folds) for name, answers in fitted.items()}
        for name, result in found[set_name].items():
            seconds = np.mean(result.seconds)
            line = f"{np.mean(result.scores):12.4f} {min(result.scores):12.4f} {seconds:9.4f} s {result.failure}"
            print(f"{set_name:20s} {name:22s} {line}", file=sys.stderr, flush=True)
    shuffled = {key: value for key, value in found.items() if sets[key].shuffle}
    in_order = {key: value for key, value in found.items() if not sets[key].shuffle}
    summary("All sets", names, found)
    summary("Folds at random", names, shuffled)
    summary("Folds that ask for extrapolation", names, in_order)
    every_set(names, found, sets)
    blow_ups(found)


def summary(title, names, found):
    """Mean ranks of the mean R2, 1 the best; fit time as ratio to ours, median and quartiles of the folds, geometric means over sets with times."""
    means = np.array([[np.mean(result.scores) for result in row.values()] for row in found.values()])
    ratios = np.array([[ratio_of(row[name].seconds, row[OURS].seconds) for name in names] for row in found.values()])
    formula = np.array([name not in NO_FORMULA for name in names])
    overall = rankdata(-means, axis=1).mean(axis=0)
    among = np.full(len(names), np.nan)
    among[formula] = rankdata(-means[:, formula], axis=1).mean(axis=0)
    rows = []
    for j in np.argsort(overall, kind="stable"):
        results = [row[names[j]] for row in found.values()]
        worst = min((result.scores.min() for result in results if not result.failure), default=np.nan)
        bad = sum(int(np.sum(result.scores < BLOW_UP)) for result in results if not result.failure)
        failed = sum(bool(result.failure) for result in results)
        rows.append(
            [
                names[j],
                f"{overall[j]:.2f}",
                f"{among[j]:.2f}" if formula[j] else "-",
                number(np.median(means[:, j])),
                number(worst),
                f"{bad}" + (f"; sets without a result: {failed}" if failed else ""),
                "1" if names[j] == OURS else str(Ratio(*np.exp(np.nanmean(np.log(ratios[:, j]), axis=0)))),
            ]
        )
    header = [
        "learner",
        "mean rank",
        "among formulas",
        "median R2",
        "worst fold",
        "blow-ups",
        "fit time, ratio (quartiles)",
    ]
    table(f"{title} ({len(found)})", header, rows)


def every_set(names, found, sets):
    """Mean R2 of five folds, the best in bold."""
    rows = []
    for set_name, row in found.items():
        means = [np.mean(result.scores) for result in row.values()]
        cells = [
            result.failure.partition(":")[0] or number(mean) for result, mean in zip(row.values(), means, strict=True)
        ]
        cells[int(np.argmax(means))] = f"**{cells[int(np.argmax(means))]}**"
        rows.append([set_name, "{} x {}".format(*sets[set_name].X.shape), *cells])
    table("Mean R2 of every set", ["set", "rows x inputs", *names], rows)


def blow_ups(found):
    """Every fold below the limit, and every set that a learner did not finish."""
    print("\n### Blow-ups: set, learner, R2 of the folds below -1\n")
    for set_name, row in found.items():
        for name, result in row.items():
            bad = [f"fold {k} {number(score)}" for k, score in enumerate(result.scores) if score < BLOW_UP]
            if bad:
                print(f"- {set_name}, {name}: {result.failure or ', '.join(bad)}")


def number(r2):
    return f"{r2:.3f}" if r2 > -10.0 else f"{r2:.1e}"
