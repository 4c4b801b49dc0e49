"""What a model's outputs do around a point: exact slopes, and how far the point lies outside the domain.

The definitions that exported models are held to. A slope is that of what is returned: it is 0 where an input is moved to
the border of the domain, or the output to its bounds; on a border it is the one from inside. That of a ramp is 0 at both of its ends.
"""

import numpy as np

from polydraulic.networks.model.model import Model
from polydraulic.networks.model.nodes import LINEAR, RAMP, SIGMOID, design
from polydraulic.networks.model.nodes import slopes as node_slopes
from polydraulic.networks.model.partition import region_of
from polydraulic.networks.model.table import Network, Node


def model_slopes(model: Model, X: np.ndarray) -> np.ndarray:
    """Exact derivatives dy/dx.

    Parameters
    ----------
    model : Model
    X : (n_row, n_input) array of finite float

    Returns
    -------
    (n_row, n_input) array
        In units of the output over those of the inputs.

    Examples
    --------
    >>> from polydraulic.networks import Node, Variable
    >>> square = Network((Node(0, (0,), (0.0, 0.0, 1.0, 0.0)),), (0.0,), (1.0,), (-1.0,), (3.0,), 0.0, 1.0)
    >>> model_slopes(Model((Variable("x"),), Variable("y"), (square,)), np.array([[2.0], [3.0], [4.0]])).tolist()
    [[4.0], [6.0], [0.0]]
    """
    X = np.asarray(X, dtype=np.float64)
    found, region = np.zeros(X.shape), region_of(model.partition, X)
    for k, network in enumerate(model.networks):
        rows = region == k
        found[rows] = _network_slopes(network, X[rows])
    return found


def distance_outside(model: Model, X: np.ndarray) -> np.ndarray:
    """How far each row lies outside the domain of the network that answers for it, as a share of the domain's width.

    Parameters
    ----------
    model : Model
    X : (n_row, n_input) array of finite float

    Returns
    -------
    (n_row,) array
        0 inside; the largest of all inputs. A domain without width counts in units of the input.
    """
    X = np.asarray(X, dtype=np.float64)
    low, high = (np.array([getattr(network, end) for network in model.networks]) for end in ("x_low", "x_high"))
    k = region_of(model.partition, X)
    beyond = np.maximum(np.maximum(low[k] - X, X - high[k]), 0.0)
    return np.asarray(np.max(beyond * domain_gain(low, high)[k], axis=1))


def domain_gain(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """One over the width of a domain; 1 where it has none."""
    width = high - low
    return 1.0 / np.where(width > 0.0, width, 1.0)


def _network_slopes(network: Network, X: np.ndarray) -> np.ndarray:
    low, high, n = np.array(network.x_low), np.array(network.x_high), network.n_inputs
    slots = list(((np.clip(X, low, high) - network.x_mean) * (1.0 / np.array(network.x_scale))).T)
    partials = []
    for node in network.nodes:
        x = np.column_stack([slots[slot] for slot in node.inputs])
        value, partial = _node(node, x)
        slots.append(value)
        partials.append(partial)
    gain = np.zeros((n + len(network.nodes), len(X)))  # what the output gains from each slot
    if network.nodes:
        y = network.y_mean + network.y_scale * slots[-1]
        gain[-1] = np.where((y < network.y_low) | (y > network.y_high), 0.0, network.y_scale)
    for place in reversed(range(len(network.nodes))):
        for slot, partial in zip(network.nodes[place].inputs, partials[place].T, strict=True):
            gain[slot] += gain[n + place] * partial
    return np.asarray(np.where((low <= X) & (high >= X), gain[:n].T / network.x_scale, 0.0))


def _node(node: Node, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Value of a node, and its derivatives by its inputs."""
    coef = np.array(node.coef)
    if node.kind == SIGMOID:
        value = 1.0 / (1.0 + np.exp(-np.clip(coef[0] + x @ coef[1:], -700.0, 700.0)))
        return value, (value * (1.0 - value))[:, None] * coef[1:]
    if node.kind == RAMP:
        value = np.clip(coef[0] + x @ coef[1:], 0.0, 1.0)
        return value, np.where((value > 0.0) & (value < 1.0), 1.0, 0.0)[:, None] * coef[1:]
    matrix = x if node.kind == LINEAR else design(node.kind, x)
    return matrix @ coef, node_slopes(node.kind, x, coef, None if node.kind == LINEAR else matrix)
