"""A plan: which steps make residuals of a block's rows, as two arrays; what several steps share is made once."""

from collections.abc import Callable, Hashable, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.watch.kernels.text import kind_of_step


class Plan:
    """Steps, numbers that they read, and the room that they fill; empty at first.

    Attributes
    ----------
    size : int
        Floats of room so far.
    """

    def __init__(self) -> None:
        self.size = 0
        self._steps: list[list[int]] = []
        self._floats: list[float] = []
        self._numbers: dict[tuple[float, ...], int] = {}
        self._known: dict[Hashable, int] = {}

    def room(self, n: int) -> int:
        """Where so many floats have room."""
        self.size += n
        return self.size - n

    def numbers(self, values: Sequence[float]) -> int:
        """Where these numbers stand."""
        key = tuple(map(float, values))
        if key not in self._numbers:
            self._numbers[key] = len(self._floats)
            self._floats.extend(key)
        return self._numbers[key]

    def step(self, name: str, *places: int) -> None:
        """Add a step."""
        self._steps.append([kind_of_step(name), *map(int, places)])

    def once(self, key: Hashable, make: Callable[[], int]) -> int:
        """The place that is made for a key, when it is first asked for."""
        if key not in self._known:
            self._known[key] = make()
        return self._known[key]

    def filled(self, n: int, name: str, *places: int) -> int:
        """Room for n floats that a step fills whose places are output, n and these."""
        out = self.room(n)
        self.step(name, out, n, *places)
        return out

    def arrays(self, *tables: Sequence[int]) -> "PlanArrays":
        """The plan as arrays, with tables behind the steps."""
        begins, at = [], 1 + len(self._steps)
        for step in self._steps:
            begins.append(at)
            at += len(step)
        ints = [len(self._steps), *begins, *(place for step in self._steps for place in step)]
        places = []
        for table in tables:
            places.append(len(ints))
            ints.extend(map(int, table))
        return PlanArrays(np.array(ints, dtype=np.int64), np.array(self._floats), self.size, tuple(places))


class PlanArrays(NamedTuple):
    """A plan as kernels read it.

    Attributes
    ----------
    ints : (n_int,) array of int
        How many steps, where each begins, their kinds and places, and tables behind them.
    floats : (n_float,) array
    size : int
        Floats of room that the steps fill.
    tables : tuple of int
        Where in `ints` each table begins.
    """

    ints: np.ndarray
    floats: np.ndarray
    size: int
    tables: tuple[int, ...]
