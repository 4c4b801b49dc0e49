"""Straight-line code has the bits of the table, whatever the network and its inputs."""

import numba
import numpy as np
import pytest
from hypothesis import given, settings

from helpers.random_networks import model_of, networks
from polydraulic._kernel import driver
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Model, Network, Node, Split, Variable
from polydraulic.networks.model import machine_code
from polydraulic.networks.model.machine_code import answer_of, network_code
from polydraulic.networks.model.model import pack_models
from polydraulic.networks.model.nodes import LINEAR, RAMP, SIGMOID, TRIPLE
from polydraulic.networks.model.partition import choose
from polydraulic.networks.model.table import evaluate, work_size

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="machine code is for compiled kernels")


@pytest.fixture(autouse=True, scope="module")
def folder(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(machine_code, "cache_folder", lambda: str(tmp_path_factory.getbasetemp() / "straight_line"))
        yield


@driver
def by_code(code, X, work, y):
    for row in range(X.shape[0]):
        for i in range(X.shape[1]):
            work[i] = X[row, i]
        y[row] = answer_of(code, 0, work)


@driver
def by_table(table, regions, X, work, y):
    for row in range(X.shape[0]):
        for i in range(X.shape[1]):
            work[i] = X[row, i]
        y[row] = evaluate(table, choose(regions, work), work)


def assert_same_bits(model, X):
    (regions,), table = pack_models([model])
    code, found, expected = network_code([model]), np.empty(len(X)), np.empty(len(X))
    by_table(table, regions, X, np.zeros(work_size(table)), expected)
    work = np.zeros(work_size(table))
    by_code(code, X, work, found)
    assert np.array_equal(work[: X.shape[1]], X[-1], equal_nan=True)  # inputs stay
    numbers = ~np.isnan(expected)
    assert np.array_equal(np.isnan(found), ~numbers)
    assert np.array_equal(found[numbers].view(np.int64), expected[numbers].view(np.int64))
    return found


def points(model, rng, n=400):
    """Points in the domain, beyond it, on edges, and what is no number."""
    low, high = model.domain().T
    X = rng.uniform(low - 0.2 * (high - low), high + 0.2 * (high - low), (n, len(low)))
    X[0], X[1], X[2] = low, high, 0.0
    X[3], X[4], X[5] = np.nan, np.inf, -np.inf
    X[6], X[7] = -0.0, 5e-324
    return X


@settings(max_examples=40)
@given(networks(n_input=2), networks(n_input=2), networks(n_input=2))
def test_any_networks_by_region(a, b, c):
    model = model_of(a, b, c, edges={0: (-0.2, 0.7)})
    X = points(model, np.random.default_rng(0))
    X[8:12, 0] = (-0.2, 0.7, np.nextafter(-0.2, 1.0), np.nextafter(0.7, 1.0))
    assert_same_bits(model, X)


@settings(max_examples=20)
@given(networks())
def test_any_network_everywhere(network):
    model = model_of(network)
    assert_same_bits(model, points(model, np.random.default_rng(1), 100))


def test_sigmoids_side_by_side():
    """More than eight that read the same slots, then others, a ramp, and a triple of them."""
    rng = np.random.default_rng(2)
    nodes = [Node(SIGMOID, (0, 1, 2), tuple(rng.normal(0.0, 4.0, 4))) for _ in range(19)]
    nodes += [Node(SIGMOID, (2, 0), (900.0, 0.3, -2.0)), Node(SIGMOID, (5,), (-900.0, 1e3))]
    nodes += [Node(RAMP, (3, 4), (0.1, 1.0, -2.0)), Node(TRIPLE, (23, 24, 3), tuple(rng.normal(size=14)))]
    nodes += [Node(LINEAR, tuple(range(3, 26)), tuple(rng.normal(size=23)))]
    network = Network(tuple(nodes), (0.1, 0.2, 0.3), (1.0, 2.0, 0.5), (-4.0,) * 3, (5.0,) * 3, 0.3, 2.0)
    model = Model(tuple(Variable(f"x{i}") for i in range(3)), Variable("y"), (network,))
    found = assert_same_bits(model, points(model, rng))
    assert np.ptp(found[8:]) > 1.0


def test_values_that_overflow_are_what_the_table_gives():
    cube = Node(0, (0,), (0.0, 0.0, 0.0, 1e300))
    network = Network((cube, Node(0, (1,), (1.0, -1.0, 1.0, 0.0))), (0.0,), (1e-3,), (-1.0,), (1.0,), 0.0, 1.0)
    model = Model((Variable("x"),), Variable("y"), (network,))
    found = assert_same_bits(model, np.linspace(-1.0, 1.0, 101)[:, None])
    assert not np.isfinite(found).all()


def test_a_tree_without_balance_and_a_model_without_nodes():
    part = 0
    for k in range(1, 60):
        part = Split(k % 2, k / 60.0, part, k)
    leaves = tuple(Network((), (0.0, 0.0), (1.0, 1.0), (0.0, 0.0), (1.0, 1.0), float(k), 1.0) for k in range(60))
    model = Model((Variable("a"), Variable("b")), Variable("y"), leaves, part)
    found = assert_same_bits(model, np.random.default_rng(3).uniform(0.0, 1.0, (500, 2)))
    assert len(set(found)) > 20


@pytest.mark.parametrize("name", ["cascade", "direct", "neural", "fine"])
def test_networks_of_the_package(name):
    rng = np.random.default_rng(4)
    for model in shipped_models(name, limited=name != "neural"):
        if len(model.networks) < 100:  # those of 150 regions run in tests of flows
            assert_same_bits(model, points(model, rng, 1000))
