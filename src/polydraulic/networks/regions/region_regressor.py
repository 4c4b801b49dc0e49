"""RegionRegressor: a network in each region, whose borders are given (thesis Table 3) or found as a tree."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, overload

import numpy as np
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin, clone
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from polydraulic.errors import InputError
from polydraulic.networks.blas_threads import one_blas_thread
from polydraulic.networks.growth.far_values import far_values_untold, warn_of_far_values
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.hold_out import calibration_rows
from polydraulic.networks.intervals import stated_half_width
from polydraulic.networks.model.fitted import predictions, variables
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.partition import (
    EVERYWHERE,
    Partition,
    box_name,
    checked_edges,
    grid,
    region_boxes,
    region_of,
)
from polydraulic.networks.regions.split_search import best_cut
from polydraulic.networks.regions.tree import Halves, Leaf, box_halves, grow_tree

_GAIN = 0.05  # a cut has to lower the predicted squared error by this share
_EXACT = 1e-20  # of the variance: an error that is only rounding


class RegionRegressor(MultiOutputMixin, RegressorMixin, BaseEstimator):
    """A separate network in each region of the input space.

    Parameters
    ----------
    estimator : AbductiveRegressor or PerceptronRegressor, optional
        Cloned for every region; perceptrons need `edges` and learn one output. Its `calibration` is the share of all rows that is held out for intervals.
    edges : mapping from input (index, or column name) to rising edges, optional
        Regions are the cells of this grid; a value on an edge belongs to the cell below it. Without edges the
        regions are found: the region with the largest error is cut in two, at the threshold where two polynomials fit
        best, as long as that lowers the predicted squared error.
    max_regions : int, default=8
        Maximum number of regions that are found.
    min_rows : int, default=50
        Rows, counted by their weights, that a cut leaves on each side.
    borrow : float, default=0.0
        A region also learns from rows across its borders, up to this share of its width.
    tolerance : float, optional
        A region whose largest error on its own rows is smaller is not cut; in units of y.

    Attributes
    ----------
    estimators_ : list of AbductiveRegressor
        One per region.
    partition_ : Split or int
        Which of them answers where.
    residuals_ : list of list of (n_held_out,) array
        Sizes of held-out residuals by region and output, rising.
    n_features_in_ : int
    feature_names_in_ : ndarray of str
        Only if fitted on a frame with column names.

    Examples
    --------
    >>> import numpy as np
    >>> X = np.linspace(-1, 1, 400)[:, None]
    >>> model = RegionRegressor(edges={0: [0.0]}).fit(X, np.abs(X[:, 0]))
    >>> round(float(model.predict([[-0.3]])[0]), 6)
    0.3
    >>> found = RegionRegressor(max_regions=2).fit(X, np.abs(X[:, 0]))
    >>> abs(found.partition_.at) < 0.01
    True
    """

    def __init__(
        self,
        estimator: AbductiveRegressor | None = None,
        *,
        edges: Mapping[Any, Sequence[float]] | None = None,
        max_regions: int = 8,
        min_rows: int = 50,
        borrow: float = 0.0,
        tolerance: float | None = None,
    ) -> None:
        self.estimator = estimator
        self.edges = edges
        self.max_regions = max_regions
        self.min_rows = min_rows
        self.borrow = borrow
        self.tolerance = tolerance

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> "RegionRegressor":
        """Fit every region on its own rows.

        Parameters
        ----------
        X : (n_row, n_input) array-like of finite float
        y : (n_row,) or (n_row, n_output) array-like of finite float
        sample_weight : (n_row,) array-like, optional
            A weight acts like that many repetitions of its row.

        Raises
        ------
        ValueError
            As for `AbductiveRegressor`; also edges that do not rise, and cells without enough rows.
        """
        self._check_settings()
        return self._learn(X, y, sample_weight, None)

    def refitted(self, X: Any, y: Any, sample_weight: Any = None) -> "RegionRegressor":
        """Another one whose networks are learnt from these rows in the regions of this one, which are not sought again.

        Parameters
        ----------
        X, y, sample_weight
            As for `fit`, of as many inputs.

        Raises
        ------
        ValueError
            As for `fit`; also other inputs, and regions without enough rows.
        """
        check_is_fitted(self)
        validate_data(self, X, y, reset=False, y_numeric=True, dtype=np.float64, multi_output=True)
        return clone(self)._learn(X, y, sample_weight, self.partition_)

    def _learn(self, X: Any, y: Any, sample_weight: Any, regions: Partition | None) -> "RegionRegressor":
        """Fit in given regions, in the cells of the edges, or in regions that are found."""
        X, y = validate_data(self, X, y, y_numeric=True, dtype=np.float64, multi_output=True, ensure_min_samples=2)
        weight = np.ones(len(X)) if sample_weight is None else _check_sample_weight(
            sample_weight, X, ensure_non_negative=True
        )  # fmt: skip
        told = np.where(weight[:, None] > 0.0, y.reshape(len(y), -1), np.nan)
        warn_of_far_values(told, 3)  # `fit` or `refitted` are between this and who called them
        X, y, weight = X[weight > 0.0], y.astype(np.float64)[weight > 0.0], weight[weight > 0.0]
        self._single_output = y.ndim == 1
        base = AbductiveRegressor() if self.estimator is None else self.estimator
        learn, hold = calibration_rows(len(y), getattr(base, "calibration", 0.0), base.random_state)
        rows = _Rows(X[learn], y[learn], weight[learn])
        if self.edges is None and regions is None:
            with one_blas_thread():
                self.partition_, self.estimators_ = self._find(rows, base)
        else:
            names = [variable.name for variable in variables(self, None)]
            self.partition_ = grid(checked_edges(self.edges or {}, names)) if regions is None else regions
            self.estimators_ = [self._fit_box(rows, base, box) for box in self._boxes()]
        errors = np.abs(self._outputs(X[hold]) - y.reshape(len(y), -1)[hold])
        region = region_of(self.partition_, X[hold])
        self.residuals_ = [list(np.sort(errors[region == k].T)) for k in range(len(self.estimators_))]
        return self

    @overload
    def predict(self, X: Any) -> np.ndarray: ...

    @overload
    def predict(
        self, X: Any, *, return_domain: bool = ..., return_interval: float | None = ...
    ) -> np.ndarray | tuple[np.ndarray, ...]: ...

    def predict(
        self, X: Any, *, return_domain: bool = False, return_interval: float | None = None
    ) -> np.ndarray | tuple[np.ndarray, ...]:
        """Outputs for `X`; arguments and results as `AbductiveRegressor.predict`.

        Intervals are region-wise: each region has the width that its own held-out rows ask for.
        """
        check_is_fitted(self)
        X = validate_data(self, X, reset=False, dtype=np.float64)
        y = self._outputs(X)
        half = None
        if return_interval is not None:
            by_region = np.array(
                [[stated_half_width(r, return_interval) for r in outputs] for outputs in self.residuals_]
            )
            half = by_region[region_of(self.partition_, X)]
        inside = self.to_model().inside(X) if return_domain else None
        return predictions(y, half, inside, single=self._single_output)

    def to_model(self, inputs: Sequence[Variable] | None = None, output: Variable | None = None) -> Model:
        """Return the (first) output's networks as a model that can be saved, exported and simulated."""
        return self.to_models(inputs, None if output is None else [output])[0]

    def to_models(
        self, inputs: Sequence[Variable] | None = None, outputs: Sequence[Variable] | None = None
    ) -> list[Model]:
        """Return one model per output."""
        check_is_fitted(self)
        by_region = [_models(estimator, inputs, outputs) for estimator in self.estimators_]
        models = []
        for parts in zip(*by_region, strict=True):
            networks = tuple(part.networks[0] for part in parts)
            training: dict[str, object] = {}
            for key in parts[0].training:  # what differs is listed by region
                values = [part.training[key] for part in parts]
                training[key] = values[0] if all(value == values[0] for value in values) else values
            models.append(Model(variables(self, inputs), parts[0].output, networks, self.partition_, training))
        return models

    def _outputs(self, X: np.ndarray) -> np.ndarray:
        return np.column_stack([model.predict(X) for model in self.to_models()])

    def _boxes(self) -> list[np.ndarray]:
        boxes = region_boxes(self.partition_, self.n_features_in_)
        return [boxes[k] for k in range(len(boxes))]

    def _fit_box(self, rows: "_Rows", base: AbductiveRegressor, box: np.ndarray) -> AbductiveRegressor:
        """Fit the region `box` on its rows, and on borrowed ones."""
        name = box_name(box, [variable.name for variable in variables(self, None)])
        own = rows.inside(box)
        if not len(own.y):
            raise InputError(f"no rows with {name}: add data there or move the edges")
        if self.borrow:
            width = self.borrow * np.ptp(own.X, axis=0)
            own = rows.inside(box + np.column_stack([-width, width]))
        estimator = clone(base)
        if hasattr(base, "calibration"):
            estimator.set_params(calibration=0.0)  # rows are held out here, for all regions
        if base.domain is not None:
            domain = np.clip(np.asarray(base.domain, dtype=np.float64), box[:, :1], box[:, 1:])
            estimator.set_params(domain=list(map(tuple, domain.tolist())))
        try:
            with far_values_untold():
                return estimator.fit(*own)
        except ValueError as error:
            raise InputError(str(error) if name == "everywhere" else f"region {name}: {error}") from error

    def _find(self, rows: "_Rows", base: AbductiveRegressor) -> tuple[Partition, list[AbductiveRegressor]]:
        """Cut the region with the largest predicted error while that helps; the first of equal ones."""
        if not isinstance(base, AbductiveRegressor):
            raise InputError(f"{type(base).__name__} states no predicted squared error to find regions by: give edges")
        everywhere = np.tile([-np.inf, np.inf], (self.n_features_in_, 1))
        with np.errstate(over="ignore"):  # the first fit refuses values so large
            scale = rows.y.reshape(len(rows.y), -1).std(axis=0)
        scale = np.where(scale > 0.0, scale, 1.0)

        def leaf(box: np.ndarray) -> Leaf:
            estimator, own = self._fit_box(rows, base, box), rows.inside(box)
            cost = float(own.weight.sum() * np.sum(np.atleast_1d(estimator.pse_) / scale**2))
            worst = float(np.max(np.abs(estimator.predict(own.X) - own.y)))
            good_enough = self.tolerance is not None and worst <= self.tolerance
            return Leaf(box, estimator, cost, good_enough or cost <= _EXACT * own.weight.sum())

        def cut(parent: Leaf) -> Halves | None:
            own = rows.inside(parent.box)
            found = best_cut(own.X, own.y.reshape(len(own.y), -1) / scale, own.weight, self.min_rows)
            if found is None:
                return None
            below, above = (leaf(box) for box in box_halves(parent.box, found.axis, found.at))
            better = below.cost + above.cost < (1.0 - _GAIN) * parent.cost
            return Halves(found.axis, found.at, below, above) if better else None

        partition, leaves = grow_tree(EVERYWHERE, [leaf(everywhere)], cut, self.max_regions)
        return partition, [found.fitted for found in leaves]

    def _check_settings(self) -> None:
        for name in ("max_regions", "min_rows"):
            value = getattr(self, name)
            if not isinstance(value, int | np.integer) or value < 1:
                raise InputError(f"{name} = {value!r}: must be a whole number, at least 1")
        if not 0.0 <= self.borrow < np.inf:
            raise InputError(f"borrow = {self.borrow!r}: must be a share of a region's width, at least 0")
        if self.tolerance is not None and not self.tolerance >= 0.0:
            raise InputError(f"tolerance = {self.tolerance!r}: must be at least 0")


def _models(estimator: Any, inputs: Sequence[Variable] | None, outputs: Sequence[Variable] | None) -> list[Model]:
    if isinstance(estimator, AbductiveRegressor):
        return estimator.to_models(inputs, outputs)
    return [estimator.to_model(inputs, outputs[0] if outputs else None)]


class _Rows(NamedTuple):
    X: np.ndarray
    y: np.ndarray
    weight: np.ndarray

    def inside(self, box: np.ndarray) -> "_Rows":
        """Rows of a region: above its lower border, up to its upper one."""
        low, high = box.T
        kept = np.all((low < self.X) & (high >= self.X), axis=1)
        return _Rows(self.X[kept], self.y[kept], self.weight[kept])
