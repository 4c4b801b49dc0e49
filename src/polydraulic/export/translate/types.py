"""Types of kernel values, read from example arguments and annotations, and how C declares them.

A number is `double`, `int64_t` or `bool`; a named tuple is a struct; an array is a pointer to numbers, or to rows of
fixed length. Types flow forward: those of parameters from examples, those of results from the annotations of the named
tuples that hold them.
"""

import ast
import inspect
import re
import sys
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, get_type_hints

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.text_module import written_name

LARGE = 4  # structs of more numbers are handed over by pointer


@dataclass(frozen=True)
class Scalar:
    """A number, named as in Python."""

    name: str


@dataclass(frozen=True)
class Array:
    """A contiguous array; the first length is None where arrays of several lengths stand in one field."""

    element: Scalar
    shape: tuple[int | None, ...]


@dataclass(frozen=True)
class Struct:
    """A named tuple."""

    cls: type


Type = Scalar | Array | Struct
FLOAT, INT, BOOL, NOTHING = Scalar("float"), Scalar("int"), Scalar("bool"), Scalar("None")
C_NUMBERS = {FLOAT: "double", INT: "int64_t", BOOL: "bool", NOTHING: "void"}
_SCALARS: dict[Any, Scalar] = {float: FLOAT, int: INT, bool: BOOL, type(None): NOTHING}


def is_named_tuple(cls: Any) -> bool:
    """Whether `cls` is a class of named tuples."""
    return isinstance(cls, type) and issubclass(cls, tuple) and hasattr(cls, "_fields")


class Layouts:
    """Fields of all structs that have been met, in the order in which C must declare them."""

    def __init__(self) -> None:
        self.fields: dict[type, dict[str, Type]] = {}

    def of_value(self, value: Any, where: str) -> Type:
        """Type of an example; `where` names it in errors.

        Raises
        ------
        InputError
            If C has no counterpart.
        """
        if isinstance(value, bool | np.bool_):
            return BOOL
        if isinstance(value, int | np.integer):
            return INT
        if isinstance(value, float):
            return FLOAT
        if isinstance(value, np.ndarray):
            if value.dtype not in (np.float64, np.int64) or value.ndim == 0:
                raise InputError(f"{where}: an array of {value.dtype}, {value.shape}; must be of float64 or int64")
            return Array(FLOAT if value.dtype == np.float64 else INT, value.shape)
        if is_named_tuple(type(value)):
            fields = {name: self.of_value(getattr(value, name), f"{where}.{name}") for name in value._fields}
            known = self.fields.get(type(value), fields)
            self.fields[type(value)] = {name: _both(known[name], fields[name], f"{where}.{name}") for name in fields}
            return Struct(type(value))
        raise InputError(
            f"{where}: a {type(value).__name__}, which has no counterpart in C; "
            "use float, int, bool, an array or a named tuple of these"
        )

    def of_annotation(self, hint: Any, where: str) -> Type:
        """Type that an annotation names."""
        if hint in _SCALARS:
            return _SCALARS[hint]
        if is_named_tuple(hint):
            if hint not in self.fields:
                hints = get_type_hints(hint)
                self.fields[hint] = {
                    name: self.of_annotation(hints[name], f"{written_name(hint)}.{name}") for name in hint._fields
                }
            return Struct(hint)
        raise InputError(f"{where}: annotated {hint}; must be float, int, bool or a named tuple of these")

    def size(self, kind: Type) -> int:
        """Numbers and pointers in a value."""
        if not isinstance(kind, Struct):
            return 1
        return sum(self.size(field) for field in self.fields[kind.cls].values())

    def large(self, kind: Type) -> bool:
        """Whether values are handed over by pointer."""
        return isinstance(kind, Struct) and self.size(kind) > LARGE


def _both(a: Type, b: Type, where: str) -> Type:
    if a == b:
        return a
    if isinstance(a, Array) and isinstance(b, Array) and (a.element, a.shape[1:]) == (b.element, b.shape[1:]):
        return Array(a.element, (None, *a.shape[1:]))
    raise InputError(f"{where}: {a} in one place and {b} in another; a field has one type and rows of one length")


def declare(kind: Type, name: str, struct_name: Any, *, constant: bool = True) -> str:
    """C declaration of `name`; `constant`: the value, or what an array points at, does not change.

    Parameters
    ----------
    kind : Type
    name : str
    struct_name : function class -> name of its struct
    constant : bool
    """
    prefix = "const " if constant else ""
    if isinstance(kind, Array):
        rows = "".join(f"[{length}]" for length in kind.shape[1:])
        return f"{prefix}{C_NUMBERS[kind.element]} " + (f"(*{name}){rows}" if rows else f"*{name}")
    if isinstance(kind, Struct):
        return f"{prefix}{struct_name(kind.cls)} {name}"
    return f"{prefix}{C_NUMBERS[kind]} {name}"


def field_comments(cls: type) -> dict[str, str]:
    """Comments behind the fields of a named tuple."""
    text = _classes_of(inspect.getsource(sys.modules[cls.__module__])).get(cls.__qualname__) or inspect.getsource(cls)
    return dict(re.findall(r"^    (\w+):[^#\n]*#\s*(.*?)\s*$", text, flags=re.MULTILINE))


@lru_cache(maxsize=16)  # modules: to parse one for each of its classes would take most of an export
def _classes_of(source: str) -> dict[str, str]:
    """The text of each class of a module that stands in nothing else."""
    lines = source.splitlines()
    classes = (node for node in ast.parse(source).body if isinstance(node, ast.ClassDef))
    return {node.name: "\n".join(lines[node.lineno - 1 : node.end_lineno]) for node in classes}


def comment(text: str, indent: str = "") -> str:
    """`text` as a C comment."""
    return f"{indent}/* {text.replace('*/', '* /')} */"
