"""All that one C file needs: kernels before those that call them, structs, constants, helpers, and data.

The text of a kernel is translated once for each set of argument types, as numba compiles it.
"""

from collections.abc import Callable, Sequence
from typing import Any

from polydraulic.export.translate.file_scope import FileScope
from polydraulic.export.translate.functions import FunctionTranslator
from polydraulic.export.translate.signatures import Function
from polydraulic.export.translate.types import Type


class Program:
    """Kernels that go into one C file.

    Parameters
    ----------
    taken : sequence of str
        Names that the file uses for something else.

    Attributes
    ----------
    scope : FileScope
        Structs, constants and helpers; `scope.data` writes numbers.
    functions : dict
        By kernel and argument types, in the order in which C must define them.
    """

    def __init__(self, taken: Sequence[str] = ()) -> None:
        self.scope = FileScope(taken)
        self.functions: dict[tuple[Any, tuple[Type, ...]], Function] = {}
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
        kinds = tuple(self.scope.layouts.of_value(value, f"argument {i}") for i, value in enumerate(examples))
        self.scope.names.reserve((python, kinds), name)
        return self._translated(python, kinds, static=False)

    def _kernel(self, python: Any, kinds: tuple[Type, ...]) -> Function | None:
        """Translation of a kernel that another one calls; None if that is on its way already."""
        if python in self._pending:
            return None
        return self.functions.get((python, kinds)) or self._translated(python, kinds, static=True)

    def _translated(self, python: Any, kinds: tuple[Type, ...], *, static: bool) -> Function:
        names = self.scope.names
        self._pending.append(python)
        known = [key for key in self.functions if key[0] is python]
        name = names.of((python, kinds), python.__name__, python.__module__)
        found = FunctionTranslator(self.scope, self._kernel, python).translate(name, kinds, static=static)
        self._pending.pop()
        for key in known:  # arrays of other lengths may give the same text
            other = self.functions[key]
            if other.text.replace(f" {other.name}(", f" {name}(", 1) == found.text:
                names.forget((python, kinds))
                found = other
        self.functions[python, kinds] = found
        return found

    def code(self) -> str:
        """Constants, helpers and functions."""
        functions = list({id(f): f for f in self.functions.values()}.values())
        return "\n".join([*self.scope.constants(), *(f.text for f in functions)])
