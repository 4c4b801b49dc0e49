"""Numbers of runs as the thesis prints them: differences from the exact run at a time, events, ranges; in the field's units."""

from typing import NamedTuple

import numpy as np

from polydraulic.parameters.scenario import load_scenario
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import Table
from polydraulic.thesis.excavator import LINKS
from polydraulic.thesis.printed_units import in_field_units
from polydraulic.thesis.three_links import ThreeLinkStudy


class Compared(NamedTuple):
    """A run next to the exact one."""

    exact: Table
    run: Table

    def at(self, column: str, time: float) -> float:
        """Size of a column's difference at a time in s."""
        return abs(float(self._difference(column)[self._row(time)]))

    def largest(self, column: str, start: float, end: float) -> float:
        """Largest size of a column's difference between two times in s."""
        return float(np.abs(self._difference(column)[self._row(start) : self._row(end) + 1]).max())

    def time_of_largest(self, column: str, start: float, end: float) -> float:
        """When it is largest, in s."""
        first = self._row(start)
        error = np.abs(self._difference(column)[first : self._row(end) + 1])
        return float(self.exact["time"][first + int(np.argmax(error))])

    def distance(self, time: float) -> float:
        """Distance of the end-effectors at a time, in m."""
        return float(effector_distance(self.exact, self.run)[self._row(time)])

    def largest_distance(self, end: float = np.inf) -> float:
        """Largest distance of the end-effectors up to a time, in m."""
        return float(effector_distance(self.exact, self.run)[: self._row(end) + 1].max())

    def time_of_largest_distance(self) -> float:
        """When they are farthest apart, in s."""
        return float(self.exact["time"][int(np.argmax(effector_distance(self.exact, self.run)))])

    def along(self, axis: str) -> np.ndarray:
        """Difference of the end-effectors along an axis, (n_time,) in m."""
        return np.asarray(self.run[f"effector.{axis}"] - self.exact[f"effector.{axis}"])

    def _difference(self, column: str) -> np.ndarray:
        return in_field_units(self.run, column)[0] - in_field_units(self.exact, column)[0]

    def _row(self, time: float) -> int:
        return min(int(np.searchsorted(self.exact["time"], time - 1e-9)), len(self.exact) - 1)


def compared(study: ThreeLinkStudy, scenario: str, kind: str = "polynomial", *, limited: bool = False) -> Compared:
    """A scenario's run with a kind of flow model next to the exact one on the same machine."""
    return Compared(study.run(scenario, "exact", limited), study.run(scenario, kind, limited))


def event(run: Table, link: str, what: str, place: int = 0) -> float:
    """Time in s of a link's event, the `place`-th of its kind."""
    events = run.info["events"]
    assert isinstance(events, list)
    return float([time for time, where, kind in events if (where, kind) == (link, what)][place])


def value(run: Table, column: str, time: float) -> float:
    """A column at a time in s."""
    row = int(np.searchsorted(run["time"], time - 1e-9))
    return float(in_field_units(run, column)[0][row])


def spool_range(run: Table, link: str, opens: float, settled: float) -> list[float]:
    """Range of a spool's travel in inches while its valve is open (travel above `opens` in m), after a time in s."""
    column = f"{link}.spool"
    open_ = (np.abs(run[column]) > opens) & (run["time"] >= settled)
    travel = np.abs(in_field_units(run, column)[0][open_])
    return [float(travel.min()), float(travel.max())]


def phases(scenario: str, link: str) -> list[list[float]]:
    """Intervals in s between the times at which a link's voltage comes back to zero."""
    task = load_scenario(scenario)
    t = np.arange(0.0, task.duration + 1e-9, 5e-3)
    still = np.abs(task.voltages(t)[:, LINKS.index(link)]) < 1e-9
    begins = [0.0, *(float(x) for x in t[1:][still[1:] & ~still[:-1]])]
    return [[begin, end] for begin, end in zip(begins, [*begins[1:], task.duration], strict=True) if end > begin]
