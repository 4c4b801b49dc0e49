"""Arguments of which there is one for all machines, or one for each."""

from operator import index
from typing import Any

import numpy as np

from polydraulic.errors import InputError, briefly


def per_machine(value: Any, what: str, n: int, *, low: float | None = None) -> np.ndarray:
    """A finite value for each machine, (n,) array.

    Parameters
    ----------
    value : float or (n,) array
    what : str
        Its name, for messages.
    n : int
    low : float, optional
        The least that it may be.

    Raises
    ------
    InputError
    """
    found = as_many(value, what, n)
    bad = np.flatnonzero(~np.isfinite(found) | (found < (-np.inf if low is None else low)))
    if bad.size:
        least = "" if low is None else f", at least {low:g}"
        raise InputError(f"{what} = {found[bad[0]]} of machine {bad[0]}: must be a finite number{least}")
    return found


def as_many(value: Any, what: str, n: int) -> np.ndarray:
    """A number for each machine, whatever it is, (n,) array.

    Raises
    ------
    InputError
    """
    try:
        found = np.asarray(value)
    except ValueError:  # rows of several lengths
        found = np.empty(0, dtype=object)
    if found.dtype.kind not in "fiu" or found.shape not in ((), (n,)):
        raise InputError(f"{what} = {briefly(value)}: must be one number for all machines, or {n}, one for each")
    return np.array(np.broadcast_to(found, (n,)), dtype=np.float64)


def count(value: Any, what: str, most: int) -> int:
    """A whole number from 1 on.

    Raises
    ------
    InputError
    """
    try:
        found = index(value)
    except TypeError:
        found = 0
    if not 1 <= found <= most:
        raise InputError(f"{what} = {briefly(value)}: must be a whole number, from 1 to {most:g}")
    return found
