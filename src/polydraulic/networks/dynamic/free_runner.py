"""What estimators of dynamic models share: rows that are checked, runs on their own answers, models by the names of signals."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_array, check_is_fitted, validate_data

from polydraulic.errors import InputError
from polydraulic.networks.dynamic.free_run import prepare_loop, simulate_spans
from polydraulic.networks.dynamic.signal_names import renamed
from polydraulic.networks.model.fitted import variables
from polydraulic.networks.model.model import Model, Variable


class FreeRunner(BaseEstimator):
    """An estimator whose `fit` leaves `models_`, one per output, `n_outputs_` and `warm_up_`."""

    _output = "output"  # as messages call one

    def simulate(self, X: Any, y: Any, *, segments: Any = None, horizon: int | None = None) -> np.ndarray:
        """Run on its own from the first `warm_up_` rows of each segment.

        Parameters
        ----------
        X : (n_row, n_input) array-like of finite float
        y : (n_row,) or (n_row, n_output) array-like
            Measured outputs, of which only the first `warm_up_` rows of each segment are read; the rest may be NaN.
        segments : (n_row,) array-like, optional
            Labels; each segment is a run of its own.
        horizon : int, optional
            Restart from measured outputs after this many rows.

        Returns
        -------
        array of the shape of `y`
            The measured rows at the start of each segment, then the answers.
        """
        check_is_fitted(self)
        X, y = self._checked(X, y, reset=False)
        names = self._names()
        loop = prepare_loop(self.models_, names)
        found = simulate_spans(loop, np.column_stack([X, y]), names, self.warm_up_, segments, horizon)
        return found.reshape(y.shape)

    def predict(self, X: Any, y: Any, *, segments: Any = None) -> np.ndarray:
        """Predict each row from measured ones before it; arguments and result as `simulate`."""
        return self.simulate(X, y, segments=segments, horizon=1)

    def to_models(
        self, inputs: Sequence[Variable] | None = None, outputs: Sequence[Variable] | None = None
    ) -> list[Model]:
        """Return one model per output, with names and units of the signals (not of their lags)."""
        check_is_fitted(self)
        signals = [*variables(self, inputs), *(self._outputs() if outputs is None else outputs)]
        if len(signals) != self.n_features_in_ + self.n_outputs_:
            raise InputError(f"{len(outputs or [])} output names for a model with {self.n_outputs_} outputs")
        return renamed(self.models_, dict(zip(self._names(), signals, strict=True)))

    def _names(self) -> list[str]:
        return [variable.name for variable in (*variables(self, None), *self._outputs())]

    def _outputs(self) -> list[Variable]:
        return [Variable(f"y{k}" if self.n_outputs_ > 1 else "y") for k in range(self.n_outputs_)]

    def _checked(self, X: Any, y: Any, *, reset: bool) -> tuple[np.ndarray, np.ndarray]:
        X = validate_data(self, X, reset=reset, dtype=np.float64, ensure_all_finite="allow-nan")
        y = check_array(y, dtype=np.float64, ensure_2d=False, ensure_all_finite="allow-nan", input_name="y")
        if y.ndim > 2 or len(y) != len(X):
            raise InputError(f"y has shape {y.shape}; it must be ({len(X)},) or ({len(X)}, n_{self._output})")
        if not reset and y.size != len(X) * self.n_outputs_:
            raise InputError(f"y has shape {y.shape}; the model has {self.n_outputs_} {self._output}s")
        return X, y

    def _whole(self, name: str, least: int = 1) -> int:
        value = getattr(self, name)
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
            raise InputError(f"{name} = {value!r}: must be a whole number, at least {least}")
        return int(value)
