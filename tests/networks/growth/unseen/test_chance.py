from itertools import combinations
from math import exp, log

import numpy as np
import pytest

from polydraulic.networks.growth.training_rows import rows_in_memory
from polydraulic.networks.growth.unseen.chance import effective_rows, length, log_chance, log_terms
from polydraulic.networks.model.nodes import DOUBLE, SINGLE, design, terms
from polydraulic.networks.model.table import Node

RNG = np.random.default_rng(5)
LINE = Node(SINGLE, (0,), (0.0, 1.0, 0.0, 0.0))


def nodes_of(kind, n_input, n_known):
    """Every node of a kind: which variables it reads, and which of its terms it has."""
    n_term = len(terms(kind, n_input))
    for inputs in combinations(range(n_known), n_input):
        for has in range(1, 2**n_term):
            yield Node(kind, inputs, tuple(float(has >> k & 1) for k in range(n_term)))


def test_all_networks_of_one_node_share_less_than_all_there_is():
    shares = [exp(-length([node], 4)) for kind, n in ((SINGLE, 1), (DOUBLE, 2)) for node in nodes_of(kind, n, 4)]
    assert sum(shares) == pytest.approx(2 * 0.5 * 0.25)  # two of four kinds, half of it for networks of one node


def test_more_to_choose_from_and_more_nodes_take_longer():
    assert length([LINE], 30) - length([LINE], 3) == pytest.approx(log(10.0))
    assert length([LINE, Node(SINGLE, (3,), LINE.coef)], 3) > length([LINE], 3) + log(4.0)


@pytest.mark.parametrize("n", [20, 200])
def test_a_line_through_noise_that_nobody_chose_explains_as_much_as_the_bound_says(n):
    x = RNG.normal(size=n)
    y = RNG.normal(size=(2000, n))
    y -= y.mean(axis=1, keepdims=True)
    x -= x.mean()
    error = 1.0 - (y @ x) ** 2 / ((x @ x) * np.sum(y * y, axis=1))
    chance = np.array([log_chance([LINE], 1, n, e) for e in error]) - length([LINE], 1)
    for level in (0.05, 0.2):
        assert np.mean(chance < log(level)) == pytest.approx(level, abs=4.0 * (level / 2000) ** 0.5)


def test_as_many_coefficients_as_rows_are_no_evidence():
    assert log_chance([Node(SINGLE, (0,), (1.0, 1.0, 1.0, 1.0))], 1, 5, 0.0) == 0.0
    assert log_chance([LINE], 1, 50, 0.0) == -np.inf


def test_terms_to_choose_from():
    assert log_terms(("single", "double", "triple", "linear"), 10) == pytest.approx(log(30 + 45 + 120))
    assert log_terms(("single",), 10) == pytest.approx(log(30))
    assert log_terms(("linear",), 10) == 1.0


def test_normal_rows_count_in_full_and_few_far_ones_for_few():
    x = RNG.normal(size=(400, 2))
    assert effective_rows([LINE], rows_in_memory(x, x[:, 0], None)) > 300.0  # 400 but for chance
    assert effective_rows([LINE], rows_in_memory(x, RNG.normal(size=400), None)) == 400.0
    far = np.where(np.arange(400) < 2, 1e3, x[:, 0])
    x[:2, 0] = 1e3
    assert effective_rows([LINE], rows_in_memory(x, far, None)) == pytest.approx(
        6.0, rel=0.02
    )  # but for what they move the mean by
    weight = RNG.integers(1, 4, 400).astype(float)
    repeated = np.repeat(np.arange(400), weight.astype(int))
    cubic = [Node(SINGLE, (1,), tuple(np.linalg.lstsq(design(SINGLE, x[:, 1:]), far)[0].tolist()))]
    assert effective_rows(cubic, rows_in_memory(x, far, weight)) == pytest.approx(
        effective_rows(cubic, rows_in_memory(x[repeated], far[repeated], None))
    )
