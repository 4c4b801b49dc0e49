"""What a parameter may be: its SI unit, its range, and the one check that a value lies in it."""

import types
from dataclasses import dataclass
from math import inf
from numbers import Real
from typing import Any, NamedTuple, get_args

# in SI: far beyond any machine, while products and quotients of several are still numbers
SMALLEST, LARGEST = 1e-30, 1e20


@dataclass(frozen=True)
class Quantity:
    """SI unit and allowed range of a parameter; `above` is a limit that the value itself may not touch.

    Besides, a value is 0 or of a size from `SMALLEST` to `LARGEST`.
    """

    unit: str
    low: float = -inf
    high: float = inf
    above: float = -inf

    def demand(self, value: float) -> str:
        """What every value must be, in words that tell what is wrong with this one, in SI."""
        if abs(value) < inf and not _has_usual_size(value):
            return f"must be 0 or of a size from {SMALLEST:g} to {LARGEST:g} in SI units"
        return f"must be {'' if abs(value) < inf else 'finite and '}{self._range()}"

    def _range(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        if self.above > -inf:
            return f"above {self.above:g}{unit}" + (f", at most {self.high:g}{unit}" if self.high < inf else "")
        if self.high < inf:
            return f"in [{self.low:g}, {self.high:g}]{unit}"
        return f"{self.low:g}{unit} or more" if self.low > -inf else f"a number{f' of{unit}' if unit else ''}"

    def allows(self, value: float) -> bool:
        """Whether a value is finite and lies in the range."""
        return _has_usual_size(value) and self.low <= value <= self.high and value > self.above


def _has_usual_size(value: float) -> bool:
    return value == 0.0 or SMALLEST <= abs(value) <= LARGEST  # also of an integer that no float holds


class LeafKind(NamedTuple):
    """A value of a parameter tree: a quantity, `size` of them, or a switch."""

    quantity: Quantity | None
    size: int = 0  # 0: a single number
    resizes: bool = False  # whether another value may have more or fewer of them


def leaf_of(hint: Any) -> LeafKind | None:
    """What an annotation of the schema says of a value; None where it is a tree."""
    if hint is bool:
        return LeafKind(None)
    if isinstance(hint, type) and issubclass(hint, tuple):
        return None
    shape, quantity = get_args(hint)
    return LeafKind(quantity, len(get_args(shape)) if isinstance(shape, types.GenericAlias) else 0)


def is_number(value: Any) -> bool:
    """Whether a value is a number; true and false are none."""
    return isinstance(value, Real) and not isinstance(value, bool)
