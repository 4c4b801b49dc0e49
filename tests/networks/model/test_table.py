import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.errors import InputError
from polydraulic.networks import Model, Network, Node, Variable, grid
from polydraulic.networks.model.model import describe, pack_models
from polydraulic.networks.model.nodes import SIGMOID, design, terms
from polydraulic.networks.model.partition import choose
from polydraulic.networks.model.table import evaluate, work_size

value = st.floats(-3.0, 3.0).map(lambda v: round(v, 6))


@st.composite
def networks(draw, n_input=None):
    n_input = draw(st.integers(1, 4)) if n_input is None else n_input
    nodes = []
    for number in range(draw(st.integers(0, 4))):
        kind = draw(st.sampled_from([0, 1, 2, 3, 4]))
        size = kind + 1 if kind < 3 else draw(st.integers(1, 5))
        slots = tuple(draw(st.integers(0, n_input + number - 1)) for _ in range(size))
        coef = tuple(draw(value) for _ in terms(kind, size))
        nodes.append(Node(kind, slots, coef))
    numbers = [draw(value) for _ in range(n_input)]
    return Network(
        nodes=tuple(nodes),
        x_mean=tuple(numbers),
        x_scale=tuple(draw(st.floats(0.1, 3.0)) for _ in range(n_input)),
        x_low=tuple(-1.0 for _ in range(n_input)),
        x_high=tuple(1.5 for _ in range(n_input)),
        y_mean=draw(value),
        y_scale=draw(st.floats(0.1, 3.0)),
        y_low=-50.0,
        y_high=draw(st.sampled_from([40.0, 1e300])),
    )


def model_of(*found, edges=None):
    inputs = tuple(Variable(f"x{i}") for i in range(found[0].n_inputs))
    return Model(inputs, Variable("y"), found, grid(edges or {}))


def by_terms(network, X):
    """The network from its terms, row by row of the definition."""
    v = (np.clip(X, network.x_low, network.x_high) - network.x_mean) / np.array(network.x_scale)
    last = np.zeros(len(X))
    for node in network.nodes:
        last = design(node.kind, v[:, list(node.inputs)]) @ np.array(node.coef)
        if node.kind == SIGMOID:
            last = 0.5 + 0.5 * np.tanh(0.5 * last)
        v = np.column_stack([v, last])
    return np.clip(network.y_mean + network.y_scale * last, network.y_low, network.y_high)


@given(networks())
def test_evaluation_is_the_sum_of_the_terms(network):
    X = np.random.default_rng(0).uniform(-2.0, 2.5, size=(20, network.n_inputs))
    expected = by_terms(network, X)
    with np.errstate(all="ignore"):
        size = 1.0 + np.abs(expected)
    assert np.all(np.abs(model_of(network).predict(X) - expected) < 1e-6 * size)


@given(networks(n_input=2), networks(n_input=2), networks(n_input=2))
def test_a_value_on_an_edge_belongs_below(a, b, c):
    model = model_of(a, b, c, edges={1: (0.0, 0.5)})
    X = np.array([[0.3, -0.1], [0.3, 0.0], [0.3, 0.25], [0.3, 0.5], [0.3, 0.51]])
    for row, network in zip(X, (a, a, b, b, c), strict=True):
        assert model.predict(row[None]) == pytest.approx(model_of(network).predict(row[None]))


@given(networks(n_input=2), networks(n_input=2), networks(n_input=2))
def test_many_rows_have_the_bits_of_one(a, b, c):
    model = model_of(a, b, c, edges={0: (-0.2, 0.7)})
    X = np.random.default_rng(3).uniform(-1.5, 2.0, size=(150, 2))
    (regions,), table = pack_models([model])
    work, one_by_one = np.zeros(work_size(table)), []
    for row in X:
        work[:2] = row
        one_by_one.append(evaluate(table, choose(regions, work), work))
    assert np.array_equal(model.predict(X), one_by_one, equal_nan=True)


def test_bad_rows_are_named():
    model = model_of(Network((), (0.0, 0.0), (1.0, 1.0), (0.0, 0.0), (1.0, 1.0), 2.0, 1.0))
    assert model.predict(np.zeros((2, 2))).tolist() == [2.0, 2.0]
    with pytest.raises(InputError, match=r"must be \(n_row, 2\)"):
        model.predict(np.zeros((2, 3)))
    with pytest.raises(InputError, match="x1 = nan in row 1"):
        model.predict(np.array([[0.0, 0.0], [0.0, np.nan]]))


def test_equations_in_words():
    node = Node(1, (0, 1), (1.0, 0.0, -2.0, 0.0, 0.0, 3.0, 0.0, 0.5))
    lines = describe(
        Network((node,), (1.0, 2.0), (3.0, 4.0), (0.0, 0.0), (1.0, 1.0), 5.0, 6.0), [Variable("p"), Variable("q")]
    )
    assert lines[0] == "n1 = (p - 1) / 3"
    assert "-2 n2" in lines[2]
    assert "+3 n1 n2" in lines[2]
    assert lines[-1] == "y = 5 + 6 z1"
