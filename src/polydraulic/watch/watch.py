"""`FaultWatch`: a machine's log looked at block by block, from memory that does not grow."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.watch.block import BlockJudge, Readings
from polydraulic.watch.diagnosis import Suspect, suspects_of
from polydraulic.watch.drift import with_course
from polydraulic.watch.expected import Expected
from polydraulic.watch.flat import too_long
from polydraulic.watch.kernels.evidence import KEPT, LEAST_BLOCKS
from polydraulic.watch.kernels.rows import FILLED, FULL, MOST_GAPS, NEVER_APART, NO_NUMBER, TAKEN, keep_rows, take_row
from polydraulic.watch.kernels.stays import FLAT, MOVES, RESTS
from polydraulic.watch.learning import FALSE_ALARMS
from polydraulic.watch.naming import FaultNetworks, Opinion
from polydraulic.watch.sequential import EvidenceSums, Limits, Since, threshold_for
from polydraulic.watch.watched import Watched, plan_of, tests_of, ways_of

QUIET = 30  # blocks without an alarm after which it is over
DIAGNOSED = 60  # blocks since the beginning that a diagnosis is made of
ALONE = 3  # times as long a sensor stays until that alone is an alarm
FREEZE = ".freeze"


class Alarm(NamedTuple):
    """Something that a healthy machine does not show.

    Attributes
    ----------
    since, seen, until : float, s
        When it seems to have begun; when the evidence was enough; the last time at which it was.
    suspects : tuple of Suspect
        The most likely first; of a sensor that stays at one value that alone.
    opinion : Opinion or None
        What networks take it for, where there are some and no sensor stays.
    """

    since: float
    seen: float
    until: float
    suspects: tuple[Suspect, ...]
    opinion: Opinion | None = None


class Outlook(NamedTuple):
    """What is known of a fault, whether it was found or not.

    Attributes
    ----------
    name, title : str
        Title with the smallest size that counts.
    could_show : bool
        Whether the smallest size that counts would have been seen by now.
    share : float
        Of the evidence that this takes.
    """

    name: str
    title: str
    could_show: bool
    share: float


class Frozen(NamedTuple):
    """A sensor that stays at one value: for how many blocks, and whether for so long that this alone is an alarm."""

    column: str
    blocks: int
    alone: bool


class FaultWatch:
    """A machine that is watched, row by row or block by block.

    Parameters
    ----------
    of : Watched
    expected : Expected
        From `learn_expected`.
    rate : float
        False alarms per hour of all tests together.
    networks : FaultNetworks, optional
        That name the kind of a fault as well.

    Attributes
    ----------
    alarms : list of Alarm
        So far; the last one may go on. Kept are the last 1000.
    blocks : int
        That were judged.
    seen : Since or None
        What the last alarm was named by.
    """

    MOST_ALARMS = 1000

    def __init__(
        self, of: Watched, expected: Expected, rate: float = FALSE_ALARMS, networks: FaultNetworks | None = None
    ) -> None:
        self.of, self.expected, self.rate, self.networks = of, expected, rate, networks
        self.seen: Since | None = None
        threshold = threshold_for(rate, tests_of(of.directions), of.shape.seconds)
        self.evidence = EvidenceSums(Limits(threshold, expected.together, ways_of(of.directions)))
        self._common = float(np.median(expected.together))
        self.alarms: list[Alarm] = []
        self.blocks = 0
        self._opened = -1  # block at which the present alarm seems to have begun
        self._last = 0  # block at which a test was last beyond its threshold
        self._times = np.zeros(KEPT + 1)  # of the beginnings of blocks
        self._judge = BlockJudge(plan_of(of, expected.noise), expected.scales, expected.offset, expected.jitter)
        self._counts = np.zeros(2, dtype=np.int64)
        self._limits = np.array([too_long(expected.longest[column]) for column in of.columns])
        self._flat = np.zeros(len(of.columns), dtype=np.int64)
        self._worked = np.zeros(len(of.columns), dtype=np.int64)  # blocks in which the function of each sensor worked
        # of the present alarm, errors of sensors not yet told apart by their course
        self._suspects: tuple[Suspect, ...] = ()

    def update(self, time: float, row: np.ndarray) -> Alarm | None:
        """Take a row of the log; the present alarm whenever a block is full and there is one.

        Parameters
        ----------
        time : float, s
            A gap begins a new block.
        row : (n_column,) array
            Values in SI, in the order of the columns.

        Raises
        ------
        InputError
            Values that are not one finite number per column; rows that do not come at the raster that was learnt.
        """
        shape, values = self.of.shape, np.ascontiguousarray(row, dtype=np.float64)
        if values.shape != (len(self.of.columns),):
            raise InputError(
                f"row at {time:g} s: its shape is {values.shape}; it must have one value for each of {', '.join(self.of.columns)}"
            )
        rows = self._judge.rows
        became = take_row(float(time), values, rows, self._counts, shape.raster)
        if became == TAKEN:
            return None
        if became != FULL:
            raise InputError(self._refused(became, time, values))
        self._judge.judge()
        begin = float(rows[shape.before * (1 + len(values))])
        keep_rows(rows, self._counts, 1 + len(values), shape.inside)
        return self._block(begin)

    def _refused(self, became: int, time: float, values: np.ndarray) -> str:
        """Why a row was not taken."""
        raster = self.of.shape.raster
        if became == NO_NUMBER:
            which = next((c for c, v in zip(self.of.columns, values, strict=True) if not np.isfinite(v)), "time")
            return f"row at {time:g} s: {which} is no finite number; leave the row out, a gap begins a new block"
        if became == NEVER_APART:
            return f"row at {time:g} s: none of the last {MOST_GAPS} rows came {raster:g} s after the one before it, the raster that was learnt"
        apart = (time - float(self._judge.rows[0])) / (self.of.shape.rows - 1)
        return f"rows until {time:g} s are {apart:.4g} s apart, those that were learnt from {raster:g} s: give rows at that raster"

    def judge(self, readings: Readings, begins: np.ndarray, each: Callable[[], None] | None = None) -> Alarm | None:
        """Take blocks that follow each other; the alarm that is there after them. A row that comes next begins a block of its own.

        Parameters
        ----------
        readings : Readings
        begins : (n_block,) array, s
            Time of the first row that is judged of each.
        each : function, optional
            Called after each block.
        """
        now = None
        self._counts[FILLED] = 0
        for k, begin in enumerate(begins.tolist()):
            self._judge.load(readings, k)
            self._judge.judge()
            now = self._block(begin)
            if each is not None:
                each()
        return now

    def _block(self, begin: float) -> Alarm | None:
        evidence, frozen = self.evidence, self._frozen()
        self._times[self.blocks % len(self._times)] = begin
        evidence.add(self._judge.white_pull, self._judge.white_information)
        self.blocks += 1
        beyond = evidence.alarms
        seconds = self.of.shape.seconds
        if self._opened >= 0 and self.blocks - self._last > QUIET:
            self._opened = -1
        if not (beyond.any() or any(sensor.alone for sensor in frozen)):
            return None
        if self._opened >= 0 and (later := self._behind_unusual_work(beyond)).any():
            self._opened, beyond = -1, later
        if self._opened < 0:
            where = np.unravel_index(int(np.argmax(np.where(beyond, evidence.sums, -1.0))), beyond.shape)
            stays = max((sensor.blocks for sensor in frozen if sensor.alone), default=1)
            began = int(evidence.began[where]) if beyond.any() else self.blocks - stays
            self._opened = max(began, self.blocks - len(self._times) + 1, 0)
            since = float(self._times[self._opened % len(self._times)])
            self.alarms.append(Alarm(since, begin + seconds, begin + seconds, ()))
            del self.alarms[: -self.MOST_ALARMS]
        self._last = self.blocks
        alarm = self.alarms[-1]
        suspects, opinion = alarm.suspects, alarm.opinion
        if not (suspects and suspects[0].name.endswith(FREEZE)):
            if self.blocks - self._opened <= DIAGNOSED or not suspects:
                self.seen = evidence.since(self._opened)
                self._suspects = tuple(suspects_of(self.of.directions, self.seen, self._common))
                if self.networks is not None:
                    opinion = self.networks.opinion(self.of.directions, self.seen, self._common)
            suspects = with_course(self._suspects, self.of.directions, evidence, self._opened)
            owners = {s.name.partition(".")[0] for s in suspects}
            still = [sensor.column for sensor in frozen if sensor.alone or owners & self._owners(sensor.column)]
            if still:
                suspects, opinion = tuple(map(_frozen_sensor, still)), None
        self.alarms[-1] = alarm._replace(until=begin + seconds, suspects=suspects, opinion=opinion)
        return self.alarms[-1]

    def _behind_unusual_work(self, beyond: np.ndarray) -> np.ndarray:
        """Of an alarm that is no fault: the tests that began when it was diagnosed, and that something else explains."""
        suspects, began = self.alarms[-1].suspects, self.evidence.began
        later = beyond & (began > self._opened + DIAGNOSED)
        if not (later.any() and suspects and suspects[0].harmless):
            return np.zeros_like(beyond)
        first = int(began[later].min())
        found = suspects_of(self.of.directions, self.evidence.since(first), self._common)
        known = {suspect.name for suspect in suspects}
        other = self.blocks - first >= LEAST_BLOCKS and bool(found) and found[0].name not in known
        return later if other else np.zeros_like(beyond)

    def _frozen(self) -> list[Frozen]:
        """Sensors that have not moved for longer than they ever did."""
        states = self._judge.states[: len(self._flat)]
        self._worked += states != RESTS
        self._flat = np.where(states == FLAT, self._flat + 1, np.where(states == MOVES, 0, self._flat))
        return [
            Frozen(self.of.columns[k], int(self._flat[k]), bool(self._flat[k] >= ALONE * self._limits[k]))
            for k in np.flatnonzero(self._flat >= self._limits).tolist()
        ]

    def _owners(self, column: str) -> set[str]:
        """Names that faults begin with which a sensor that stays looks like: its function, and the circuit of that."""
        function = column.partition(".")[0]
        return {function, *(c.name for c in self.of.machine.circuits if function in c.functions)}

    def findings(self) -> list[Outlook]:
        """Of each fault that is watched, whether it would have shown by now."""
        shares = np.minimum(self.evidence.showing / self.evidence.limits.threshold, 1.0).tolist()
        found: dict[str, Outlook] = {}
        for d, share in zip(self.of.directions, shares, strict=True):  # the smallest size of each comes first
            found.setdefault(d.name, Outlook(d.name, d.smallest, share >= 1.0, share))
        for column, worked, limit in zip(self.of.columns, self._worked.tolist(), self._limits.tolist(), strict=True):
            sensor, share = _frozen_sensor(column), worked / (ALONE * limit)
            found[sensor.name] = Outlook(sensor.name, sensor.title, share >= 1.0, min(share, 1.0))
        return list(found.values())


def _frozen_sensor(column: str) -> Suspect:
    return Suspect(f"{column}{FREEZE}", f"sensor of {column} stays at what it reads", 1.0, np.nan, np.nan, False)
