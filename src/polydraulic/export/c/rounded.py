"""What arithmetic in `float` can be off: ranges of computed values, and how far they can be from exact ones.

Running error analysis: each operation is rounded to nearest, or not at all where a compiler fuses it with the next one, and a result
too small for a normal number may be flushed to zero. Bounds are computed in double precision, whose own rounding is 2^29 times
smaller; what is added for each operation leaves room for it.

Source: N. Higham, "Accuracy and Stability of Numerical Algorithms", 2nd ed., 2002, sec. 3.3.
"""

from functools import lru_cache

import numpy as np

from polydraulic.export.c.text import FLOAT, literal, stored

_UNIT = 2.0**-24 * (1.0 + 2.0**-10)  # half a unit in the last place, and room for rounding of the bounds
_SMALLEST = 2.0**-126 * (1.0 + 2.0**-10)  # below it a number may be flushed to zero
_LARGEST = float(np.finfo(np.float32).max)
# `sigmoid` of the code, for an argument that is exact. With u = 2^-24: -h is limited to 87 (beyond, the value changes by less than 2e-38), the
# reduced argument is off by 0.4 u, the quotient in the exponential, at most 0.075, by 0.5 u, sums of size 0.08, 0.42 and 1.42 are rounded, and
# the rational function differs from the exponential by less than 0.2 u: 5 u of its value at most. The value s of the node is 1 / (1 + that), so
# that s (1 - s) 5 u come from the exponential and 2 u s from sum and quotient: less than 3 u for all s from 0 to 1.
_LOGISTIC = 3.0 * _UNIT
_UP = 1.0 + 2.0**-48  # above the rounding of a bound that is a sum of a few products


class Rounded:
    """Values that `float` code computes, over m boxes.

    Attributes
    ----------
    low, high : (m,) array
        Between them lies the computed value.
    error : (m,) array
        The exact value is no further from the computed one; infinite where something may overflow.
    """

    __slots__ = ("error", "high", "low")
    __array_ufunc__ = None  # numpy's scalars leave the operation to this class

    def __init__(self, low: np.ndarray, high: np.ndarray, error: np.ndarray) -> None:
        self.low, self.high, self.error = low, high, error

    @property
    def size(self) -> np.ndarray:
        """Largest magnitude of a computed value."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    def __add__(self, other: "Rounded | float") -> "Rounded":
        b = other if isinstance(other, Rounded) else constant(other)
        error = (self.error + b.error) * _UP
        if b.is_zero() or self.is_zero():  # exact
            return Rounded(self.low + b.low, self.high + b.high, error)
        return _rounded(self.low + b.low, self.high + b.high, error)

    def __mul__(self, other: "Rounded | float") -> "Rounded":
        b = other if isinstance(other, Rounded) else constant(other)
        error = (self.size * b.error + b.size * self.error + self.error * b.error) * _UP
        if b.is_zero() or self.is_zero():
            nothing = np.zeros_like(error)
            return Rounded(nothing, nothing, np.where(np.isnan(error), np.inf, error))
        ends = np.array([self.low * b.low, self.low * b.high, self.high * b.low, self.high * b.high])
        return _rounded(ends.min(axis=0), ends.max(axis=0), error)

    __radd__ = __add__
    __rmul__ = __mul__

    def logistic(self) -> "Rounded":
        """1 / (1 + exp(-value)), as `sigmoid` in the code computes it."""
        low, high = (0.5 + 0.5 * np.tanh(0.5 * end) for end in (self.low, self.high))
        return Rounded(low - _LOGISTIC, high + _LOGISTIC, (0.25 * self.error + _LOGISTIC) * _UP)

    def is_zero(self) -> bool:
        """Whether no value is anything but zero."""
        return not np.any(self.low) and not np.any(self.high)


@lru_cache(maxsize=4096)
def constant(value: float, error: float | None = None) -> Rounded:
    """A number that stands in the code, off by `error` if it is not `value` that is meant.

    Raises
    ------
    InputError
        If a `float` cannot hold it.
    """
    literal(value, FLOAT)  # refuses what does not fit
    single = stored(value, FLOAT)
    return Rounded(*(np.array([part]) for part in (single, single, abs(value - single) if error is None else error)))


def given(low: np.ndarray, high: np.ndarray, error: float = 0.0) -> Rounded:
    """Numbers that the code is given, off by `error`; those below the normal ones may count as zero."""
    flushed = _flushed(low, high)
    return Rounded(low - flushed, high + flushed, error + flushed)


def _rounded(low: np.ndarray, high: np.ndarray, error: np.ndarray) -> Rounded:
    """Result of an operation that would exactly be between `low` and `high`; inexact operands account for `error`."""
    size = np.maximum(np.abs(low), np.abs(high))
    rounding = _UNIT * size + _flushed(low, high)
    total = (error + rounding) * _UP
    fits = (size + rounding < _LARGEST) & np.isfinite(total)
    return Rounded(low - rounding, high + rounding, np.where(fits, total, np.inf))


def _flushed(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    return np.where((low < _SMALLEST) & (high > -_SMALLEST), _SMALLEST, 0.0)
