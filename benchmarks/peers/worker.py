"""Fit one learner of the environment `.venv-peers` to every fold of a data set; `benchmarks/separate.py` starts it.

``worker.py`` alone prints the learners that are installed. ``worker.py LEARNER FOLDS.npz FOUND.npz`` reads X_train_0, y_train_0,
X_test_0, X_train_1, ... and writes predicted_0, seconds_0, predicted_1, ...: CPU seconds of a fit, after one that does not
count. It needs nothing of polydraulic.
"""

import resource
import sys
import warnings
from importlib.util import find_spec
from itertools import product
from time import process_time

import numpy as np
from sklearn.metrics import r2_score
from sklearn.model_selection import KFold
from sklearn.preprocessing import StandardScaler
from threadpoolctl import threadpool_limits


def gmdh_default(kind):
    def fit(X, y):
        import gmdh

        return getattr(gmdh, kind)().fit(X, y).predict

    return fit


def gmdh_tuned(kind, survivors):
    """Standardised columns; survivors and criterion chosen by three folds, since the documentation recommends none."""

    def fit(X, y):
        import gmdh

        scale_x, scale_y = StandardScaler().fit(X), StandardScaler().fit(y[:, None])
        v, t = scale_x.transform(X), scale_y.transform(y[:, None])[:, 0]
        inner = list(KFold(3).split(v))

        def model(rows, setting):
            criterion = gmdh.Criterion(gmdh.CriterionType[setting[1]])
            return getattr(gmdh, kind)().fit(v[rows], t[rows], k_best=setting[0], criterion=criterion)

        def score(setting):
            return np.mean([bounded_r2(t[b], model(a, setting).predict(v[b])) for a, b in inner])

        pairs = v.shape[1] * (v.shape[1] - 1) // 2  # Ria answers wrongly or crashes with more survivors than that
        kept = [k for k in survivors if k <= pairs] or [min(survivors)]
        best = model(np.arange(len(v)), max(product(kept, ("REGULARITY", "SYM_REGULARITY")), key=score))
        return lambda Z: scale_y.inverse_transform(np.reshape(best.predict(scale_x.transform(Z)), (-1, 1)))[:, 0]

    return fit


def bounded_r2(y, found):
    """R2, finite even where a prediction is not."""
    return max(r2_score(y, np.nan_to_num(found, nan=1e99, posinf=1e99, neginf=-1e99)), -1e99)


def earth(max_degree):
    def fit(X, y):
        from pyearth import Earth

        return Earth(max_degree=max_degree).fit(X, y).predict

    return fit


def operon(X, y):
    """Its default has no local search of constants and only the four operations; both cost it accuracy."""
    from pyoperon.sklearn import SymbolicRegressor

    model = SymbolicRegressor(
        allowed_symbols="add,sub,mul,aq,sin,constant,variable",
        optimizer_iterations=5,
        population_size=500,
        max_evaluations=100_000,
        n_threads=1,
        random_state=0,
    )
    return model.fit(X, y).predict


SECONDS = 300  # of CPU for all folds of a data set; the system ends the process then
LEARNERS = {  # name -> module it needs, function (X, y) -> predict
    "gmdh Mia": ("gmdh", gmdh_default("Mia")),
    "gmdh Ria": ("gmdh", gmdh_default("Ria")),
    "gmdh Mia tuned": ("gmdh", gmdh_tuned("Mia", (3, 6, 12))),
    "gmdh Ria tuned": ("gmdh", gmdh_tuned("Ria", (1, 3, 6, 12))),
    "MARS": ("pyearth", earth(1)),
    "MARS degree 3": ("pyearth", earth(3)),
    "Operon": ("pyoperon", operon),
}


def main(name, source, target):
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 10))
    fit, folds, found = LEARNERS[name][1], np.load(source), {}
    X = np.random.default_rng(0).uniform(size=(60, 8))
    fit(X, X[:, 0] * X[:, 1])  # imports are not fitting
    for k in range(sum(key.startswith("X_test_") for key in folds)):
        start = process_time()
        predict = fit(folds[f"X_train_{k}"], folds[f"y_train_{k}"])
        found[f"seconds_{k}"] = process_time() - start
        found[f"predicted_{k}"] = np.ravel(predict(folds[f"X_test_{k}"]))
    np.savez(target, **found)


if __name__ == "__main__":
    if len(sys.argv) == 1:
        print("\n".join(name for name, (module, _) in LEARNERS.items() if find_spec(module)))
    else:
        with warnings.catch_warnings(), threadpool_limits(1):
            warnings.simplefilter("ignore")  # what learners say about convergence and conditioning
            main(*sys.argv[1:])
