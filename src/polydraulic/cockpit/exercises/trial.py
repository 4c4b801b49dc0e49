"""One attempt at an exercise: what the target is, when it is over, and how well it went; step by step, so that it does not depend on a clock."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from polydraulic.cockpit.exercises.catalogue import Exercise

READY = 3.0  # s until a target begins to move
DWELL = 0.5  # s within the tolerance, until a place counts as visited
LONGEST = 600.0  # s


class Observed(NamedTuple):
    """What a trial sees of a step.

    Attributes
    ----------
    tip : (3,) array, m
    effort : float
        Sum of squares of the levers, each 1 at full travel.
    power : float, W
        Of the pumps.
    stops : (n_function,) array of bool
        Which joints are at an end.
    """

    tip: np.ndarray
    effort: float
    power: float
    stops: np.ndarray


class Trial:
    """An attempt.

    Attributes
    ----------
    exercise : Exercise
    subject : str
        A code, nothing personal.
    target : (3,) array, m
    payload : float, kg
    over, done : bool
        Whether it has ended, and whether all was done.
    """

    def __init__(self, exercise: Exercise, subject: str, dt: float) -> None:
        self.exercise, self.subject = exercise, subject
        self.target, self.payload = exercise.path[0], 0.0
        self.over = self.done = False
        self._dt, self._steps, self._begun = dt, 0, exercise.kind == "visit"
        self._place, self._dwell, self._scored = 0, 0.0, 0
        self._sum, self._largest, self._n_error = 0.0, 0.0, 0
        self._effort, self._energy, self._stops, self._at_stop = 0.0, 0.0, 0, np.zeros(0, dtype=bool)

    def observe(self, seen: Observed) -> None:
        """Take one step into account."""
        if self.over:
            return
        self._steps += 1
        {"follow": self._follow, "line": self._line, "visit": self._visit}[self.exercise.kind](seen)
        if self._begun:
            self._scored += 1
            self._effort += seen.effort * self._dt
            self._energy += seen.power * self._dt
            if self._at_stop.size:
                self._stops += int(np.sum(seen.stops & ~self._at_stop))
            self._at_stop = seen.stops
        self.over = self.over or self._steps * self._dt >= LONGEST

    def score(self) -> dict[str, tuple[float, str]]:
        """What was reached, by name: value and unit, SI."""
        n = max(self._n_error, 1)
        return {
            "time": (self._scored * self._dt, "s"),
            "error_rms": (sqrt(self._sum / n), "m"),
            "error_max": (self._largest, "m"),
            "effort": (self._effort, "s"),
            "stops": (float(self._stops), "1"),
            "energy": (self._energy, "J"),
        }

    def _follow(self, seen: Observed) -> None:
        ready = round(READY / self._dt)
        place = self._steps - ready
        if place < 0:
            return
        path = self.exercise.path
        self._begun = True
        self.target = path[min(place, len(path) - 1)]
        self._erred(float(np.linalg.norm(seen.tip - self.target)))
        self.over = self.done = place >= len(path) - 1

    def _line(self, seen: Observed) -> None:
        start, end = self.exercise.path
        if not self._begun:
            self._begun = bool(np.linalg.norm(seen.tip - start) <= self.exercise.tolerance)
            self.target = start
            return
        along = (end - start) / np.linalg.norm(end - start)
        way = float((seen.tip - start) @ along)
        self.target = end
        self._erred(float(np.linalg.norm(seen.tip - start - way * along)))
        self.over = self.done = way >= float(np.linalg.norm(end - start))

    def _visit(self, seen: Observed) -> None:
        self.target = self.exercise.path[self._place]
        error = float(np.linalg.norm(seen.tip - self.target))
        self._dwell = self._dwell + self._dt if error <= self.exercise.tolerance else 0.0
        if self._dwell < DWELL:
            return
        self._erred(error)
        self.payload, self._dwell = self.exercise.payload[self._place], 0.0
        self._place += 1
        self.over = self.done = self._place == len(self.exercise.path)
        self.target = self.exercise.path[min(self._place, len(self.exercise.path) - 1)]

    def _erred(self, error: float) -> None:
        self._sum += error * error
        self._largest = max(self._largest, error)
        self._n_error += 1
