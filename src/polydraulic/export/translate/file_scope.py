"""What all functions of one C file share: names, structs, constants, helpers, and data. It knows nothing of functions."""

import inspect
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from polydraulic.export.translate.names import Names, field_name
from polydraulic.export.translate.types import (
    C_NUMBERS,
    FLOAT,
    INT,
    Array,
    Layouts,
    Struct,
    comment,
    declare,
    field_comments,
)
from polydraulic.export.translate.values import Value, kind_of, number
from polydraulic.flow.layout.text_module import written_name

_WIDTH = 110  # of tables
_HELPERS = {
    "minimum": """static inline double minimum(double a, double b)
{
    return (b < a) ? b : a;
}
""",
    "maximum": """static inline double maximum(double a, double b)
{
    return (b > a) ? b : a;
}
""",
    "minimum_int": """static inline int64_t minimum_int(int64_t a, int64_t b)
{
    return (b < a) ? b : a;
}
""",
    "maximum_int": """static inline int64_t maximum_int(int64_t a, int64_t b)
{
    return (b > a) ? b : a;
}
""",
    "bits_of": """static inline int64_t bits_of(double x)
{
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
""",
    "from_bits": """static inline double from_bits(int64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
""",
}


class FileScope:
    """Names and declarations at file level, as functions ask for them.

    Parameters
    ----------
    taken : sequence of str
        Names that the file uses for something else.

    Attributes
    ----------
    layouts : Layouts
    names : Names
    """

    def __init__(self, taken: Sequence[str] = ()) -> None:
        self.layouts = Layouts()
        self.names = Names()
        for name in taken:
            self.names.reserve(name, name)
        self._constants: dict[str, str] = {}
        self._helpers: set[str] = set()

    def struct_name(self, cls: type) -> str:
        """C name of a named tuple."""
        return self.names.of(cls, written_name(cls), cls.__module__)

    def helper(self, name: str) -> str:
        """Name of a small function that stands for an operation of Python."""
        self._helpers.add(name)
        return name

    def constant(self, name: str, value: Any, python: Any) -> Value:
        """A constant of a module, under its name."""
        kind = kind_of(value)
        module = python.__module__ if name.startswith("_") else ""
        found = self.names.of((name, kind, value, module), name, python.__module__)
        self._constants[found] = f"static const {C_NUMBERS[kind]} {found} = {number(value)};"
        return Value(found, kind)

    def structs(self) -> str:
        """Type definitions of all structs, parts before wholes."""
        done: dict[type, str] = {}

        def define(cls: type) -> None:
            if cls in done:
                return
            fields = self.layouts.fields[cls]
            for kind in fields.values():
                if isinstance(kind, Struct):
                    define(kind.cls)
            notes, lines = field_comments(cls), []
            for name, kind in fields.items():
                text = f"    {declare(kind, field_name(name), self.struct_name, constant=isinstance(kind, Array))};"
                lines.append(f"{text} {comment(notes[name])}" if name in notes else text)
            doc = comment((inspect.getdoc(cls) or written_name(cls)).splitlines()[0])
            done[cls] = "\n".join([doc, "typedef struct {", *lines, f"}} {self.struct_name(cls)};", ""])

        for cls in list(self.layouts.fields):
            define(cls)
        return "\n".join(done.values())

    def constants(self) -> list[str]:
        """Texts of the constants and helpers that functions have asked for."""
        parts = ["\n".join([*self._constants.values(), ""])] if self._constants else []
        return parts + [text for name, text in _HELPERS.items() if name in self._helpers]

    def data(self, value: Any, name: str, static: str = "") -> str:
        """`value`, a named tuple, as a constant struct; its arrays as constants before it.

        Raises
        ------
        InputError
            If a number in it is not a number.
        """
        arrays: list[str] = []

        def initial(value: Any, path: str, indent: str) -> str:
            if isinstance(value, np.ndarray):
                return self._array(value, path, arrays)
            if not isinstance(value, tuple):
                return number(value, path)
            deeper = indent + "    "
            lines = [
                f"{deeper}.{field_name(field)} = {initial(part, f'{path}_{field}', deeper)},"
                for field, part in zip(value._fields, value, strict=True)  # type: ignore[attr-defined]
            ]
            return "\n".join(["{", *lines, f"{indent}}}"])

        kind = self.layouts.of_value(value, name)
        text = f"{static}{declare(kind, name, self.struct_name)} = {initial(value, name, '')};"
        return "\n".join([*arrays, text, ""])

    def _array(self, value: np.ndarray, path: str, arrays: list[str]) -> str:
        if not value.size:
            return "NULL"
        kind = C_NUMBERS[FLOAT if value.dtype == np.float64 else INT]

        def nested(part: np.ndarray) -> str:
            if part.ndim > 1:
                return "{\n" + ",\n".join(nested(row) for row in part) + "\n}"
            lines = textwrap.wrap(", ".join(number(v, path) for v in part.tolist()), _WIDTH)
            return "{" + "\n    ".join(lines) + "}"

        lengths = "".join(f"[{n}]" for n in value.shape)
        arrays.append(f"static const {kind} {path}{lengths} = {nested(value)};")
        return path
