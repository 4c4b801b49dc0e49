"""A polynomial of lagged signals as a network: nodes of one layer, and one linear node that adds them up."""

from collections.abc import Mapping, Sequence

from polydraulic.networks.dynamic.lagged_terms import Frame, Terms
from polydraulic.networks.model.nodes import LINEAR, terms
from polydraulic.networks.model.table import Network, Node


def places_read(terms: Terms) -> list[int]:
    """Places of the lagged values that any output's polynomial reads."""
    return sorted(set((terms.factors[terms.factors > 0] - 1).tolist())) or [0]


def term_networks(frame: Frame, terms: Terms) -> list[Network]:
    """One network per output, whose inputs are `places_read`."""
    kept = places_read(terms)
    slot = {place + 1: n for n, place in enumerate(kept)}  # of factors
    column = frame.column[kept]
    mean, scale = frame.mean[column], frame.scale[column]
    low, high = mean + scale * frame.low[kept], mean + scale * frame.high[kept]
    first, found = frame.signals.shape[1] - len(frame.y_low), []
    for k, (y_low, y_high) in enumerate(zip(frame.y_low.tolist(), frame.y_high.tolist(), strict=True)):
        coef = by_slots(terms, k, slot)
        y_mean, y_scale = float(frame.mean[first + k]), float(frame.scale[first + k])
        constant = coef.pop((), 0.0)
        x_mean, x_scale, x_low, x_high = (tuple(values.tolist()) for values in (mean, scale, low, high))
        found.append(
            Network(
                term_nodes(coef, len(kept)), x_mean, x_scale, x_low, x_high,
                y_mean + constant * y_scale, y_scale, y_mean + y_low * y_scale, y_mean + y_high * y_scale,
            )
        )  # fmt: skip
    return found


def by_slots(terms: Terms, output: int, slot: Mapping[int, int]) -> dict[tuple[int, ...], float]:
    """Coefficients of an output's terms, by the slots of their factors in rising order; `slot` says where a factor stands."""
    own = terms.output == output
    return {
        tuple(sorted(slot[place] for place in factors if place)): value
        for factors, value in zip(terms.factors[own].tolist(), terms.coef[own].tolist(), strict=True)
    }


def term_nodes(coef: Mapping[tuple[int, ...], float], n_slot: int) -> tuple[Node, ...]:
    """As few nodes as hold all terms, by the slots of their factors, and the linear one at the end; `n_slot` slots stand before them."""
    left = {factors: value for factors, value in coef.items() if value != 0.0}
    groups: list[Sequence[int]] = []
    for size in (3, 2, 1):
        for factors in [one for one in left if len(set(one)) == size and (size > 1 or len(one) > 1)]:
            if not any(set(factors) <= set(group) for group in groups):
                groups.append(sorted(set(factors)))
    nodes = []
    for group in groups:
        values = []
        for exponents in terms(len(group) - 1, len(group)):
            factors = tuple(slot for slot, e in zip(group, exponents, strict=True) for _ in range(e))
            values.append(left.pop(factors, 0.0))
        nodes.append(Node(len(group) - 1, tuple(group), tuple(values)))
    places = [*range(n_slot, n_slot + len(nodes)), *(factors[0] for factors in left)]
    if places:
        nodes.append(Node(LINEAR, tuple(places), (*([1.0] * (len(places) - len(left))), *left.values())))
    return tuple(nodes)
