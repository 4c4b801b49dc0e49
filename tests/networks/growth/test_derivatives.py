import numpy as np
import pytest

from helpers.small_network import FREE, NODES, X, output
from polydraulic.networks.growth.derivatives import coefficients, forward, free_terms, jacobian
from polydraulic.networks.model.table import Node

RNG = np.random.default_rng(0)


@pytest.mark.parametrize("root", [np.ones(300), RNG.uniform(0.0, 2.0, 300)])
def test_derivatives_are_exact(root):
    free, coef = coefficients(NODES)
    assert np.array_equal(free.factors, free_terms(NODES, FREE).factors)
    slope = jacobian(free, coef, *forward(free, coef, X), root)
    column = 0
    for place, (node, keep) in enumerate(zip(NODES, FREE, strict=True)):
        for term in keep:
            moved = []
            for sign in (1, -1):
                coef = np.array(node.coef)
                coef[term] += sign * 1e-6
                changed = [*NODES[:place], Node(node.kind, node.inputs, tuple(coef)), *NODES[place + 1 :]]
                moved.append(root * output(changed))
            size = np.abs(slope[:, column]).max()
            assert slope[:, column] == pytest.approx((moved[0] - moved[1]) / 2e-6, abs=1e-6 * size)
            column += 1
    assert column == slope.shape[1]
