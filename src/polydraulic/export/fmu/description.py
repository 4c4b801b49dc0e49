"""What an FMU is called and which variables it has: all that its XML and its tables are written from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from polydraulic.errors import InputError


@dataclass(frozen=True)
class FmuVariable:
    """One variable, a real number.

    Attributes
    ----------
    name : str
        Any text, different from all others.
    kind : "input", "output", "parameter" or "fixed parameter"
        A parameter can be changed at any time, a fixed one until initialization ends.
    unit : str
        As in `polydraulic.units` if it is to be converted for display; none if empty.
    start : float
        Of inputs and parameters.
    low, high, nominal : float, optional
        Smallest and largest value, and the usual size (not 0).
    description : str
    dependencies : tuple of str, optional
        Of an output: the inputs that it depends on at one time; all if not given.
    """

    name: str
    kind: Literal["input", "output", "parameter", "fixed parameter"]
    unit: str = ""
    start: float = 0.0
    low: float | None = None
    high: float | None = None
    nominal: float | None = None
    description: str = ""
    dependencies: tuple[str, ...] | None = None


@dataclass(frozen=True)
class FmuDescription:
    """An FMU from the outside.

    Attributes
    ----------
    name : str
        A C identifier: name of the binaries and prefix of the functions.
    variables : tuple of FmuVariable
        Their places are their value references.
    description : str
    model_exchange : bool
        Whether there is model exchange besides co-simulation: only if the outputs follow from inputs alone.
    derivatives : bool
        Whether outputs have exact derivatives by inputs.
    step : float, optional
        Internal step in s of what has a memory; also the step that is proposed to the importer.
    memory : int
        How many numbers the equations keep from step to step.
    stop : float
        End in s of the experiment that is proposed.
    """

    name: str
    variables: tuple[FmuVariable, ...]
    description: str = ""
    model_exchange: bool = True
    derivatives: bool = True
    step: float | None = None
    memory: int = 0
    stop: float = 1.0

    def __post_init__(self) -> None:
        names = [variable.name for variable in self.variables]
        if len(set(names)) < len(names):
            raise InputError(f"the variables of FMU {self.name!r} are named {names}: they must differ")

    def of_kind(self, kind: str) -> list[int]:
        """Value references of all variables of a kind."""
        return [i for i, variable in enumerate(self.variables) if variable.kind == kind]

    def depends_on(self, output: int) -> list[int]:
        """Value references of the inputs on which an output depends, rising."""
        named = self.variables[output].dependencies
        return [i for i in self.of_kind("input") if named is None or self.variables[i].name in named]


def free_name(name: str, taken: Sequence[str]) -> str:
    """`name`, with as many underscores as make it different from all others."""
    while name in taken:
        name += "_"
    return name
