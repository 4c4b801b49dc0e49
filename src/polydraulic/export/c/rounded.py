"""What arithmetic in `float` can be off: ranges of computed values, and how far they can be from exact ones.

Running error analysis: each operation is rounded to nearest, or not at all where a compiler fuses it with the next one, and a result
too small for a normal number may be flushed to zero. Bounds are computed in double precision, whose own rounding is 2^29 times
smaller; what is added for each operation leaves room for it.

Source: N. Higham, "Accuracy and Stability of Numerical Algorithms", 2nd ed., 2002, sec. 3.3.
"""

from functools import lru_cache

import numpy as np

from polydraulic.export.c.text import FLOAT, held_in, literal

_UNIT = 2.0**-24 * (1.0 + 2.0**-10)  # half a unit in the last place, and room for rounding of the bounds
_SMALLEST = 2.0**-126 * (1.0 + 2.0**-10)  # below it a number may be flushed to zero
_LARGEST = float(np.finfo(np.float32).max)
# `sigmoid` of the code, of an argument that is exact. With u = 2^-24, by the operations of the exponential of a reduced argument r, |r| < 0.347:
# its high part is off by 0.35 u, and r by 0.7 u, which moves the quotient, at most 0.07, by 0.3 u; the quotient is rounded by 0.4 u in all, the
# sums before the last by 0.1 u and 0.42 u. That is 1.5 u where the value is 1.4 and less below it, at most 1.8 u of the value; the last sum adds
# 1 u, and the rational function differs from the exponential by less than 0.2 u: less than 5 u. The value s of a node is 1 / (1 + that), off by
# 5 u s (1 - s) and, for sum and quotient, 2 u s: less than 3 u for any s. Beyond 87, to which the code limits h, s changes by less than 2e-38.
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
        exactly = b.is_power_of_two() or self.is_power_of_two()
        return _rounded(ends.min(axis=0), ends.max(axis=0), error, 0.0 if exactly else _UNIT)

    __radd__ = __add__
    __rmul__ = __mul__

    def logistic(self) -> "Rounded":
        """1 / (1 + exp(-value)), as `sigmoid` in the code computes it."""
        low, high = (0.5 + 0.5 * np.tanh(0.5 * end) for end in (self.low, self.high))
        return Rounded(low - _LOGISTIC, high + _LOGISTIC, (0.25 * self.error + _LOGISTIC) * _UP)

    def ramp(self) -> "Rounded":
        """The nearest number in [0, 1], which takes no rounding and brings two values no further apart."""
        alike = (self.high + self.error <= 0.0) | (self.low - self.error > 1.0)
        return Rounded(np.clip(self.low, 0.0, 1.0), np.clip(self.high, 0.0, 1.0), np.where(alike, 0.0, self.error))

    def is_zero(self) -> bool:
        """Whether no value is anything but zero."""
        return not np.any(self.low) and not np.any(self.high)

    def is_power_of_two(self) -> bool:
        """Whether this is one number that a product takes no rounding with."""
        return self.low.size == 1 and bool(np.all(self.low == self.high) and np.abs(np.frexp(self.low)[0]) == 0.5)


@lru_cache(maxsize=4096)
def constant(value: float, error: float | None = None) -> Rounded:
    """A number that stands in the code, off by `error` if it is not `value` that is meant.

    Raises
    ------
    InputError
        If a `float` cannot hold it.
    """
    literal(value, FLOAT)  # refuses what does not fit
    single = held_in(value, FLOAT)
    return Rounded(*(np.array([part]) for part in (single, single, abs(value - single) if error is None else error)))


def given(low: np.ndarray, high: np.ndarray, error: float = 0.0) -> Rounded:
    """Numbers that the code is given, off by `error`; those below the normal ones may count as zero."""
    flushed = _flushed(low, high)
    return Rounded(low - flushed, high + flushed, error + flushed)


def _rounded(low: np.ndarray, high: np.ndarray, error: np.ndarray, unit: float = _UNIT) -> Rounded:
    """Result of an operation that would exactly be between `low` and `high`; inexact operands account for `error`."""
    size = np.maximum(np.abs(low), np.abs(high))
    rounding = unit * size + _flushed(low, high)
    total = (error + rounding) * _UP
    fits = (size + rounding < _LARGEST) & np.isfinite(total)
    return Rounded(low - rounding, high + rounding, np.where(fits, total, np.inf))


def _flushed(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    return np.where((low < _SMALLEST) & (high > -_SMALLEST), _SMALLEST, 0.0)
