"""A translated kernel, as its callers see it."""

from dataclasses import dataclass
from typing import Any

from polydraulic.export.translate.types import Type


@dataclass(frozen=True)
class Parameter:
    """A parameter: its C name, whether a struct comes by pointer, whether the array it is gets written."""

    name: str
    type: Type
    pointer: bool
    written: bool


@dataclass(frozen=True)
class Function:
    """A translated kernel; `locals` are the types of its variables by Python name."""

    name: str
    python: Any
    parameters: list[Parameter]
    result: Type
    locals: dict[str, Type]
    text: str
    prototype: str

    @property
    def writes(self) -> bool:
        """Whether it changes anything that its caller sees."""
        return any(parameter.written for parameter in self.parameters)
