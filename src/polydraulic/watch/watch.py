"""`FaultWatch`: a machine's log looked at block by block, from memory that does not grow."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.watch.block import AlarmTests, BlockJudge, Readings
from polydraulic.watch.diagnosis import Suspect, named_suspects
from polydraulic.watch.drift import with_course
from polydraulic.watch.expected import Expected
from polydraulic.watch.flat import too_long
from polydraulic.watch.kernels.alarms import ALONE, BEGINS, NONE
from polydraulic.watch.kernels.evidence import KEPT
from polydraulic.watch.kernels.numbers import BLOCKS, CERTAINTY, FAMILIAR, FILLED, FIRST, KIND, UNTIL
from polydraulic.watch.kernels.opinions import ask_networks
from polydraulic.watch.kernels.rows import JUDGED, MOST_GAPS, NEVER_APART, NO_NUMBER, TAKEN
from polydraulic.watch.learning import FALSE_ALARMS
from polydraulic.watch.naming import FaultNetworks, Opinion
from polydraulic.watch.sequential import Since, threshold_for
from polydraulic.watch.watched import Watched, plan_of, tests_of

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
        limits = [too_long(expected.longest[column]) for column in of.columns]
        tests = AlarmTests(expected.together, expected.slow, float(np.median(expected.together)), threshold, limits)
        plan = plan_of(of, expected.noise)
        self.judge_parts = BlockJudge(plan, expected.scales, expected.offset, expected.jitter, tests)
        self.asked = None if networks is None else networks.asked(of.directions)
        self.alarms: list[Alarm] = []
        # of the present alarm, errors of sensors not yet told apart by their course
        self._suspects: tuple[Suspect, ...] = ()

    @property
    def blocks(self) -> int:
        """How many were judged."""
        return int(self.judge_parts.marks[BLOCKS])

    @property
    def shares(self) -> np.ndarray:
        """Evidence for each direction as a share of the threshold, (n_direction,)."""
        return np.asarray(self.judge_parts.sums.max(axis=1) / self.judge_parts.numbers.threshold)

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
        values = np.ascontiguousarray(row, dtype=np.float64)
        if values.shape != (len(self.of.columns),):
            raise InputError(
                f"row at {time:g} s: its shape is {values.shape}; it must have one value for each of {', '.join(self.of.columns)}"
            )
        became = self.judge_parts.row(float(time), values)
        if became == TAKEN:
            return None
        if became < JUDGED:
            raise InputError(self._refused(became, time, values))
        return self._alarm(became - JUDGED)

    def _refused(self, became: int, time: float, values: np.ndarray) -> str:
        """Why a row was not taken."""
        raster = self.of.shape.raster
        if became == NO_NUMBER:
            which = next((c for c, v in zip(self.of.columns, values, strict=True) if not np.isfinite(v)), "time")
            return f"row at {time:g} s: {which} is no finite number; leave the row out, a gap begins a new block"
        if became == NEVER_APART:
            return f"row at {time:g} s: none of the last {MOST_GAPS} rows came {raster:g} s after the one before it, the raster that was learnt"
        apart = (time - float(self.judge_parts.rows[0, 0])) / (self.of.shape.rows - 1)
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
        self.judge_parts.marks[FILLED] = 0
        for k, begin in enumerate(begins.tolist()):
            self.judge_parts.load(readings, k)
            self.judge_parts.rows[self.of.shape.before, 0] = begin
            now = self._alarm(self.judge_parts.block())
            if each is not None:
                each()
        return now

    def _alarm(self, means: int) -> Alarm | None:
        """The alarm that there is after a block."""
        if means == NONE:
            return None
        judge = self.judge_parts
        since, seen, until = judge.live[: UNTIL + 1].tolist()
        if means == BEGINS:
            self.alarms.append(Alarm(since, seen, until, ()))
            del self.alarms[: -self.MOST_ALARMS]
        directions = self.of.directions
        if judge.told:
            (pull, information, squares), first = judge.seen.copy(), int(judge.marks[FIRST])
            self.seen = Since(pull, information, squares, min(self.blocks - first, KEPT))
            self._suspects = tuple(
                named_suspects(directions, self.seen, judge.numbers.common, judge.chances, judge.listed)
            )
        if stuck := judge.stuck:
            suspects = tuple(_frozen_sensor(self.of.columns[k]) for k in stuck)
        else:
            suspects = with_course(self._suspects, directions, judge.course, judge.began_before)
        self.alarms[-1] = Alarm(since, seen, until, suspects, self._opinion())
        return self.alarms[-1]

    def _opinion(self) -> Opinion | None:
        """What networks, if there are some, take the fault for, after they have been asked about the block."""
        judge = self.judge_parts
        if self.networks is None or self.asked is None:
            return None
        ask_networks(judge.numbers, self.asked.numbers, judge.work, judge.live, judge.marks, *self.asked[1:])
        if judge.marks[KIND] == 0:
            return None
        kind = self.networks.kinds[judge.marks[KIND] - 1]
        return Opinion(kind, float(judge.live[CERTAINTY]), bool(judge.marks[FAMILIAR]))

    def findings(self) -> list[Outlook]:
        """Of each fault that is watched, whether it would have shown by now."""
        judge = self.judge_parts
        shares = np.minimum(judge.showing / judge.numbers.threshold, 1.0).tolist()
        found: dict[str, Outlook] = {}
        for d, share in zip(self.of.directions, shares, strict=True):  # the smallest size of each comes first
            found.setdefault(d.name, Outlook(d.name, d.smallest, share >= 1.0, share))
        stays = judge.worked / (ALONE * judge.numbers.limits)
        for column, share in zip(self.of.columns, stays.tolist(), strict=True):
            sensor = _frozen_sensor(column)
            found[sensor.name] = Outlook(sensor.name, sensor.title, share >= 1.0, min(share, 1.0))
        return list(found.values())


def _frozen_sensor(column: str) -> Suspect:
    return Suspect(f"{column}{FREEZE}", f"sensor of {column} stays at what it reads", 1.0, np.nan, np.nan, False)
