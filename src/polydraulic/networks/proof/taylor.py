"""A network enclosed over many boxes of inputs at once: Taylor models with all rounding counted.

Each value is a polynomial in the inputs, scaled to e in [-1, 1] over the box, and an error bound. Sums and products of such
forms keep what interval arithmetic forgets: that the nodes of a deep network read the same inputs and cancel each other.
Terms of higher order go into the error bound, and so does rounding, here and in the compiled evaluation.

Source: K. Makino, M. Berz, "Taylor models and other validated functional inclusion methods", 2003.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from itertools import combinations_with_replacement, pairwise
from math import comb
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, RAMP, SIGMOID, SINGLE
from polydraulic.networks.model.table import Network, Node, used_slots

# How much further from the exact value a slot may be, given the forms of the slots before it and its own derivatives by them.
Widen = Callable[[int, "dict[int, Form]", "list[Form]"], np.ndarray]

_EPS = float(np.finfo(np.float64).eps)  # two roundings: one is at most half of it
_TINY = 1e-316  # far above all that underflow can lose in one operation, half of 5e-324 for each product in it
_FOURTH = 0.128 / 24.0  # the fourth derivative of the logistic function stays below 0.128
_LOGISTIC = 16.0 * _EPS  # far above the rounding of the compiled logistic function
_MOST_PRODUCTS = 500  # of coefficients, in a product of two forms: sets the order


class Layout(NamedTuple):
    """Polynomials of n inputs up to some order: constant, n linear, n square coefficients, and the others by degree."""

    n: int
    degree: np.ndarray  # (n_degree,) first coefficient of each degree
    parent: np.ndarray  # (n_coef,) a term is its parent times one input
    axis: np.ndarray
    left: np.ndarray  # (n_product,) coefficients to multiply, by the coefficient to which they contribute
    right: np.ndarray
    target: np.ndarray  # (n_coef,) first product of each coefficient
    weight: np.ndarray  # (n_degree,) no coefficient of this degree sums more products: 2^degree


@lru_cache(maxsize=32)
def layout(n: int) -> Layout:
    """Layout of the highest order, from two to eight, that keeps a product affordable."""
    order = max([2, *(p for p in range(2, 9) if comb(2 * n + p, p) <= _MOST_PRODUCTS)]) if n else 0
    terms = [term for d in range(order + 1) for term in combinations_with_replacement(range(n), d)]
    terms.sort(key=lambda term: (len(term), len(set(term)), term))
    place = {term: k for k, term in enumerate(terms)}
    degree = np.searchsorted([len(term) for term in terms], np.arange(order + 2))
    products = [
        (place[tuple(sorted(one + other))], i, j)
        for i, one in enumerate(terms)
        for j, other in enumerate(terms[: degree[order - len(one) + 1]])
    ]
    target, left, right = np.array(sorted(products)).T
    return Layout(
        n,
        degree[:-1],
        np.array([place[term[:-1]] for term in terms]),
        np.array([term[-1] if term else 0 for term in terms]),
        left,
        right,
        np.searchsorted(target, np.arange(len(terms))),
        2.0 ** np.arange(order + 1),
    )


class Form:
    """Polynomials in e, |e_i| <= 1, and their error bounds: one for each of m boxes.

    Operations keep this promise: if, for all e, the exact operands and the computed ones lie within `error` of the
    polynomials, so do the exact result and the computed one, rounded once.

    Attributes
    ----------
    poly : (n_coef, m) array
    error : (m,) array
    layout : Layout
    local : (m,) array or 0
        What the operations themselves added to the error, as if those they started from were free of it.
    sizes : (n_degree, m) array
        Sum of the magnitudes of the coefficients of each degree.
    size : (m,) array
        Largest magnitude of any value, the error included.
    weighted : (m,) array
        As `size`, each degree with its weight.
    """

    __slots__ = ("error", "layout", "local", "poly", "size", "sizes", "weighted")
    __array_ufunc__ = None  # numpy's scalars leave the operation to this class

    def __init__(self, poly: np.ndarray, error: np.ndarray, layout: Layout, local: np.ndarray | float = 0.0) -> None:
        self.poly, self.error, self.layout, self.local = poly, error, layout, local
        self.sizes = np.add.reduceat(np.abs(poly), layout.degree, axis=0)
        self.size = self.sizes.sum(axis=0) + error
        self.weighted = layout.weight @ self.sizes + error

    def __add__(self, other: "Form | float") -> "Form":
        if isinstance(other, Form):
            form = Form(self.poly + other.poly, self.error + other.error, self.layout, self.local + other.local)
        else:
            poly = self.poly.copy()
            poly[0] += other
            form = Form(poly, self.error, self.layout, self.local)
        return form._widened(2.0 * _EPS * form.size)

    def __mul__(self, other: "Form | float") -> "Form":
        a, b, at = self, other, self.layout
        if not isinstance(b, Form):
            form = Form(a.poly * b, abs(b) * a.error, at, abs(b) * a.local)
            return form._widened(2.0 * _EPS * form.size + _TINY)
        poly = np.empty_like(a.poly)
        _product(a.poly, b.poly, at.left, at.right, at.target, poly)
        higher = (a.sizes[1:] * np.cumsum(b.sizes[::-1], axis=0)[:-1]).sum(axis=0)
        error = a.size * b.error + b.size * a.error + higher
        local = a.size * b.local + b.size * a.local + higher
        # A coefficient that sums k products is rounded k times, and a rounded operation on the values once more.
        return Form(poly, error, at, local)._widened(_EPS * a.weighted * b.weighted + _TINY)

    def _widened(self, rounding: np.ndarray) -> "Form":
        """Add rounding to both errors, and some for the arithmetic of the errors."""
        up = 1.0 + (len(self.poly) + 32) * _EPS
        self.error, self.local = (self.error + rounding) * up, (self.local + rounding) * up
        self.size, self.weighted = self.size + rounding, self.weighted + rounding
        return self

    __radd__ = __add__
    __rmul__ = __mul__

    def logistic(self) -> "Form":
        """1 / (1 + exp(-form)), by its expansion about the middle of the range; where that is wide, half the range."""
        low, high = self.lower()[0], self.upper()[0]
        middle = np.where(np.isfinite(low + high), 0.5 * low + 0.5 * high, 0.0)
        radius = np.maximum(high - middle, middle - low) * (1.0 + 4.0 * _EPS)
        s, least, most = (0.5 + 0.5 * np.tanh(0.5 * h) for h in (middle, low, high))
        slope = s * (1.0 - s)
        h = self + -middle
        expanded = s + h * (slope + h * (slope * (0.5 - s) + h * (slope * (1.0 / 6.0 - slope))))
        rest = _FOURTH * radius**4 + _LOGISTIC * (1.0 + radius) ** 3
        expanded = expanded._widened(rest)
        half = 0.5 * (most - least) + _LOGISTIC + np.where(np.isinf(radius), np.inf, 0.0)  # inf - inf is no number
        narrow = expanded.error <= half
        poly = np.where(narrow, expanded.poly, 0.0)
        poly[0] = np.where(narrow, poly[0], 0.5 * least + 0.5 * most)
        error, local = (np.where(narrow, own, half) for own in (expanded.error, expanded.local))
        return Form(poly, error, self.layout, local)

    def ramp(self) -> "Form":
        """The nearest to the form in [0, 1], by the chord over its range and what lies off it."""
        low, high = self.lower()[0], self.upper()[0]
        known = np.isfinite(low) & np.isfinite(high)
        ends = [np.where(known, end, 0.0) for end in (low, high)]
        width = ends[1] - ends[0]
        slope = np.where(width > 0.0, (_ramp(ends[1]) - _ramp(ends[0])) / np.where(width > 0.0, width, 1.0), 0.0)
        slope = np.where(
            (ends[0] >= 0.0) & (ends[1] <= 1.0), 1.0, np.where((ends[1] <= 0.0) | (ends[0] >= 1.0), 0.0, slope)
        )
        # what lies off a chord does so most at an end or at a kink
        off = np.array([_ramp(x) - slope * x for x in (*ends, *(np.clip(kink, *ends) for kink in (0.0, 1.0)))])
        least, most = off.min(axis=0), off.max(axis=0)
        size = np.maximum(np.abs(ends[0]), np.abs(ends[1]))
        slack = np.where(most > least, 16.0 * _EPS * (1.0 + slope * size), 0.0)
        half = np.where(known, 0.5 * (most - least) + slack, np.inf)
        return (self * slope + (0.5 * least + 0.5 * most))._widened(half)

    def ramp_slope(self) -> "Form":
        """Derivative of `ramp` by the form: 1 inside, 0 outside, and either where a kink is in its range."""
        low, high = self.lower()[0], self.upper()[0]
        inside, outside = (low > 0.0) & (high < 1.0), (high <= 0.0) | (low >= 1.0)
        poly = np.zeros_like(self.poly)
        poly[0] = np.where(inside, 1.0, np.where(outside, 0.0, 0.5))
        return Form(poly, np.where(inside | outside, 0.0, 0.5), self.layout)

    def lower(self) -> tuple[np.ndarray, np.ndarray]:
        """Proved lower bounds (m,), -inf where anything overflowed, and where about they are reached, e (n, m)."""
        n = self.layout.n
        linear, square, others = self.poly[1 : n + 1], self.poly[n + 1 : 2 * n + 1], self.poly[2 * n + 1 :]
        bowl = 2.0 * square > np.abs(linear)  # least inside, not at an end
        depth = np.where(bowl, square, 1.0)
        e = np.where(bowl, -0.5 * linear / depth, np.where(linear > 0.0, -1.0, 1.0))
        # a quotient below 2 first: the square of a number below 1e-154 is none
        least = np.where(bowl, -0.25 * linear * (linear / depth), square - np.abs(linear)).sum(axis=0)
        spread = self.sizes[1:].sum(axis=0) + self.error
        slack = np.where(spread > 0.0, (len(self.poly) + 16) * _EPS * self.size + _TINY, 0.0)
        bound = self.poly[0] + least - np.abs(others).sum(axis=0) - self.error - 2.0 * slack
        return np.where(np.isnan(bound), -np.inf, bound), e

    def upper(self) -> tuple[np.ndarray, np.ndarray]:
        """As `lower`, for the upper bounds."""
        bound, e = Form(-self.poly, self.error, self.layout).lower()
        return -bound, e

    def polynomial(self, e: np.ndarray) -> np.ndarray:
        """Values of the polynomials at `e` (n, m); shape (m,)."""
        at = self.layout
        terms = np.ones_like(self.poly)
        for first, last in pairwise([*at.degree[1:], len(terms)]):
            terms[first:last] = terms[at.parent[first:last]] * e[at.axis[first:last]]
        return (self.poly * terms).sum(axis=0)


@driver
def _product(
    a: np.ndarray, b: np.ndarray, left: np.ndarray, right: np.ndarray, target: np.ndarray, poly: np.ndarray
) -> None:
    """Coefficients (n_coef, m) of products of polynomials, without those of higher order."""
    n_coef, m = poly.shape
    for k in range(n_coef):
        end = target[k + 1] if k + 1 < n_coef else left.shape[0]
        total = poly[k]
        for i in range(m):
            total[i] = 0.0
        for product in range(target[k], end):
            one, other = a[left[product]], b[right[product]]
            for i in range(m):
                total[i] += one[i] * other[i]


def _ramp(x: np.ndarray) -> np.ndarray:
    return np.clip(x, 0.0, 1.0)


def enclose_output(network: Network, low: np.ndarray, high: np.ndarray) -> Form:
    """Output before it is clamped, over m boxes.

    Parameters
    ----------
    network : Network
    low, high : (n_used, m) array
        Boxes inside the domain, of the inputs that `used_slots` names.
    """
    if not network.nodes:
        return Form(np.full((1, low.shape[1]), network.y_mean), np.zeros(low.shape[1]), layout(0))
    values, _ = enclose_slots(network, low, high)
    return network.y_mean + network.y_scale * values[network.n_inputs + len(network.nodes) - 1]


def enclose_slopes(network: Network, low: np.ndarray, high: np.ndarray) -> list[Form]:
    """Exact dy/dx_i of the used inputs, before the output is clamped, over m boxes; arguments as `enclose_output`.

    Derivatives are carried from the output back to the inputs, so that one pass gives all of them.
    """
    _, partials = enclose_slots(network, low, high)
    gains = enclose_gains(network, partials, network.y_scale)
    return [gains[i] * (1.0 / network.x_scale[i]) for i in used_slots(network)[0]]


def enclose_gains(network: Network, partials: dict[int, list[Form]], factor: float) -> dict[int, Form]:
    """What the last node, times `factor`, gains from each slot before it.

    Parameters
    ----------
    network : Network
    partials : dict of list of Form
        From `enclose_slots`.
    factor : float
    """
    n, nodes = network.n_inputs, used_slots(network)[1]
    by_slot: dict[int, Form] = {}
    for number in reversed(nodes):
        for slot, part in zip(network.nodes[number].inputs, partials[number], strict=True):
            step = by_slot[n + number] * part if n + number in by_slot else factor * part
            by_slot[slot] = by_slot[slot] + step if slot in by_slot else step
    return by_slot


def enclose_slots(
    network: Network, low: np.ndarray, high: np.ndarray, widen: Widen | None = None
) -> tuple[dict[int, Form], dict[int, list[Form]]]:
    """Normalized inputs and node outputs, in the order of operations of `table.evaluate`; and derivatives of nodes.

    Parameters
    ----------
    network, low, high
        As for `enclose_output`.
    widen : function, optional
        Adds to the error of each slot as it is found, for values that are rounded more than those of the package.

    Returns
    -------
    values : dict of Form
        By slot.
    partials : dict of list of Form
        By node, one for each of its inputs.
    """
    inputs, nodes = used_slots(network)
    m = low.shape[1]
    at = layout(len(inputs))
    values: dict[int, Form] = {}
    for row, i in enumerate(inputs):
        poly = np.zeros((len(at.target), m))
        poly[0] = 0.5 * low[row] + 0.5 * high[row]
        # Reaches both ends in spite of rounding, so that every input of the box has its |e| <= 1.
        poly[1 + row] = np.maximum(high[row] - poly[0], poly[0] - low[row]) * (1.0 + 2.0 * _EPS)
        form = (Form(poly, np.zeros(m), at) + -network.x_mean[i]) * (1.0 / network.x_scale[i])
        values[i] = _fresh(form, widen(i, values, []) if widen else 0.0)
    partials: dict[int, list[Form]] = {}
    for number in nodes:
        node = network.nodes[number]
        form = node_value(node, values)
        partials[number] = _partials(node, values, form)
        # What the errors of its inputs do to a node is far less than the sum over its terms where these cancel.
        for slot, part in zip(node.inputs, partials[number], strict=True):
            form.local = form.local + part.size * values[slot].error * (1.0 + 32.0 * _EPS)
        form.error = np.fmin(form.error, form.local * (1.0 + 32.0 * _EPS))
        slot = network.n_inputs + number
        values[slot] = _fresh(form, widen(slot, values, partials[number]) if widen else 0.0)
    return values, partials


def _fresh(form: Form, more: np.ndarray | float) -> Form:
    """The form as the start of further operations, with so much more error."""
    return Form(form.poly, (form.error + more) * (1.0 + _EPS), form.layout)


def node_value(node: Node, values: Mapping[int, Any]) -> Any:
    """Value of a node, in whatever arithmetic the values of its inputs have; the order of operations is that of `table.evaluate`."""
    c = node.coef
    a = values[node.inputs[0]]
    if node.kind == SINGLE:
        return c[0] + a * (c[1] + a * (c[2] + a * c[3]))
    if node.kind == LINEAR:
        total = c[0] * a
        for slot, coef in zip(node.inputs[1:], c[1:], strict=True):
            total = total + coef * values[slot]
        return total
    if node.kind in (SIGMOID, RAMP):
        total = _sum_of(node, values)
        return total.logistic() if node.kind == SIGMOID else total.ramp()
    b = values[node.inputs[1]]
    if node.kind == DOUBLE:
        return c[0] + a * (c[1] + a * (c[3] + a * c[6]) + b * c[5]) + b * (c[2] + b * (c[4] + b * c[7]))
    d = values[node.inputs[2]]
    return (
        c[0]
        + a * (c[1] + a * (c[4] + a * c[11]) + b * (c[7] + d * c[10]) + d * c[8])
        + b * (c[2] + b * (c[5] + b * c[12]) + d * c[9])
        + d * (c[3] + d * (c[6] + d * c[13]))
    )


def _sum_of(node: Node, values: Mapping[int, Any]) -> Any:
    """The sum that a sigmoid or ramp is a function of."""
    total = node.coef[0] + node.coef[1] * values[node.inputs[0]]
    for slot, coef in zip(node.inputs[1:], node.coef[2:], strict=True):
        total = total + coef * values[slot]
    return total


def _partials(node: Node, values: dict[int, Form], value: Form) -> list[Form]:
    """Derivatives of a node's output, whose form is `value`, by each of its inputs."""
    c = node.coef
    if node.kind == SIGMOID:
        slope = value * (1.0 + -1.0 * value)
        return [slope * weight for weight in c[1:]]
    if node.kind == RAMP:
        slope = _sum_of(node, values).ramp_slope()
        return [slope * weight for weight in c[1:]]
    a = values[node.inputs[0]]
    if node.kind == LINEAR:
        return [0.0 * a + coef for coef in c]
    if node.kind == SINGLE:
        return [c[1] + a * (2.0 * c[2] + a * (3.0 * c[3]))]
    b = values[node.inputs[1]]
    if node.kind == DOUBLE:
        return [
            c[1] + a * (2.0 * c[3] + a * (3.0 * c[6])) + b * c[5],
            c[2] + b * (2.0 * c[4] + b * (3.0 * c[7])) + a * c[5],
        ]
    d = values[node.inputs[2]]
    return [
        c[1] + a * (2.0 * c[4] + a * (3.0 * c[11])) + b * (c[7] + d * c[10]) + d * c[8],
        c[2] + b * (2.0 * c[5] + b * (3.0 * c[12])) + a * (c[7] + d * c[10]) + d * c[9],
        c[3] + d * (2.0 * c[6] + d * (3.0 * c[13])) + a * (c[8] + b * c[10]) + b * c[9],
    ]
