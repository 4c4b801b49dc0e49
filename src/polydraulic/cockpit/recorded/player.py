"""A recorded drive, driven once more: the same stamps at the same steps give the same bits."""

from bisect import bisect_left
from typing import Any

import numpy as np

from polydraulic.cockpit.recorded.drives import Drive
from polydraulic.cockpit.recorded.tape import start_of, state_hash
from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.stepping.saved import SavedState
from polydraulic.simulation.stepping.simulator import Simulator

_KEPT = 2000  # steps between states that are kept to come back to


class Player:
    """A drive and the simulator that drives it.

    Parameters
    ----------
    drive : Drive
    simulator : Simulator
        Built as the one that was recorded; it is put to the drive's beginning.
    healthy : LayoutMachine
        Its machine as it was built with.

    Attributes
    ----------
    step : int
        Of the drive.
    levers : (n_function,) array, V
    values : dict from path to value in SI
        Numbers that are not those of the healthy machine.
    payload : float, kg

    Raises
    ------
    InputError
        A drive of another machine, flow model or version.
    """

    def __init__(self, drive: Drive, simulator: Simulator, healthy: LayoutMachine) -> None:
        self.drive, self._simulator = drive, simulator
        self._load: dict[str, float] | None
        start = start_of(drive.head, simulator, healthy)
        self._kept: list[tuple[SavedState, np.ndarray, dict[str, float], float]] = []
        self._first = (start, np.zeros(len(simulator.names)), dict(drive.head["values"]), start.mass)
        self._steps = [stamp["step"] for stamp in drive.stamps]
        self.step, self.levers, self.values, self.payload = 0, *self._first[1:]
        self._next, self._load = 0, None
        self._restore(0, self._first)

    @property
    def ended(self) -> bool:
        """Whether there is no more."""
        return self.step >= self.drive.end

    def advance(self, n: int) -> int:
        """Make up to `n` steps of the drive; how many there were.

        Raises
        ------
        InputError
            If the state is not the one that was recorded.
        SimulationError
        """
        first, last = self.step, min(self.step + n, self.drive.end)
        self._take()
        while self.step < last:
            due = self._steps[self._next] if self._next < len(self._steps) else last
            keep = (len(self._kept) + 1) * _KEPT
            until = min(last, due, keep if keep > self.step else last)
            self._simulator.step(self.levers, until - self.step, self._load)
            self.step, self._load = until, None
            if self.step == keep:
                self._kept.append((self._simulator.save(), self.levers.copy(), dict(self.values), self.payload))
            self._take()
        return self.step - first

    def go_back(self, step: int) -> None:
        """Go to the last state that was kept up to a step."""
        place = min(step // _KEPT, len(self._kept))
        self._restore(place * _KEPT, self._kept[place - 1] if place else self._first)

    def _restore(self, step: int, kept: tuple[SavedState, np.ndarray, dict[str, float], float]) -> None:
        saved, levers, values, self.payload = kept
        self._simulator.restore(saved)
        self.step, self.levers, self.values = step, levers.copy(), dict(values)
        self._next, self._load = bisect_left(self._steps, step), None

    def _take(self) -> None:
        """Let stamps of this step have their effect."""
        while self._next < len(self._steps) and self._steps[self._next] == self.step:
            self._apply(self.drive.stamps[self._next])
            self._next += 1

    def _apply(self, stamp: dict[str, Any]) -> None:
        sim = self._simulator
        if "hash" in stamp and stamp["hash"] != state_hash(sim):
            raise InputError(
                f"the drive {self.drive.name} cannot be replayed: at {self.step * sim.dt:g} s the state is not the one that was recorded"
            )
        if stamp.get("reset"):
            sim.reset()
            self.payload = 0.0
        if "change" in stamp:
            sim.change(stamp["change"])
            self.values |= stamp["change"]
        if "payload" in stamp:
            self.payload = float(stamp["payload"])
            self._load = {"payload": self.payload}
        if "levers" in stamp:
            self.levers = np.array(stamp["levers"], dtype=np.float64)
