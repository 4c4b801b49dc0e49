"""Whether inputs say anything of a target: small networks, learnt without a fifth of the rows, next to the mean on that fifth.

What little a search learns from four fifths of the rows need not be the network that was found; it is enough that it tells more than the
mean does of rows that it has not seen, which in a target that depends on nothing it hardly ever does.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from polydraulic.networks.growth.derivatives import coefficients, forward
from polydraulic.networks.growth.synthesis import Settings, synthesize
from polydraulic.networks.growth.training_rows import TrainingRows, in_blocks
from polydraulic.networks.hold_out import FOLD


def helps_on_others(
    rows: TrainingRows, settings: Settings, chosen: Callable[[TrainingRows], np.ndarray], *, apart: bool
) -> bool:
    """Whether networks of one layer err less than the mean on rows left out, all fifths of the rows together.

    Parameters
    ----------
    rows : TrainingRows
        If `apart`, with a block for all that depends on each other.
    settings : Settings
    chosen : function of TrainingRows
        Inputs that a search through these rows may read.
    apart : bool
        Whether whole blocks are left out, every fifth; rows drawn at random if not, equal ones together.
    """
    parts = list(rows.blocks())
    X, y = (np.concatenate([part[place] for part in parts]) for place in (0, 1))
    w = np.concatenate([np.ones(len(part[1])) if part[2] is None else part[2] for part in parts])
    number = np.repeat(np.arange(len(parts)), [len(part[1]) for part in parts])
    fold = number % FOLD if apart else _at_random(X, y)
    small = replace(settings, max_layers=1)
    gained = 0.0
    for held in np.unique(fold):
        without = fold != held
        if without.any():
            gained += _gain(rows, X, y, w, without, small, chosen)
    return gained > 0.0


def _at_random(X: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Folds (n_row,) of rows, of equal ones the same: what is seen in one fold is new in none, and a weight counts as repetitions do."""
    _, which = np.unique(np.column_stack([X, y]), axis=0, return_inverse=True)
    return np.random.default_rng(0).permutation(which.max() + 1)[which] % FOLD


def _gain(
    rows: TrainingRows,
    X: np.ndarray,
    y: np.ndarray,
    w: np.ndarray,
    learnt: np.ndarray,
    settings: Settings,
    chosen: Callable[[TrainingRows], np.ndarray],
) -> float:
    """By how much a network errs less than the mean of the rows learnt, squares summed over all others."""
    low, high = X[learnt].min(axis=0), X[learnt].max(axis=0)
    scaling = rows.scaling._replace(
        weight=float(w[learnt].sum()), n_row=int(np.count_nonzero(learnt)), x_low=low, x_high=high
    )
    part = TrainingRows(in_blocks(X[learnt], y[learnt], w[learnt]), scaling)
    networks, _ = synthesize(part, chosen(part), settings)
    if not networks[-1]:
        return 0.0
    free, coef = coefficients(networks[-1])
    x = (np.clip(X[~learnt], low, high) - scaling.x_mean) / scaling.x_scale
    target = (y - scaling.y_mean) / scaling.y_scale
    output = np.clip(forward(free, coef, x)[0][-1], target[learnt].min(), target[learnt].max())
    mean = np.average(target[learnt], weights=w[learnt])
    return float(w[~learnt] @ ((target[~learnt] - mean) ** 2 - (target[~learnt] - output) ** 2))
