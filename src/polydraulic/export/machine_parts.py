"""What an exported machine consists of, whatever its layout."""

from collections.abc import Callable
from typing import Any, NamedTuple


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
