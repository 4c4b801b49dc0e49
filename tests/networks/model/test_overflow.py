from dataclasses import replace

import numpy as np
import pytest

from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Network, Node
from polydraulic.networks.model.nodes import DOUBLE, RAMP, SIGMOID, SINGLE
from polydraulic.networks.model.overflow import overflows

CUBE = Network((Node(SINGLE, (0,), (0.0, 0.0, 0.0, 1.0)),), (0.0,), (1.0,), (-2.0,), (2.0,), 0.0, 1.0)


@pytest.mark.parametrize(
    "change",
    [
        {"x_scale": (1e-310,)},
        {"x_low": (-1e308,), "x_mean": (1e308,)},
        {"x_high": (1e200,)},
        {"y_scale": 1e308, "x_high": (5.0,)},
        {"nodes": (Node(SINGLE, (0,), (0.0, 0.0, 0.0, 1e308)),), "x_high": (5.0,)},
        {"nodes": (Node(SIGMOID, (0,), (1e308, 1e308)),)},
        {"nodes": (Node(RAMP, (0,), (1e308, 1e308)),)},
    ],
)
def test_a_value_beyond_all_numbers_is_seen(change):
    assert not overflows(CUBE)
    assert overflows(replace(CUBE, **change))


def test_a_coarse_bound_alone_refuses_nothing():
    """Terms of opposite signs, six deep: the sum of their magnitudes overflows, the values are zero."""
    nodes = [Node(DOUBLE, (0, 1), (0.0, 1e60, -1e60, 0.0, 0.0, 0.0, 0.0, 0.0))]
    nodes += [Node(SINGLE, (k,), (0.0, 0.0, 0.0, 1.0)) for k in range(2, 7)]
    network = Network(tuple(nodes), (0.0,) * 2, (1.0,) * 2, (1.0,) * 2, (1.0,) * 2, 0.0, 1.0)
    assert not overflows(network)
    assert overflows(replace(network, x_high=(1.0, 2.0)))


def test_no_shipped_network_overflows():
    networks = [network for model in shipped_models() for network in model.networks]
    assert networks
    assert not any(overflows(network) for network in networks)
    assert not overflows(replace(networks[0], nodes=(), y_mean=float(np.pi)))
