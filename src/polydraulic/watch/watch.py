"""`FaultWatch`: a machine's log looked at block by block, from memory that does not grow."""

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.watch.blocks import BlockShape, block_shape
from polydraulic.watch.channels import WatchChannel, channels_of
from polydraulic.watch.diagnosis import Suspect, suspects_of
from polydraulic.watch.directions import Direction, Scores, directions_of, scores_of
from polydraulic.watch.expected import Expected, Whitened, joined_scores, learn_jitter, togetherness, whitened
from polydraulic.watch.flat import FLAT, MOVES, flat_blocks, longest_flat, too_long
from polydraulic.watch.noise import channel_scales, first_variances, whole_variances
from polydraulic.watch.residuals import Readings, Residuals, case_of
from polydraulic.watch.sequential import KEPT, LEAST_BLOCKS, EvidenceSums, Limits, highest, threshold_for

FALSE_ALARMS = 0.1  # per hour
QUIET = 30  # blocks without an alarm after which it is over
DIAGNOSED = 60  # blocks since the beginning that a diagnosis is made of
ALONE = 3  # times as long a sensor stays until that alone is an alarm
FREEZE = ".freeze"
_CHUNK = 64  # blocks whose residuals are found at once
_LEAST_BLOCKS = 60
_ROOM = 0.5  # of the threshold that healthy blocks may come to
_JITTER = 0.05  # of the raster, by which rows of a block may be nearer or farther apart in the mean
_MOST_GAPS = 100  # in succession, after which rows do not come at the raster
_SLOWEST = 0.1  # s between rows: filters of motion want some on both sides of a block


class Alarm(NamedTuple):
    """Something that a healthy machine does not show.

    Attributes
    ----------
    since, seen, until : float, s
        When it seems to have begun; when the evidence was enough; the last time at which it was.
    suspects : tuple of Suspect
        The most likely first; of a sensor that stays at one value that alone.
    """

    since: float
    seen: float
    until: float
    suspects: tuple[Suspect, ...]


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


class Watched(NamedTuple):
    """A machine, and what a log of it lets be watched.

    Attributes
    ----------
    machine : LayoutMachine
    columns : tuple of str
        That are read, in their order.
    shape : BlockShape
    channels : tuple of WatchChannel
    directions : tuple of Direction
    """

    machine: LayoutMachine
    columns: tuple[str, ...]
    shape: BlockShape
    channels: tuple[WatchChannel, ...]
    directions: tuple[Direction, ...]


def watched(machine: LayoutMachine, columns: Sequence[str], raster: float) -> Watched:
    """What can be watched of a machine with these columns of a log.

    Raises
    ------
    InputError
        If that is nothing, or rows come too seldom.
    """
    if raster > _SLOWEST * (1.0 + _JITTER):
        raise InputError(
            f"rows come every {raster:g} s; a machine is watched by rows every {_SLOWEST:g} s or more often"
        )
    known = frozenset(columns)
    channels = channels_of(machine, known)
    if not channels:
        raise InputError(
            f"nothing of the machine can be watched by {', '.join(columns) or 'no column'}: of a function it takes voltage and spool, or spool (or "
            "voltage) with p_a, p_b and flows or position"
        )
    return Watched(machine, tuple(columns), block_shape(raster), channels, directions_of(machine, known))


def learn_expected(of: Watched, readings: Readings, noise: Mapping[str, float], rate: float = FALSE_ALARMS) -> Expected:
    """What is to be expected of the machine while it is healthy.

    Parameters
    ----------
    of : Watched
    readings : Readings
        Of healthy blocks, in the order of time.
    noise : mapping from column to float
        Standard deviation of each sensor's white noise, SI.
    rate : float
        False alarms per hour of all tests together.

    Raises
    ------
    InputError
        Too few blocks.
    """
    n_block = len(readings[of.columns[0]])
    if n_block < _LEAST_BLOCKS:
        raise InputError(
            f"healthy work has {n_block} blocks of {of.shape.seconds:g} s without a gap, and what is to be expected takes {_LEAST_BLOCKS}: "
            "give more healthy work, five minutes or more are good"
        )
    healthy = case_of(of.machine)
    whole = Residuals(readings, of.shape, of.channels)
    scales = channel_scales(whole, healthy, first_variances(whole, healthy, noise))
    scores = joined_scores([block_scores(of, part, noise, scales) for part in chunks(readings)])
    offset, jitter = learn_jitter(scores)
    white = whitened(scores, offset, jitter)
    together = togetherness(white)
    ways, threshold = ways_of(of.directions), threshold_for(rate, tests_of(of.directions), of.shape.seconds)
    for _ in range(30):  # until healthy blocks stay well below the threshold
        most = highest(white, Limits(threshold, together, ways))
        if np.all(most <= _ROOM * threshold):
            break
        together = np.where(most > _ROOM * threshold, 1.3 * together, together)
    flat = longest_flat(flat_blocks(of.machine, readings, of.shape, dict(noise)))
    return Expected(dict(noise), tuple(scales), offset, jitter, together, flat, n_block)


def ways_of(directions: Sequence[Direction]) -> np.ndarray:
    """Which ways each goes, (n_direction, 2) of bool."""
    return np.array([[True, d.both] for d in directions])


def tests_of(directions: Sequence[Direction]) -> int:
    """How many tests run at once."""
    return int(ways_of(directions).sum())


def chunks(readings: Readings) -> list[Readings]:
    """Blocks, so many at a time."""
    n_block = len(next(iter(readings.values())))
    return [{c: v[k : k + _CHUNK] for c, v in readings.items()} for k in range(0, n_block, _CHUNK)]


def block_scores(
    of: Watched, readings: Readings, noise: Mapping[str, float], scales: Sequence[tuple[float, float]]
) -> Scores:
    """Scores of some blocks."""
    residuals, healthy = Residuals(readings, of.shape, of.channels), case_of(of.machine)
    return scores_of(residuals, healthy, of.directions, whole_variances(residuals, healthy, noise, scales))


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

    Attributes
    ----------
    alarms : list of Alarm
        So far; the last one may go on. Kept are the last 1000.
    blocks : int
        That were judged.
    """

    MOST_ALARMS = 1000

    def __init__(self, of: Watched, expected: Expected, rate: float = FALSE_ALARMS) -> None:
        self.of, self.expected, self.rate = of, expected, rate
        threshold = threshold_for(rate, tests_of(of.directions), of.shape.seconds)
        self.evidence = EvidenceSums(Limits(threshold, expected.together, ways_of(of.directions)))
        self._common = float(np.median(expected.together))
        self.alarms: list[Alarm] = []
        self.blocks = 0
        self._opened = -1  # block at which the present alarm seems to have begun
        self._last = 0  # block at which a test was last beyond its threshold
        self._times = np.zeros(KEPT + 1)  # of the beginnings of blocks
        self._rows = np.empty((of.shape.rows, 1 + len(of.columns)))
        self._filled = self._gaps = 0
        self._flat = np.zeros(len(of.columns), dtype=np.int64)

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
        shape, values = self.of.shape, np.asarray(row, dtype=np.float64)
        self._check_row(time, values)
        if self._filled and not 0.0 < time - self._rows[self._filled - 1, 0] < 1.5 * shape.raster:
            self._filled, self._gaps = 0, self._gaps + 1
        elif self._filled:
            self._gaps = 0
        self._rows[self._filled, 0], self._rows[self._filled, 1:] = time, values
        self._filled += 1
        if self._gaps > _MOST_GAPS:
            raise InputError(
                f"row at {time:g} s: none of the last {_MOST_GAPS} rows came {shape.raster:g} s after the one before it, the raster that was learnt"
            )
        if self._filled < shape.rows:
            return None
        apart = (time - float(self._rows[0, 0])) / (shape.rows - 1)
        if abs(apart / shape.raster - 1.0) > _JITTER:
            self._filled = 0
            raise InputError(
                f"rows until {time:g} s are {apart:.4g} s apart, those that were learnt from {shape.raster:g} s: give rows at that raster"
            )
        block = {c: self._rows[None, :, k].copy() for k, c in enumerate(self.of.columns, 1)}
        begin = float(self._rows[shape.before, 0])
        self._rows[: shape.rows - shape.inside] = self._rows[shape.inside :]
        self._filled = shape.rows - shape.inside
        return self.judge(block, np.array([begin]))

    def _check_row(self, time: float, values: np.ndarray) -> None:
        columns = self.of.columns
        if values.shape != (len(columns),):
            raise InputError(
                f"row at {time:g} s: its shape is {values.shape}; it must have one value for each of {', '.join(columns)}"
            )
        if not (isfinite(time) and np.isfinite(values).all()):
            which = next((c for c, v in zip(columns, values.tolist(), strict=True) if not isfinite(v)), "time")
            raise InputError(
                f"row at {time:g} s: {which} is no finite number; leave the row out, a gap begins a new block"
            )

    def judge(self, readings: Readings, begins: np.ndarray, each: Callable[[], None] | None = None) -> Alarm | None:
        """Take blocks that follow each other; the alarm that is there after them.

        Parameters
        ----------
        readings : Readings
        begins : (n_block,) array, s
            Time of the first row that is judged of each.
        each : function, optional
            Called after each block.
        """
        now = None
        place = 0
        for part in chunks(readings):
            scores = block_scores(self.of, part, self.expected.noise, self.expected.scales)
            white = whitened(scores, self.expected.offset, self.expected.jitter)
            frozen = self._frozen(part)
            for k in range(len(white.pull)):
                now = self._block(white, k, float(begins[place]), frozen[k])
                place += 1
                if each is not None:
                    each()
        return now

    def _block(self, white: Whitened, k: int, begin: float, frozen: list[Frozen]) -> Alarm | None:
        evidence = self.evidence
        self._times[self.blocks % len(self._times)] = begin
        evidence.add(white.pull[k], white.information[k])
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
        suspects = alarm.suspects
        if not (suspects and suspects[0].name.endswith(FREEZE)):
            if self.blocks - self._opened <= DIAGNOSED or not suspects:
                suspects = tuple(suspects_of(self.of.directions, evidence.since(self._opened), self._common))
            owners = {s.name.partition(".")[0] for s in suspects}
            still = [sensor.column for sensor in frozen if sensor.alone or owners & self._owners(sensor.column)]
            suspects = tuple(map(_frozen_sensor, still)) or suspects
        self.alarms[-1] = alarm._replace(until=begin + seconds, suspects=suspects)
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

    def _frozen(self, readings: Readings) -> list[list[Frozen]]:
        """Sensors of each block that have not moved for longer than they ever did."""
        found: list[list[Frozen]] = [[] for _ in range(len(readings[self.of.columns[0]]))]
        states = flat_blocks(self.of.machine, readings, self.of.shape, self.expected.noise)
        for place, column in enumerate(self.of.columns):
            limit = too_long(self.expected.longest[column])
            for k, state in enumerate(states[column].tolist()):
                self._flat[place] = (
                    self._flat[place] + 1 if state == FLAT else 0 if state == MOVES else self._flat[place]
                )
                if self._flat[place] >= limit:
                    found[k].append(Frozen(column, int(self._flat[place]), bool(self._flat[place] >= ALONE * limit)))
        return found

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
        return list(found.values())


def _frozen_sensor(column: str) -> Suspect:
    return Suspect(f"{column}{FREEZE}", f"sensor of {column} stays at what it reads", 1.0, np.nan, np.nan, False)
