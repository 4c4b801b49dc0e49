"""Speed side by side, in one run, as ratios: machines differ and drift, so single times mean little.

``make bench`` runs this. It prints and asserts nothing.
"""

import numpy as np
from sklearn.linear_model import LinearRegression
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler
from threadpoolctl import threadpool_limits

from polydraulic import AbductiveRegressor, build_flow, load_machine, load_scenario
from polydraulic.networks.growth.moments import moments
from polydraulic.networks.growth.scoring import squared_errors
from polydraulic.networks.model.nodes import TRIPLE, design
from polydraulic.thesis.excavator import with_pumps
from polydraulic.thesis.timing import paired_times, time_runs
from show import show


def steps():
    machine, scenario = load_machine("cat215b"), load_scenario("single_08")
    models = {
        "exact": build_flow("exact", machine),
        "iterative, eps 0.05": build_flow("iterative", machine),
        "iterative, eps 0.001": build_flow("iterative", machine, eps=0.001),
        "polynomial, shipped networks": build_flow("polynomial", machine),
    }
    show("one step, boom alone", time_runs(machine, models, scenario), "ns", per=2000)
    limited = with_pumps(machine, torque_limit_enabled=True)
    models = {
        "exact": build_flow("exact", machine),
        "exact, torque limit": build_flow("exact", limited),
        "iterative, eps 0.05": build_flow("iterative", machine),
        "iterative, eps 0.001": build_flow("iterative", machine, eps=0.001),
        "stiff": build_flow("stiff", machine),
        "stiff, torque limit": build_flow("stiff", limited),
        "tlm, 1 substep": build_flow("tlm", machine, substeps=1),
        "tlm, 4 substeps": build_flow("tlm", machine),
    }
    for name in ("sine", "task"):
        show(f"one step of all three links, {name}", time_runs(machine, models, load_scenario(name)), "ns", per=2600)


def scoring():
    rng = np.random.default_rng(0)
    v, t = rng.normal(size=(4000, 12)), rng.normal(size=4000)
    triples = np.array([(i, j, k) for i in range(12) for j in range(i) for k in range(j)])

    def one_by_one():
        for inputs in triples:
            np.linalg.lstsq(design(TRIPLE, v[:, inputs]), t)

    calls = {"moments": lambda: squared_errors(moments(v, t), TRIPLE, triples), "least squares, one by one": one_by_one}
    show(f"scoring {len(triples)} triples on 4000 rows", paired_times(calls, pairs=7), "ms")


def fitting():
    rng = np.random.default_rng(1)
    X = rng.uniform(size=(4000, 10))
    y = 10 * np.sin(np.pi * X[:, 0] * X[:, 1]) + 20 * (X[:, 2] - 0.5) ** 2 + 10 * X[:, 3] + 5 * X[:, 4]
    y += rng.normal(size=4000)
    train, test = slice(0, 2000), slice(2000, 4000)
    learners = {
        "AbductiveRegressor": AbductiveRegressor(),
        "AbductiveRegressor, half variance": AbductiveRegressor(prior_variance="half-variance"),
        "full cubic polynomial": make_pipeline(StandardScaler(), PolynomialFeatures(3), LinearRegression()),
    }
    calls = {name: (lambda model=model: model.fit(X[train], y[train])) for name, model in learners.items()}
    show("fitting friedman1 with noise 1, 2000 rows", paired_times(calls, pairs=7), "ms")
    for name, model in learners.items():
        print(f"  {name:34s} R2 on 2000 other rows {model.score(X[test], y[test]):.4f}")


if __name__ == "__main__":
    with threadpool_limits(1):
        steps()
        scoring()
        fitting()
