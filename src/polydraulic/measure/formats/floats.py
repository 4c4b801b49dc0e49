"""Numbers of any type as floats."""

import numpy as np


def as_floats(values: np.ndarray) -> np.ndarray:
    """Numbers as floats of 64 bits; the least and the largest 64-bit integer, which stand for no value, are infinite."""
    found = np.asarray(values, dtype=np.float64)
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8:
        limits = np.iinfo(values.dtype)
        found[values == limits.max] = np.inf
        if limits.min < 0:
            found[values == limits.min] = -np.inf
    return found
