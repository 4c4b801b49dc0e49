"""Adaptation: a fitted model that follows measurements, within limits, and can go back.

What is learnt is a correction of the output, linear in a few features: a constant, the model's own answer (a gain), powers of each
input and products of two. Recursive least squares with forgetting gives it: sums over the past, in which each measurement counts less with
every later one. The fitted model counts like `caution` measurements that are never forgotten, so that without news all goes back
to it, and nothing winds up. Regions share what they have in common: one with few measurements follows the model as a whole.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.chebyshev import cheb2poly, chebvander

from polydraulic.errors import InputError
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, SINGLE, TERMS
from polydraulic.networks.model.partition import region_of
from polydraulic.networks.model.table import UNBOUNDED, Network, Node

_MOST_GAIN = 0.95  # by which the answers of a model may be weakened
_SURE = 3.0  # standard deviations of noise


@dataclass(frozen=True)
class Snapshot:
    """What an adapter has learnt, to go back to.

    Attributes
    ----------
    gram : (n_network, n_feature, n_feature) array
        Sums of products of features by region, weighted by age.
    moment : (n_network, n_feature) array
        Sums of features times what the fitted model missed.
    count : int
        Measurements so far.
    """

    gram: np.ndarray
    moment: np.ndarray
    count: int


class Adapter:
    """Correct a model from measurements as they come in.

    Parameters
    ----------
    model : Model
        Fitted, with output bounds.
    forgetting : float, default=0.999
        Weight of a measurement against the one after it, above 0 and at most 1; the memory is 1 / (1 - forgetting) measurements.
    trust : float, default=0.25
        How far the adapted model may be from the fitted one anywhere, as a part of the range between its output bounds. A
        measurement further off counts as if it were just so far.
    order : {1, 2, 3}, default=1
        Highest power of an input in the correction; from 2 on it has the product of every two inputs, too. Higher ones follow
        changes that are curved and ask for more measurements.
    caution : float, default=10
        Measurements that the fitted model counts for, in every region and once more as a whole.
    noise : float, default=0
        Standard deviation of what is measured of the output. Within three of them of an output bound, a measurement counts as on it.

    Attributes
    ----------
    count : int
        Measurements so far.

    Notes
    -----
    Powers are Chebyshev polynomials, so that all features lie in [-1, 1] over the domain; the sizes of their coefficients add up
    to no more than the trust. This is how the limit is kept everywhere, also where nothing was measured. The gain stays positive,
    so that output clamps do no harm.

    Examples
    --------
    >>> from polydraulic.networks import AbductiveRegressor
    >>> X = np.random.default_rng(0).uniform(size=(300, 2))
    >>> fitted = AbductiveRegressor().fit(X, X[:, 0] * X[:, 1]).to_model()
    >>> adapter = Adapter(fitted, trust=0.4)
    >>> adapter.update(X, 0.9 * X[:, 0] * X[:, 1])
    >>> round(float(adapter.model().predict([[1.0, 1.0]])[0]), 1)
    0.9
    >>> adapter.reset()
    >>> adapter.model() == fitted
    True
    """

    def __init__(
        self,
        model: Model,
        *,
        forgetting: float = 0.999,
        trust: float = 0.25,
        order: int = 1,
        caution: float = 10.0,
        noise: float = 0.0,
    ) -> None:
        if not 0.0 < forgetting <= 1.0:
            raise InputError(f"forgetting = {forgetting!r}: must be above 0 and at most 1")
        if not 0.0 < trust <= 1.0:
            raise InputError(f"trust = {trust!r}: must be a part of the output range, above 0 and at most 1")
        if order not in (1, 2, 3):
            raise InputError(f"order = {order!r}: must be 1, 2 or 3")
        if not 0.0 < caution < np.inf:
            raise InputError(f"caution = {caution!r}: must be a number of measurements above 0")
        if not 0.0 <= noise < np.inf:
            raise InputError(f"noise = {noise!r}: must be a standard deviation of the output, 0 or more")
        low = min(network.y_low for network in model.networks)
        high = max(network.y_high for network in model.networks)
        if not -UNBOUNDED < low < high < UNBOUNDED:
            raise InputError(
                f"{model.output.name} has output bounds [{low:g}, {high:g}]; adaptation needs finite ones: "
                "fit with output_bounds"
            )
        self._fitted, self._order = model, int(order)
        self._forgetting, self._caution = float(forgetting), float(caution)
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        self._trust = float(trust) * (high - low)
        ends = np.array([(network.y_low, network.y_high) for network in model.networks])
        # of a region whose whole range is noise, one half is the low end and the other the high one
        reach = np.minimum(_SURE * float(noise), 0.5 * np.diff(ends, axis=1))
        self._ends = ends + reach * [1.0, -1.0]
        self._free = replace(
            model, networks=tuple(replace(n, y_low=-UNBOUNDED, y_high=UNBOUNDED) for n in model.networks)
        )
        box = model.domain()
        self._varies = np.flatnonzero(box[:, 1] > box[:, 0])
        self._pairs = list(combinations(self._varies.tolist(), 2)) if order > 1 else []
        self._centre, self._radius = box.mean(axis=1), np.maximum(0.5 * (box[:, 1] - box[:, 0]), 1e-300)
        self._low, self._high = (np.array([getattr(n, end) for n in model.networks]) for end in ("x_low", "x_high"))
        self.reset()

    def reset(self, snapshot: Snapshot | None = None) -> None:
        """Go back to a snapshot; without one, to the fitted model."""
        n, size = len(self._fitted.networks), 2 + self._order * len(self._varies) + len(self._pairs)
        empty = Snapshot(np.zeros((n, size, size)), np.zeros((n, size)), 0)
        taken = empty if snapshot is None else snapshot
        if taken.gram.shape != empty.gram.shape or taken.moment.shape != empty.moment.shape:
            raise InputError(f"the snapshot is of another model: {taken.gram.shape} instead of {empty.gram.shape}")
        self._gram, self._moment, self.count = taken.gram.copy(), taken.moment.copy(), taken.count

    def snapshot(self) -> Snapshot:
        """Return what has been learnt so far; later updates leave it alone."""
        return Snapshot(self._gram.copy(), self._moment.copy(), self.count)

    def update(self, X: Any, y: Any, weight: Any = None) -> None:
        """Take in measurements, oldest first; one call with many rows gives the same as many calls with one.

        Parameters
        ----------
        X : (n_row, n_input) array-like of finite float
        y : (n_row,) array-like of finite float
        weight : (n_row,) array-like, optional
            What each measurement counts for, 0 or more; 1 if not given. A row of weight 0 lets time pass, and may hold anything.

        Raises
        ------
        InputError
            If a shape is wrong, or a value that counts is not finite.
        """
        X = np.ascontiguousarray(X, dtype=np.float64)
        y = np.asarray(y, dtype=np.float64)
        weight = np.ones(len(X)) if weight is None else np.asarray(weight, dtype=np.float64)
        if weight.shape != (len(X),) or not np.all((weight >= 0.0) & (weight < np.inf)):
            raise InputError(f"weight has shape {weight.shape}; it must be ({len(X)},), finite and 0 or more")
        on = weight > 0.0
        if y.shape != weight.shape or not np.all(np.isfinite(y[on])):
            raise InputError(f"y has shape {y.shape}; it must be ({len(X)},), and finite where it counts")
        answer = self._free.predict(X[on])
        region = region_of(self._fitted.partition, X[on])
        features = self._features(X[on], answer, region)
        missed = np.clip(y[on] - answer, -self._trust, self._trust)
        # beyond an output bound any answer is as good as the bound; noise makes a measurement there fall short of it
        low, high = self._ends[region].T
        missed[((y[on] >= high) & (answer >= high)) | ((y[on] <= low) & (answer <= low))] = 0.0
        counts = (weight * self._forgetting ** np.arange(len(y) - 1, -1, -1, dtype=np.float64))[on]
        self._gram *= self._forgetting ** len(y)
        self._moment *= self._forgetting ** len(y)
        for k in np.unique(region).tolist():
            rows = region == k
            weighted = features[rows] * counts[rows, None]
            self._gram[k] += weighted.T @ features[rows]
            self._moment[k] += weighted.T @ missed[rows]
        self.count += int(on.sum())

    def coefficients(self) -> np.ndarray:
        """Coefficients of the correction by region, (n_network, n_feature), in units of the output.

        Of the constant, of the model's answer, of the powers of each input that varies, of the products of two of them.
        """
        prior = self._caution * np.eye(self._moment.shape[1])
        whole = np.linalg.solve(self._gram.sum(axis=0) + prior, self._moment.sum(axis=0))
        found = np.linalg.solve(self._gram + prior, (self._moment + self._caution * whole)[..., None])[..., 0]
        size = np.abs(found).sum(axis=1, keepdims=True)
        found *= np.minimum(1.0, self._trust / np.maximum(size, 1e-300))
        found[:, 1] = np.clip(found[:, 1], -_MOST_GAIN * self._half, _MOST_GAIN * self._half)
        return found

    def model(self) -> Model:
        """Return the adapted model: an ordinary one, with some nodes more in each network, in the same bounds."""
        if not self.count or not self._moment.any():
            return self._fitted
        networks = [
            self._corrected(network, coef)
            for network, coef in zip(self._fitted.networks, self.coefficients().tolist(), strict=True)
        ]
        training = {**self._fitted.training, "adapted_rows": self.count}
        return replace(self._fitted, networks=tuple(networks), training=training)

    def _features(self, X: np.ndarray, answer: np.ndarray, region: np.ndarray) -> np.ndarray:
        inside = np.clip(X, self._low[region], self._high[region])
        place = (inside - self._centre) / self._radius
        powers = chebvander(place[:, self._varies], self._order)[..., 1:]
        products = [place[:, i] * place[:, j] for i, j in self._pairs]
        gain = np.clip((answer - self._middle) / self._half, -1.0, 1.0)
        powers = powers.reshape(len(X), self._order * len(self._varies))
        return np.column_stack([np.ones(len(X)), gain, powers, *products])

    def _corrected(self, network: Network, coef: Sequence[float]) -> Network:
        """Add constant, gain, a Single of each input and a Double of each pair to a network, in its own normalized variables."""
        gain, most = coef[1] / self._half, 2 + self._order * len(self._varies)
        powers = np.reshape(coef[2:most], (-1, self._order))
        # (x - centre) / radius = shift + stretch * the network's normalized input
        shift = (np.array(network.x_mean) - self._centre) / self._radius
        stretch = np.array(network.x_scale) / self._radius
        mean = network.y_mean + coef[0] + gain * (network.y_mean - self._middle)
        nodes, slots, factors = list(network.nodes), [], []
        if nodes:
            slots.append(network.n_inputs + len(nodes) - 1)
            factors.append(network.y_scale * (1.0 + gain))
        terms: list[tuple[int, tuple[int, ...], np.ndarray]] = [
            (SINGLE, (i,), Polynomial(cheb2poly([0.0, *chebyshev]))(Polynomial([shift[i], stretch[i]])).coef)
            for i, chebyshev in zip(self._varies.tolist(), powers, strict=True)
        ]
        for (i, j), c in zip(self._pairs, coef[most:], strict=True):
            product = np.outer([shift[i], stretch[i]], [shift[j], stretch[j]])
            terms.append((DOUBLE, (i, j), c * np.array([*product.T.flat[:3], 0.0, 0.0, product[1, 1]])))
        for kind, read, found in terms:
            slots.append(network.n_inputs + len(nodes))
            factors.append(1.0)
            nodes.append(Node(kind, read, (*found.tolist(), *[0.0] * (len(TERMS[kind]) - len(found)))))
        if slots:
            nodes.append(Node(LINEAR, tuple(slots), tuple(factors)))
        return replace(network, nodes=tuple(nodes), y_mean=mean, y_scale=1.0)
