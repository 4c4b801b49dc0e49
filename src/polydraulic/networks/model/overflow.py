"""Whether a network stays among the numbers: where a value overflows, the next may be NaN, which no clamp repairs.

A coarse bound of all magnitudes settles nearly every network at once; where it is beyond the largest number, values at the corners and
along the edges of the domain decide, as powers are largest there.
"""

from itertools import islice, product
from math import isfinite

import numpy as np

from polydraulic.networks.model.nodes import RAMP, SIGMOID, design, terms
from polydraulic.networks.model.table import Network

_CORNERS = 256  # looked at, at most


def overflows(network: Network) -> bool:
    """Whether the normalizers, a node or the output exceeds the largest number somewhere in the domain."""
    gains = [1.0 / scale for scale in network.x_scale]
    return not all(isfinite(gain) for gain in gains) or (
        not isfinite(_largest(network, gains)) and not _finite_at_ends(network, np.array(gains))
    )


def _largest(network: Network, gains: list[float]) -> float:
    """No value is larger; infinite if that cannot be said."""
    boxes = zip(network.x_low, network.x_high, network.x_mean, gains, strict=True)
    sizes = [max(abs(low - mean), abs(high - mean)) * gain for low, high, mean, gain in boxes]
    total = sum(sizes)
    for node in network.nodes:
        size = 0.0
        for coef, exponents in zip(node.coef, terms(node.kind, len(node.inputs)), strict=True):
            part = abs(coef)
            for slot, exponent in zip(node.inputs, exponents, strict=True):
                for _ in range(exponent):
                    part *= sizes[slot]
            size += part
        total += size
        sizes.append(1.0 if node.kind in (SIGMOID, RAMP) else size)
    return total + abs(network.y_mean) + abs(network.y_scale) * (sizes[-1] if network.nodes else 0.0)


def _finite_at_ends(network: Network, gains: np.ndarray) -> bool:
    low, high = np.array(network.x_low), np.array(network.x_high)
    corners = np.array(list(islice(product((False, True), repeat=low.size), _CORNERS)))
    edges = np.vstack([np.eye(low.size, dtype=bool), ~np.eye(low.size, dtype=bool)])
    ends = np.where(np.vstack([corners, edges, ~corners]), high, low)
    with np.errstate(all="ignore"):
        X = np.vstack([ends, 0.5 * low + 0.5 * high, np.clip(0.0, low, high)[None]])
        values = list(((X - np.array(network.x_mean)) * gains).T)
        for node in network.nodes:
            value = design(node.kind, np.column_stack([values[slot] for slot in node.inputs])) @ np.array(node.coef)
            if not np.isfinite(value).all():
                return False
            if node.kind == RAMP:
                value = np.clip(value, 0.0, 1.0)
            values.append(1.0 / (1.0 + np.exp(-value)) if node.kind == SIGMOID else value)
        output = network.y_mean + network.y_scale * (values[-1] if network.nodes else np.zeros(len(X)))
    return bool(np.isfinite(values).all() and np.isfinite(output).all())
