"""What a machine and many machines that are moved step by step have in common: names, outputs by name, levers by name, an end."""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.flow.dispatch import FlowModel
from polydraulic.simulation.stepping.levers import lever_voltages, named_voltages
from polydraulic.simulation.stepping.setup import Setup

PIECE = 20_000  # steps of a call of compiled code, which cannot be interrupted


class Stepped:
    """Machines that are moved step by step, until they are closed.

    Parameters
    ----------
    setup : Setup
    flow : str or flow model
        As it was given.
    shape : tuple of int
        Of the levers.
    """

    outputs: Mapping[str, np.ndarray]
    units: Mapping[str, str]

    def __init__(self, setup: Setup, flow: str | FlowModel, shape: tuple[int, ...]) -> None:
        self._setup, self._flow, self._shape, self._closed = setup, flow, shape, False
        self.machine, self.names, self.dt = setup.machine, setup.machine.names, setup.dt

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.outputs:
            raise InputError(f"no output {briefly(name)}; there are {list(self.outputs)}")
        return self.outputs[name]

    def close(self) -> None:
        """End: further steps are refused, outputs can still be read."""
        self._closed = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _check_open(self) -> None:
        if self._closed:
            raise InputError("the simulator is closed; build another one")

    def _voltages(self, inputs: Any) -> np.ndarray:
        """Voltages of the levers, in their order; those of an array that is as it should be are not copied."""
        if inputs.__class__ is np.ndarray and inputs.shape == self._shape and inputs.dtype == np.float64:
            return inputs
        if isinstance(inputs, Mapping):
            inputs = self._in_order(named_voltages(inputs, self.names, self._setup.locked))
        return lever_voltages(inputs, self.names, self._shape)

    def _in_order(self, values: list[Any]) -> Any:
        """Voltages by function as `lever_voltages` takes them."""
        return values
