"""Adaptation: a fitted model that follows measurements, within limits, and can go back.

What is learnt is a correction of the output, linear in a few features: a constant, the model's own answer (a gain) and powers of
each input. Recursive least squares with forgetting gives it: sums over the past, in which each measurement counts less with
every later one. The fitted model counts like `caution` measurements that are never forgotten, so that without news all goes back
to it, and nothing winds up. Regions share what they have in common: one with few measurements follows the model as a whole.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.chebyshev import cheb2poly, chebvander

from polydraulic.errors import InputError
from polydraulic.networks.model import Model
from polydraulic.networks.nodes import LINEAR, SINGLE
from polydraulic.networks.partition import region_of
from polydraulic.networks.table import UNBOUNDED, Network, Node

_MOST_GAIN = 0.95  # by which the answers of a model may be weakened


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
        Highest power of an input in the correction. Higher ones follow changes that are curved and ask for more measurements.
    caution : float, default=10
        Measurements that the fitted model counts for, in every region and once more as a whole.

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
        self, model: Model, *, forgetting: float = 0.999, trust: float = 0.25, order: int = 1, caution: float = 10.0
    ) -> None:
        if not 0.0 < forgetting <= 1.0:
            raise InputError(f"forgetting = {forgetting!r}: must be above 0 and at most 1")
        if not 0.0 < trust <= 1.0:
            raise InputError(f"trust = {trust!r}: must be a part of the output range, above 0 and at most 1")
        if order not in (1, 2, 3):
            raise InputError(f"order = {order!r}: must be 1, 2 or 3")
        if not 0.0 < caution < np.inf:
            raise InputError(f"caution = {caution!r}: must be a number of measurements above 0")
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
        self._bounds = np.array([(network.y_low, network.y_high) for network in model.networks])
        self._free = replace(
            model, networks=tuple(replace(n, y_low=-UNBOUNDED, y_high=UNBOUNDED) for n in model.networks)
        )
        box = model.domain()
        self._varies = np.flatnonzero(box[:, 1] > box[:, 0])
        self._centre, self._radius = box.mean(axis=1), np.maximum(0.5 * (box[:, 1] - box[:, 0]), 1e-300)
        self._low, self._high = (np.array([getattr(n, end) for n in model.networks]) for end in ("x_low", "x_high"))
        self.reset()

    def reset(self, snapshot: Snapshot | None = None) -> None:
        """Go back to a snapshot; without one, to the fitted model."""
        n, size = len(self._fitted.networks), 2 + self._order * len(self._varies)
        empty = Snapshot(np.zeros((n, size, size)), np.zeros((n, size)), 0)
        taken = empty if snapshot is None else snapshot
        if taken.gram.shape != empty.gram.shape or taken.moment.shape != empty.moment.shape:
            raise InputError(f"the snapshot is of another model: {taken.gram.shape} instead of {empty.gram.shape}")
        self._gram, self._moment, self.count = taken.gram.copy(), taken.moment.copy(), taken.count

    def snapshot(self) -> Snapshot:
        """Return what has been learnt so far; later updates leave it alone."""
        return Snapshot(self._gram.copy(), self._moment.copy(), self.count)

    def update(self, X: Any, y: Any) -> None:
        """Take in measurements, oldest first; one call with many rows gives the same as many calls with one.

        Parameters
        ----------
        X : (n_row, n_input) array-like of finite float
        y : (n_row,) array-like of finite float
        """
        X = np.ascontiguousarray(X, dtype=np.float64)
        y = np.asarray(y, dtype=np.float64)
        answer = self._free.predict(X)
        if y.shape != answer.shape or not np.all(np.isfinite(y)):
            raise InputError(f"y has shape {y.shape}; it must be ({len(answer)},) and finite")
        region = region_of(self._fitted.partition, X)
        features = self._features(X, answer, region)
        missed = np.clip(y - answer, -self._trust, self._trust)
        # beyond an output bound any answer is as good as the bound
        low, high = self._bounds[region].T
        missed[((y >= high) & (answer >= high)) | ((y <= low) & (answer <= low))] = 0.0
        age = self._forgetting ** np.arange(len(y) - 1, -1, -1, dtype=np.float64)
        self._gram *= self._forgetting ** len(y)
        self._moment *= self._forgetting ** len(y)
        for k in np.unique(region).tolist():
            rows = region == k
            weighted = features[rows] * age[rows, None]
            self._gram[k] += weighted.T @ features[rows]
            self._moment[k] += weighted.T @ missed[rows]
        self.count += len(y)

    def coefficients(self) -> np.ndarray:
        """Coefficients of the correction by region, (n_network, n_feature), in units of the output.

        Of the constant, of the model's answer, then of the powers of each input that varies.
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
        powers = chebvander(((inside - self._centre) / self._radius)[:, self._varies], self._order)[..., 1:]
        gain = np.clip((answer - self._middle) / self._half, -1.0, 1.0)
        return np.column_stack([np.ones(len(X)), gain, powers.reshape(len(X), -1)])

    def _corrected(self, network: Network, coef: Sequence[float]) -> Network:
        """Add constant, gain and a Single of each input to a network, in its own normalized variables."""
        gain, powers = coef[1] / self._half, np.reshape(coef[2:], (-1, self._order))
        mean = network.y_mean + coef[0] + gain * (network.y_mean - self._middle)
        nodes, slots, factors = list(network.nodes), [], []
        if nodes:
            slots.append(network.n_inputs + len(nodes) - 1)
            factors.append(network.y_scale * (1.0 + gain))
        for place, chebyshev in zip(self._varies.tolist(), powers, strict=True):
            # (x - centre) / radius = shift + stretch * the network's normalized input
            radius = float(self._radius[place])
            shift, stretch = (network.x_mean[place] - self._centre[place]) / radius, network.x_scale[place] / radius
            power = Polynomial(cheb2poly([0.0, *chebyshev]))(Polynomial([shift, stretch]))
            single = np.zeros(4)
            single[: len(power.coef)] = power.coef
            slots.append(network.n_inputs + len(nodes))
            factors.append(1.0)
            nodes.append(Node(SINGLE, (place,), tuple(single.tolist())))
        if slots:
            nodes.append(Node(LINEAR, tuple(slots), tuple(factors)))
        return replace(network, nodes=tuple(nodes), y_mean=mean, y_scale=1.0)
