"""Models that every target must carry over."""

import numpy as np
from hypothesis import strategies as st

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Model, Network, Node, PerceptronRegressor, Variable
from polydraulic.networks.model.nodes import LINEAR, terms

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
    ramps = Node(5, (0, 1), (-0.2, 0.6, 0.3)), Node(5, (2,), (-0.1, -0.8)), Node(2, (3, 4, 2), (0.1,) * 14)
    ramped = Network(ramps, (0.1, 0.0, -0.2), (0.5, 1.0, 2.0), (-1.0,) * 3, (1.0,) * 3, 0.5, 3.0, -20.0, 20.0)
    boxes = regions.fit(X, Y).to_model(ABC, Variable("out put", "Pa"))
    return {
        "single": [AbductiveRegressor(max_layers=3).fit(X, Y).to_model(output=Variable("y"))],
        "linear": [AbductiveRegressor(kinds=("single", "linear")).fit(X, Y).to_model(output=Variable("lin"))],
        "regions": [boxes],
        "constant": [AbductiveRegressor().fit(X, np.full(400, -2.5)).to_model(output=Variable("int"))],
        "perceptron": [perceptron],
        "ramps": [Model(tuple(ABC), Variable("ramped", "m"), (ramped,))],
        "raw units": [two.fit(raw, 1e6 * Y).to_model(output=Variable("raw"))],
        "several": [few, boxes, perceptron],
        "shipped": [shipped_models()[3]],
    }


NAMES = ("single", "linear", "regions", "constant", "perceptron", "ramps", "raw units", "several", "shipped")


def drawn_nodes(draw, n_input, coefficient) -> tuple[Node, ...]:
    """Up to four nodes of any kind behind inputs, each on earlier slots."""
    nodes = []
    for slot in range(n_input, n_input + draw(st.integers(1, 4))):
        kind = draw(st.integers(0, 5))
        size = draw(st.integers(1, slot)) if kind >= LINEAR else kind + 1
        slots = tuple(draw(st.lists(st.integers(0, slot - 1), min_size=size, max_size=size)))
        n_term = len(terms(kind, size))
        nodes.append(Node(kind, slots, tuple(draw(st.lists(coefficient, min_size=n_term, max_size=n_term)))))
    return tuple(nodes)


@st.composite
def networks(draw) -> Network:
    n_input = draw(st.integers(1, 3))
    number = st.floats(-2.0, 2.0)
    nodes = drawn_nodes(draw, n_input, number)
    mean = tuple(draw(st.lists(number, min_size=n_input, max_size=n_input)))
    scale = tuple(draw(st.lists(st.floats(0.5, 3.0), min_size=n_input, max_size=n_input)))
    low, high = (-1.0,) * n_input, (1.0,) * n_input
    return Network(nodes, mean, scale, low, high, draw(number), draw(number), -50.0, 50.0)
