"""Models that every target must carry over."""

import numpy as np

from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import AbductiveRegressor, Model, PerceptronRegressor, RegionRegressor, Variable

RNG = np.random.default_rng(9)
X = RNG.uniform(-1.0, 1.0, size=(400, 3))
Y = np.exp(X[:, 0]) * np.cos(3.0 * X[:, 1]) + np.abs(X[:, 2])
ABC = [Variable("a", "m"), Variable("b"), Variable("c")]


def made() -> dict[str, list[Model]]:
    two = AbductiveRegressor(max_layers=2, refine=False)
    regions = RegionRegressor(
        AbductiveRegressor(max_layers=2, refine=False, output_bounds=(-1.0, 2.0)), edges={2: [0.0], 0: [-0.3, 0.4]}
    )
    raw = X * [1.0, 1e-6, 300.0] + [1e5, 0.0, 0.0]
    few = two.fit(X[:, 1:], X[:, 1] * X[:, 2]).to_model(ABC[1:], Variable("few", "bar"))
    perceptron = PerceptronRegressor(hidden_units=3, max_iter=20, n_starts=1).fit(X, Y).to_model(ABC, Variable("mlp"))
    boxes = regions.fit(X, Y).to_model(ABC, Variable("out put", "Pa"))
    return {
        "single": [AbductiveRegressor(max_layers=3).fit(X, Y).to_model(output=Variable("y"))],
        "linear": [AbductiveRegressor(kinds=("single", "linear")).fit(X, Y).to_model(output=Variable("lin"))],
        "regions": [boxes],
        "constant": [AbductiveRegressor().fit(X, np.full(400, -2.5)).to_model(output=Variable("int"))],
        "perceptron": [perceptron],
        "raw units": [two.fit(raw, 1e6 * Y).to_model(output=Variable("raw"))],
        "several": [few, boxes, perceptron],
        "shipped": [shipped_models()[3]],
    }


NAMES = ("single", "linear", "regions", "constant", "perceptron", "raw units", "several", "shipped")
