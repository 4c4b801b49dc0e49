"""What an exported machine consists of, whatever its layout."""

from collections.abc import Callable
from typing import Any, NamedTuple

from polydraulic.errors import InputError


class MachineParts(NamedTuple):
    """A machine as the exporters want it.

    Attributes
    ----------
    flow : str
        Name of its flow model.
    functions : tuple of str
        That take a voltage.
    inputs : tuple of str
        Names of the inputs: a voltage per function, then a force if there is one.
    outputs : tuple of (name, unit)
        Of a recorded row, and the tip.
    numbers : named tuple, called Prepared
        All numbers of a step, and the state at the start.
    start : kernel (numbers, memory, row) -> status
    advance : kernel (numbers, memory, row, inputs) -> status
    n_memory : int
        Numbers that the flow model keeps.
    delays : tuple of int
        Steps of the pilots' dead times, rounded up.
    """

    flow: str
    functions: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[tuple[str, str], ...]
    numbers: Any
    start: Callable[..., int]
    advance: Callable[..., int]
    n_memory: int
    delays: tuple[int, ...]

    @property
    def size(self) -> int:
        """Numbers of 8 bytes in the struct of the machine."""
        return len(self.outputs) + self.n_memory + len(self.functions) * max(1, *self.delays) + 2


def check_size(flow: str, numbers: int, most: int) -> None:
    """Refuse a flow model whose tables do not go into a C file; `flow` is its name, `numbers` those of its tables.

    Raises
    ------
    InputError
        Naming the flow models to take instead where none of any size would do.
    """
    if flow == "lookup":
        raise InputError(
            f"flow 'lookup' is not exported at any size: its search for a cell has no bound, and its tables hold {numbers} numbers "
            f"(a C file takes up to {most}); export flow 'exact', or networks"
        )
    if numbers > most:
        raise InputError(
            f"flow {flow!r} holds {numbers} numbers; a C file takes up to {most}: learn networks with fewer regions, or raise most_numbers"
        )
