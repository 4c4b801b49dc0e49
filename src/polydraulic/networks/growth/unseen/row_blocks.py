"""Which rows depend on each other: groups that are given, or stretches of a log, found from the order of its rows.

Rows drawn independently differ from the row before as much as from any other; in a log they hardly differ from it. Where all inputs are
like that, rows next to each other are not independent, and the log is cut into stretches that are.
"""

from typing import Any

import numpy as np

from polydraulic.errors import InputError

STRETCHES = 10  # of a log: longer than its memory, and enough of them to choose by
_MOST = 100  # blocks; of more groups several are left out together
_SLOW = 0.1  # half the squared step from row to row, as a share of the variance: 1 for independent rows
_LEAST_ROWS = 20  # in a stretch


def row_blocks(X: np.ndarray, groups: Any = None) -> np.ndarray | None:
    """Number of the block of each row, (n_row,), rising from 0; None where rows count as independent.

    Parameters
    ----------
    X : (n_row, n_input) array
        In the order in which rows were measured.
    groups : (n_row,) array-like, optional
        Rows with the same label depend on each other; where each row has its own, none do. Without it, blocks are found.

    Raises
    ------
    InputError
        If there is not one label per row, or they are all the same.
    """
    if groups is None:
        return np.arange(len(X)) * STRETCHES // len(X) if is_log(X) else None
    labels = np.asarray(groups)
    if labels.shape != (len(X),):
        raise InputError(f"groups has shape {labels.shape}; it must hold one label for each of the {len(X)} rows")
    found, block = np.unique(labels, return_inverse=True)
    if found.size < 2:
        raise InputError(
            f"groups holds one label, {found.tolist()[0]!r}: name at least two groups, or leave groups out"
        )
    if found.size == len(X):
        return None
    return np.asarray(block) * min(_MOST, found.size) // found.size


def is_log(X: np.ndarray) -> bool:
    """Whether every input that comes back to where it was moves slowly from row to row.

    An input that only rises or falls, the key of a sorted table or the time, says nothing. Rows repeated one after the other
    count once.
    """
    moved = np.any(X[1:] != X[:-1], axis=1)
    X = X[np.concatenate([[True], moved])]
    if len(X) < STRETCHES * _LEAST_ROWS:
        return False
    width = np.ptp(X, axis=0)
    X = (X[:, width > 0.0] - X.min(axis=0)[width > 0.0]) / width[width > 0.0]
    step = np.diff(X, axis=0)
    returns = np.any(step > 0.0, axis=0) & np.any(step < 0.0, axis=0)
    roughness = 0.5 * np.mean(step**2, axis=0) / np.var(X, axis=0)
    return bool(returns.any() and np.all(roughness[returns] < _SLOW))
