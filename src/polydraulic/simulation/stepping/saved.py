"""All that changes of machines that are moved step by step, to come back to; it can be pickled."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.loads import Loads


@dataclass(frozen=True)
class SavedState:
    """All of a `Simulator` that changes, for `Simulator.restore`."""

    of: str = field(repr=False)
    live: np.ndarray = field(repr=False)
    counts: np.ndarray
    delay: np.ndarray = field(repr=False)
    loads: Loads
    mass: float  # kg at the tip
    machine: LayoutMachine = field(repr=False)


@dataclass(frozen=True)
class SavedBatch:
    """All of a `BatchSimulator` that changes, for `BatchSimulator.restore`."""

    of: tuple[Any, ...] = field(repr=False)
    arrays: dict[str, np.ndarray | None] = field(repr=False)
    clock: int
    machines: tuple[LayoutMachine, ...] = field(repr=False)
    masses: np.ndarray = field(repr=False)
    first_masses: np.ndarray = field(repr=False)
