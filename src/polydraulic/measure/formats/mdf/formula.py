"""Formulas of MDF channels: arithmetic alone is computed here, any other text is left as it stands.

A conversion may be a formula, a text of the file. asammdf hands it to evaluators of Python code, and what a log says must never run.
So formulas are taken out of a file before asammdf reads a value of it.
"""

import ast
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

_KIND = {2: 10, 3: 10, 4: 3}  # number of the formulas among the conversions, by version of the format
_LONGEST = 500  # letters
_NAMES = ("X", "X1")  # what a formula calls the raw value
_OPERATIONS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.true_divide,
}


class Formula(NamedTuple):
    """A formula that was taken out of a channel.

    Attributes
    ----------
    text : str
        As the file has it.
    of : function of an array, or None
        From raw to physical values; None where the text is more than sums, products and quotients of the raw value and numbers.
    """

    text: str
    of: Callable[[np.ndarray], np.ndarray] | None

    @property
    def reason(self) -> str:
        """Why a channel with this formula is left out."""
        return (
            f"its conversion is the formula {self.text[:80]!r}, of which only +, -, *, / and brackets around X1 and numbers "
            "are computed; write the log with a scaling or a table instead"
        )


def take_formulas(file: Any, version: int) -> dict[tuple[int, int], Formula]:
    """Take the formulas out of the channels of a file that asammdf has opened: by group and place in it.

    Parameters
    ----------
    file : asammdf.MDF
        Changed: channels with a formula have no conversion any more.
    version : int
        Of the format.
    """
    found = {}
    for number, group in enumerate(file.groups):
        for place, channel in enumerate(group.channels):
            conversion = channel.conversion
            texts = [] if conversion is None else _texts(conversion, _KIND[version])
            if not texts:
                continue
            alone = conversion.conversion_type == _KIND[version]
            found[number, place] = Formula(texts[0], arithmetic(texts[0]) if alone else None)
            if not channel.unit:
                channel.unit = conversion.unit
            channel.conversion = None
    return found


def _texts(conversion: Any, kind: int) -> list[str]:
    """Formulas of a conversion, and of all that it refers to."""
    found, waiting, seen = [], [conversion], set()
    while waiting:
        one = waiting.pop()
        if one is None or isinstance(one, bytes | str) or id(one) in seen:
            continue
        seen.add(id(one))
        if one.conversion_type == kind:
            found.append(str(one.formula).strip("\0 "))
        waiting += (getattr(one, "referenced_blocks", None) or {}).values()
    return found


def arithmetic(text: str) -> Callable[[np.ndarray], np.ndarray] | None:
    """The function that a formula is, or None where it is more than arithmetic.

    Parameters
    ----------
    text : str
        Such as ``"X1 * 0.1 - 40"``.
    """
    if len(text) > _LONGEST:
        return None
    try:
        tree = ast.parse(text.strip(), mode="eval").body
        _value(tree, np.zeros(0))
    except (SyntaxError, ValueError, OverflowError, MemoryError, RecursionError):
        return None

    def of(raw: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            return np.broadcast_to(_value(tree, raw), raw.shape).astype(np.float64)

    return of


def _value(node: ast.expr, raw: np.ndarray) -> Any:
    if isinstance(node, ast.Name) and node.id in _NAMES:
        return raw
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        return float(node.value)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
        value = _value(node.operand, raw)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        return _OPERATIONS[type(node.op)](_value(node.left, raw), _value(node.right, raw))
    raise ValueError("more than arithmetic")
