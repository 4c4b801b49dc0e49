"""Runs of equal values: a sensor that is stuck, beyond its range, or too coarse shows by them."""

from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np

_LONG, _HELD = 10, 5  # samples
_FROZEN = 50  # samples
_NOISY = 0.15  # share of samples at which a signal with noise turns round, at least
_JUMP = 0.2  # of the range, with which a lost signal falls to 0
_FEW = 20  # values
_KEPT = 200


class RunOfValues(NamedTuple):
    """A run of `length` samples of one value, in these rows; and how far the value jumped when it began."""

    length: int
    value: float
    first: int
    last: int
    jump: float


class ValueRuns:
    """Runs of equal values of a growing signal."""

    def __init__(self) -> None:
        self.count = self.n_run = self.n_turn = 0
        self.longest: list[RunOfValues] = []  # the longest `_KEPT` of all that are long
        self.n_held = 0  # samples in runs of at least `_HELD`
        self.low = Extreme(-1.0)
        self.high = Extreme(1.0)
        self._open: RunOfValues | None = None
        self._different: set[float] = set()

    def add(self, value: np.ndarray, rows: np.ndarray) -> None:
        """Add samples and the rows that they stand in."""
        if value.size == 0:
            return
        starts = np.concatenate([[0], np.flatnonzero(value[1:] != value[:-1]) + 1, [len(value)]])
        length, of = starts[1:] - starts[:-1], value[starts[:-1]]
        steps = of[1:] - of[:-1]
        self.count += len(value)
        self.n_turn += int((steps[1:] * steps[:-1] < 0.0).sum())
        if len(self._different) <= _FEW:
            self._different.update(np.unique(of)[: _FEW + 1].tolist())
        first, before = int(rows[0]), of[0] if self._open is None else self._open.value
        jump = float(abs(of[0] - before))
        if self._open is not None and before == of[0]:
            length[0] += self._open.length
            first, jump = self._open.first, self._open.jump
        else:
            self._close_open()

        def run(i: int) -> RunOfValues:
            begin, end = int(starts[i]), int(starts[i + 1]) - 1
            since = (first, jump) if i == 0 else (int(rows[begin]), float(abs(steps[i - 1])))
            return RunOfValues(int(length[i]), float(of[i]), since[0], int(rows[end]), since[1])

        self._close(length[:-1], of[:-1], run)
        self._open = run(len(of) - 1)

    def _close_open(self) -> None:
        last = self._open
        if last is not None:
            self._close(np.asarray([last.length]), np.asarray([last.value]), lambda _: last)
        self._open = None

    def _close(self, length: np.ndarray, of: np.ndarray, run: Callable[[int], RunOfValues]) -> None:
        """Count runs by their lengths and values; `run` gives one of them."""
        if length.size == 0:
            return
        held = np.flatnonzero(length >= _HELD)
        self.n_run += len(length)
        self.n_held += int(length[held].sum())
        self.low.add(float(of.min()), held, length, of, run)
        self.high.add(float(of.max()), held, length, of, run)
        long = held[length[held] >= _LONG]
        if len(long) > _KEPT:
            long = long[length[long] >= np.partition(length[long], -_KEPT)[-_KEPT]]
        if len(long):
            self.longest = sorted([*self.longest, *map(run, long.tolist())], reverse=True)[:_KEPT]

    @property
    def many(self) -> bool:
        """Whether there are many different values, so that it is no switch and no coarse signal."""
        return len(self._different) > _FEW

    def findings(self) -> list[tuple[str, list[RunOfValues], str]]:
        """Kinds of finding with their runs and what else there is to say; call it once, at the end."""
        self._close_open()
        found: list[tuple[str, list[RunOfValues], str]] = []
        held = [run for run in self.longest if run.length >= _FROZEN]
        noisy = self.n_turn > _NOISY * (self.count - sum(run.length for run in held))
        clipped: set[float] = set()
        for name, end in (("largest", self.high), ("smallest", self.low)):
            elsewhere = self.n_held - end.n_held
            if noisy and end.value != 0.0 and end.n_held >= 20 and end.n_run >= 2 and elsewhere < 0.02 * self.count:
                found.append(("clipped", end.runs, f"{name} value {end.value:.6g}"))
                clipped.add(end.value)
        # a value of 0 is rest, unless the signal always fell to it
        rests = any(run.value == 0.0 and run.jump <= _JUMP * (self.high.value - self.low.value) for run in self.longest)
        held = [run for run in held if run.value not in clipped and not (run.value == 0.0 and rests)]
        frozen = held if noisy else self._held_too_long(held[:3])
        frozen = frozen if len(frozen) <= 3 else []
        if frozen:
            found.append(("frozen", frozen, f"at {frozen[0].value:.6g}"))
        step = min(np.diff(sorted(self._different)), default=0.0)
        held_each = self.count > 2.0 * self.n_run  # noise larger than the digits would not let it
        if held_each and 1 < len(self._different) <= _FEW and step * _FEW > self.high.value - self.low.value:
            found.append(("coarse", [], f"{len(self._different)} different values"))
        return found

    def _held_too_long(self, held: list[RunOfValues]) -> list[RunOfValues]:
        """Of a signal without noise: held far longer than it ever is elsewhere, and not at rest or at an end."""
        others = np.median([run.length for run in self.longest]) if len(self.longest) > 10 else inf
        return [r for r in held if r.length > 20 * others and r.value not in (0.0, self.low.value, self.high.value)]


class Extreme:
    """Runs at the largest (side 1) or the smallest value (side -1)."""

    def __init__(self, side: float) -> None:
        self.side, self.value = side, -side * inf
        self.n_held = self.n_run = 0
        self.runs: list[RunOfValues] = []

    def add(
        self, best: float, held: np.ndarray, length: np.ndarray, of: np.ndarray, run: Callable[[int], RunOfValues]
    ) -> None:
        """Add runs, of which `best` is the largest (smallest) value; those at `held` are long enough to count."""
        if self.side * best > self.side * self.value:
            self.value, self.n_held, self.n_run, self.runs = best, 0, 0, []
        at = held[of[held] == self.value]
        self.n_held += int(length[at].sum())
        self.n_run += len(at)
        self.runs += map(run, at[: max(0, 20 - len(self.runs))].tolist())
