"""AbductiveClassifier: networks of class indicators behind a logistic output.

One network per class is grown on its indicator (one alone for two classes), by least squares as everywhere else; a logistic
regression on their outputs turns them into probabilities.
"""

from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, ClassifierMixin, clone
from sklearn.linear_model import LogisticRegression
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from polydraulic.errors import InputError
from polydraulic.networks.growth.regressor import AbductiveRegressor


class AbductiveClassifier(ClassifierMixin, BaseEstimator):
    """Polynomial abductive networks for classification.

    Parameters
    ----------
    estimator : AbductiveRegressor, optional
        Settings of the networks.

    Attributes
    ----------
    classes_ : (n_class,) array
    estimator_ : AbductiveRegressor
        One network per class, or one for two classes.
    link_ : LogisticRegression
        From network outputs to probabilities.
    n_features_in_ : int

    Examples
    --------
    >>> import numpy as np
    >>> X = np.random.default_rng(0).uniform(-1, 1, size=(400, 2))
    >>> model = AbductiveClassifier().fit(X, X[:, 0] * X[:, 1] > 0)
    >>> bool(model.predict([[0.5, 0.4]])[0])
    True
    """

    def __init__(self, estimator: AbductiveRegressor | None = None) -> None:
        self.estimator = estimator

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> "AbductiveClassifier":
        """Grow the networks and fit the link.

        Raises
        ------
        ValueError
            As for `AbductiveRegressor`; also a target with a single class, or with continuous values.
        """
        X, y = validate_data(self, X, y, dtype=np.float64, ensure_min_samples=2)
        check_classification_targets(y)
        weight = None if sample_weight is None else _check_sample_weight(sample_weight, X, ensure_non_negative=True)
        used = slice(None) if weight is None else weight > 0.0
        X, y, weight = X[used], y[used], None if weight is None else weight[used]
        self.classes_, place = np.unique(y, return_inverse=True)
        if self.classes_.size < 2:
            raise InputError(f"the target holds 1 class, {self.classes_[0]!r}; a classifier needs at least two")
        indicators = (place[:, None] == np.arange(self.classes_.size)).astype(np.float64)
        base = AbductiveRegressor() if self.estimator is None else clone(self.estimator)
        self.estimator_ = base.fit(X, indicators if self.classes_.size > 2 else indicators[:, 1], weight)
        self.link_ = LogisticRegression(max_iter=1000).fit(self._scores(X), place, weight)
        return self

    def predict_proba(self, X: Any) -> np.ndarray:
        """Probability of each class, shape (n_row, n_class)."""
        check_is_fitted(self)
        X = validate_data(self, X, reset=False, dtype=np.float64)
        return np.asarray(self.link_.predict_proba(self._scores(X)))

    def predict(self, X: Any) -> np.ndarray:
        """Most probable class of each row, shape (n_row,)."""
        probability = self.predict_proba(X)
        return np.asarray(self.classes_[probability.argmax(axis=1)])

    def _scores(self, X: np.ndarray) -> np.ndarray:
        return np.asarray(self.estimator_.predict(X)).reshape(len(X), -1)
