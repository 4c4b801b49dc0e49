"""C text of values, with what it takes to put one into another: type, binding, address."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.translate.types import BOOL, FLOAT, INT, Scalar, Struct, Type
from polydraulic.flow.layout.text_module import written_name

# How strongly C binds what stands at the top of an expression.
CHOICE, OR, AND, BITS, EQUAL, ORDER, SHIFT, SUM, PRODUCT, UNARY, POSTFIX, WORD = range(12)


@dataclass(frozen=True)
class Value:
    """C text of an expression.

    Attributes
    ----------
    text : str
    type : Type
    binds : int
        What stands at its top, from CHOICE to WORD.
    pointer : bool
        Whether the text points at the struct instead of being it.
    place : bool
        Whether it has an address.
    """

    text: str
    type: Type
    binds: int = WORD
    pointer: bool = False
    place: bool = False

    def inside(self, binds: int) -> str:
        """Text as an operand of something that binds so strongly."""
        return self.text if self.binds >= binds else f"({self.text})"


def as_float(value: Value) -> Value:
    """Whole numbers become floats."""
    if value.type != INT:
        return value
    if value.text.isdigit():
        return Value(f"{value.text}.0", FLOAT)
    return Value(f"(double){value.inside(UNARY)}", FLOAT, UNARY)


def plain(value: Value) -> Value:
    """The struct itself where the text points at it."""
    return Value(f"*{value.inside(UNARY)}", value.type, UNARY) if value.pointer else value


def shown(kind: Type) -> str:
    """A type in words."""
    if isinstance(kind, Struct):
        return written_name(kind.cls)
    return kind.name if isinstance(kind, Scalar) else f"an array of {kind.element.name}, {kind.shape}"


def literal_value(value: Any) -> Value:
    """A number as C text that reads back exactly."""
    text = number(value)
    return Value(text, kind_of(value), UNARY if text.startswith("-") else WORD)


def kind_of(value: Any) -> Scalar:
    """Type of a number."""
    return BOOL if isinstance(value, bool) else INT if isinstance(value, int) else FLOAT


def number(value: Any, where: str = "constant") -> str:
    """C text of a number that reads back exactly.

    Raises
    ------
    InputError
        If it is not a number.
    """
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, int | np.integer):
        return str(int(value)) if abs(int(value)) < 2**31 else f"INT64_C({int(value)})"
    if math.isnan(value):
        raise InputError(f"{where} is not a number, and cannot be exported")
    if math.isinf(value):
        return "HUGE_VAL" if value > 0.0 else "-HUGE_VAL"
    return repr(float(value))
