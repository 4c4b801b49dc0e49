"""All that one C file needs: kernels before those that call them, structs, constants, helpers, and data.

The text of a kernel is translated once for each set of argument types, as numba compiles it.
"""

import inspect
import math
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import polydraulic
from polydraulic.errors import InputError
from polydraulic.export.translate.expressions import UNARY, WORD, Expressions, Value
from polydraulic.export.translate.functions import Function, FunctionTranslator
from polydraulic.export.translate.names import Names, field_name
from polydraulic.export.translate.types import (
    BOOL,
    C_NUMBERS,
    FLOAT,
    INT,
    Array,
    Layouts,
    Scalar,
    Struct,
    Type,
    comment,
    declare,
    field_comments,
)

_ROOT = Path(polydraulic.__file__).parent.parent
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


class Program:
    """Kernels that go into one C file.

    Parameters
    ----------
    taken : sequence of str
        Names that the file uses for something else.

    Attributes
    ----------
    layouts : Layouts
    functions : dict
        By kernel and argument types, in the order in which C must define them.
    """

    def __init__(self, taken: Sequence[str] = ()) -> None:
        self.layouts = Layouts()
        self.functions: dict[tuple[Any, tuple[Type, ...]], Function] = {}
        self._names = Names()
        for name in taken:
            self._names.reserve(name, name)
        self._constants: dict[str, str] = {}
        self._helpers: set[str] = set()
        self._pending: list[Any] = []

    def entry(self, name: str, kernel: Callable[..., Any], examples: Sequence[Any]) -> Function:
        """Translate a kernel and all that it calls.

        Parameters
        ----------
        name : str
            Of the C function, which is visible outside its file.
        kernel : function decorated with `kernel`
        examples : sequence
            An argument of each parameter: they give types, structs and the lengths of arrays.

        Raises
        ------
        InputError
            With file, line and what to do, where something does not translate.
        """
        python = getattr(kernel, "py_func", kernel)
        kinds = tuple(self.layouts.of_value(value, f"argument {i}") for i, value in enumerate(examples))
        self._names.reserve((python, kinds), name)
        return self._translated(python, kinds, static=False)

    def function(self, python: Any, kinds: tuple[Type, ...], caller: Expressions, node: Any) -> Function:
        """Return the translation of a kernel that another one calls."""
        if python in self._pending:
            caller.refuse(node, f"{python.__name__} calls itself; write a loop with a bound")
        return self.functions.get((python, kinds)) or self._translated(python, kinds, static=True)

    def _translated(self, python: Any, kinds: tuple[Type, ...], *, static: bool) -> Function:
        self._pending.append(python)
        known = [key for key in self.functions if key[0] is python]
        name = self._names.of((python, kinds), python.__name__, python.__module__)
        found = FunctionTranslator(self, python).translate(name, kinds, static=static)
        self._pending.pop()
        for key in known:  # arrays of other lengths may give the same text
            other = self.functions[key]
            if other.text.replace(f" {other.name}(", f" {name}(", 1) == found.text:
                self._names.forget((python, kinds))
                found = other
        self.functions[python, kinds] = found
        return found

    def shown_file(self, python: Any) -> str:
        """File of a function, from the folder of the package if it belongs to it."""
        path = Path(inspect.getsourcefile(python) or "?")
        return path.relative_to(_ROOT).as_posix() if path.is_relative_to(_ROOT) else path.as_posix()

    def struct_name(self, cls: type) -> str:
        """C name of a named tuple."""
        return self._names.of(cls, cls.__name__, cls.__module__)

    def helper(self, name: str) -> str:
        """Name of a small function that stands for an operation of Python."""
        self._helpers.add(name)
        return name

    def literal(self, value: Any) -> Value:
        """A number as C text that reads back exactly."""
        text = number(value)
        return Value(text, _kind(value), UNARY if text.startswith("-") else WORD)

    def constant(self, name: str, value: Any, python: Any) -> Value:
        """A constant of a module, under its name."""
        kind = _kind(value)
        module = python.__module__ if name.startswith("_") else ""
        found = self._names.of((name, kind, value, module), name, python.__module__)
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
            doc = comment((inspect.getdoc(cls) or cls.__name__).splitlines()[0])
            done[cls] = "\n".join([doc, "typedef struct {", *lines, f"}} {self.struct_name(cls)};", ""])

        for cls in list(self.layouts.fields):
            define(cls)
        return "\n".join(done.values())

    def code(self) -> str:
        """Constants, helpers and functions."""
        functions = list({id(f): f for f in self.functions.values()}.values())
        parts = ["\n".join([*self._constants.values(), ""])] if self._constants else []
        parts += [text for name, text in _HELPERS.items() if name in self._helpers]
        return "\n".join([*parts, *(f.text for f in functions)])

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


def _kind(value: Any) -> Scalar:
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
