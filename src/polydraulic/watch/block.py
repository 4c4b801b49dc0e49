"""Blocks judged by compiled kernels: what each says of every direction, and of every sensor. Plain arrays, filled anew with each block."""

from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import NamedTuple

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.watch.blocks import BlockShape
from polydraulic.watch.channels import WatchChannel, valves_beside
from polydraulic.watch.directions import Direction, Scores
from polydraulic.watch.flat import states_table
from polydraulic.watch.kernels.alarms import decide
from polydraulic.watch.kernels.courses import BEGAN_BEFORE, NO_COURSE, ROOM_OF_COURSE, GrownError
from polydraulic.watch.kernels.evidence import KEPT, room_of_evidence
from polydraulic.watch.kernels.numbers import (
    BLOCKS,
    COURSE,
    GROWN_ERROR,
    GROWS,
    HEAD_OF_LIVE,
    HEAD_OF_MARKS,
    LISTED,
    OPENED,
    STUCK,
    SUSPECTS,
    TOLD,
    WatchNumbers,
)
from polydraulic.watch.kernels.rows import FULL, JUDGED, keep_rows, take_row
from polydraulic.watch.kernels.scores import room_of_scores
from polydraulic.watch.kernels.text import kernels_for
from polydraulic.watch.noise import first_variances
from polydraulic.watch.plan import PlanArrays
from polydraulic.watch.residuals import Residuals, case_of

Readings = Mapping[str, np.ndarray]  # by column, (n_block, n_row) in SI


class ChannelPlace(NamedTuple):
    """Where in a plan's room the residual of a channel and its variance by the noise of sensors begin, and how many they are."""

    own: int
    variance: int
    length: int


class BlockPlan(NamedTuple):
    """What kernels read of a machine that is watched.

    Attributes
    ----------
    machine : LayoutMachine
    columns : tuple of str
    shape : BlockShape
    directions : tuple of Direction
    places : tuple of ChannelPlace
    arrays : PlanArrays
        Its tables are those of `score` and `sensor_states`.
    """

    machine: LayoutMachine
    columns: tuple[str, ...]
    shape: BlockShape
    directions: tuple[Direction, ...]
    places: tuple[ChannelPlace, ...]
    arrays: PlanArrays


def block_plan(
    machine: LayoutMachine,
    columns: Sequence[str],
    shape: BlockShape,
    channels: tuple[WatchChannel, ...],
    directions: Sequence[Direction],
    noise: Mapping[str, float],
) -> BlockPlan:
    """Plan of a machine's blocks; arguments as of `Watched`, and the standard deviation of each sensor's white noise."""
    residuals, healthy = Residuals(columns, shape, channels), case_of(machine)
    own, cases = residuals.of(healthy), [residuals.of(d.case) for d in directions]
    variances = first_variances(residuals, healthy, noise)
    lengths = [residuals.length(channel) for channel in channels]
    places = tuple(ChannelPlace(*place) for place in zip(own, variances, lengths, strict=True))
    table = [len(channels), residuals.plan.room(max(len(directions), 1))]
    for k, place in enumerate(places):
        touched = [(d, case[k]) for d, case in enumerate(cases) if case[k] != place.own]
        table += [place.own, place.variance, place.length, len(touched), *(part for pair in touched for part in pair)]
    states = states_table(residuals.plan, machine, columns, shape, noise)
    return BlockPlan(machine, tuple(columns), shape, tuple(directions), places, residuals.plan.arrays(table, states))


class AlarmTests(NamedTuple):
    """When a machine that is watched gives an alarm.

    Attributes
    ----------
    together : (n_direction,) array
        What evidence of each direction is divided by.
    slow : (n_direction,) array
        Variance of the offset of each from one stretch of work to the next.
    common : float
        The same of a diagnosis.
    threshold : float
        Of the evidence.
    longest : sequence of int
        Blocks from which on each sensor stays for too long.
    """

    together: np.ndarray
    slow: np.ndarray
    common: float
    threshold: float
    longest: Sequence[int]


class BlockJudge:
    """A block after the other, in arrays that kernels fill.

    Parameters
    ----------
    plan : BlockPlan
    scales : sequence of (float, float)
        Of each channel: variance to add, and factor, as healthy blocks showed them.
    offset, jitter : (n_direction,) array
        Of healthy work.
    tests : AlarmTests, optional
        For alarms.

    Attributes
    ----------
    numbers : WatchNumbers
        All that kernels read.
    live, marks : arrays of float and int
        What is kept from row to row and from block to block.
    work : array
        What is filled anew with each block.
    rows : (n_row, 1 + n_column) array
        The block, a part of `live`: time and values of each row.
    pull, white_pull, white_information : (n_direction,) arrays
    information : (n_direction, n_direction) array
    states : (n_column,) array of int
        `FLAT`, `MOVES` or `RESTS` of each sensor.
    worked : (n_column,) array of int
        Blocks in which the function of each sensor worked.
    sums : (n_direction, 2) array
        Evidence for each direction, both ways.
    showing : (n_direction,) array
        Evidence that its smallest fault would have given by now.
    seen : (3, n_direction) array
        Pull, information and squares in the blocks that the last diagnosis was made of.
    chances : (n_direction,) array
        Probability of each direction by that diagnosis.
    """

    def __init__(
        self,
        plan: BlockPlan,
        scales: Sequence[tuple[float, float]],
        offset: np.ndarray,
        jitter: np.ndarray,
        tests: AlarmTests | None = None,
    ) -> None:
        n, sensors = len(plan.directions), len(plan.columns)
        tests = AlarmTests(np.ones(n), np.zeros(n), 1.0, np.inf, [1] * sensors) if tests is None else tests
        self.plan = plan
        self.kernels = kernels_of(plan.machine)
        names = owner_names(plan.machine, plan.directions)
        at_times = HEAD_OF_LIVE + plan.shape.rows * (1 + sensors)
        at_sums = at_times + KEPT + 1
        at_chances = at_sums + room_of_evidence(n)
        in_course = plan.arrays.size + room_of_scores(n)
        kinds = [d.name for d in plan.directions]
        owners = [d.name.partition(".")[0] for d in plan.directions] + [c.partition(".")[0] for c in plan.columns]
        self.numbers = WatchNumbers(
            ints=plan.arrays.ints, floats=plan.arrays.floats, scales=np.array(scales, dtype=np.float64).ravel(),
            offset=offset.astype(np.float64), jitter=jitter.astype(np.float64), together=tests.together.astype(np.float64),
            slow=tests.slow.astype(np.float64),
            down=_whole([d.both for d in plan.directions]), group=_whole([kinds.index(kind) for kind in kinds]),
            harmless=_whole([d.harmless for d in plan.directions]), errors=_whole([d.kind == "bias" for d in plan.directions]),
            owner=_whole([names.index(owner) for owner in owners]), belongs=_belonging(plan.machine, plan.columns, names),
            limits=_whole(tests.longest), directions=n, sensors=sensors, owners=len(names), rows=plan.shape.rows,
            before=plan.shape.before, inside=plan.shape.inside,
            score_table=plan.arrays.tables[0], states_table=plan.arrays.tables[1], in_work=plan.arrays.size, in_course=in_course,
            at_rows=HEAD_OF_LIVE, at_times=at_times, at_sums=at_sums, at_chances=at_chances, in_marks=HEAD_OF_MARKS,
            threshold=float(tests.threshold), common=float(tests.common), raster=float(plan.shape.raster),
        )  # fmt: skip
        self.live = np.zeros(at_chances + n)
        self.marks = np.zeros(HEAD_OF_MARKS + 2 * n + 6 * sensors + len(names), dtype=np.int64)
        self.marks[OPENED] = -1
        self.work = np.zeros(in_course + ROOM_OF_COURSE)
        self.rows = self.live[HEAD_OF_LIVE:at_times].reshape(plan.shape.rows, 1 + sensors)
        scores = np.split(self.work[plan.arrays.size :], np.cumsum([n, n * n, n, n]))
        self.pull, self.information, self.white_pull, self.white_information, room = scores
        self.information, self.seen = self.information.reshape(n, n), room[: 3 * n].reshape(3, n)
        self.sums, self.showing = self.live[at_sums:][: 2 * n].reshape(n, 2), self.live[at_sums + 2 * n :][:n]
        self.chances = self.live[at_chances:]
        # behind the states of sensors stands what the kernel needs for them
        of_sensors = self.marks[HEAD_OF_MARKS + 2 * n + 2 * sensors + len(names) :].reshape(4, sensors)
        self.states, self.worked = of_sensors[0], of_sensors[2]
        self._named = self.marks[HEAD_OF_MARKS + 2 * n + sensors :][:sensors]

    def load(self, readings: Readings, k: int) -> None:
        """Fill `rows` with a block of readings; its times stay what they are."""
        for place, column in enumerate(self.plan.columns, 1):
            self.rows[:, place] = readings[column][k]

    def residuals(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Residual and variance by the noise of sensors of each channel, of the block in `rows`; copies."""
        self.kernels.run_plan(self.numbers.ints, self.numbers.floats, self.live, self.work)
        return [
            (self.work[p.own : p.own + p.length].copy(), self.work[p.variance : p.variance + p.length].copy())
            for p in self.plan.places
        ]

    def judge(self) -> None:
        """Fill scores and states from the block in `rows`."""
        self.kernels.judge_block(self.numbers, self.work, self.live, self.marks)

    def block(self) -> int:
        """Judge the block in `rows` and take what it says: `NONE`, `GOES_ON` or `BEGINS`, of an alarm."""
        self.judge()
        return int(decide(self.numbers, self.work, self.live, self.marks))

    @property
    def listed(self) -> list[int]:
        """Directions that the alarm may be of, the most likely first."""
        return list(self.marks[SUSPECTS : SUSPECTS + self.marks[LISTED]].tolist())

    @property
    def told(self) -> bool:
        """Whether the last block was diagnosed."""
        return bool(self.marks[TOLD] == self.marks[BLOCKS])

    @property
    def stuck(self) -> list[int]:
        """Sensors that stay at what they read, which the alarm is of if there are any."""
        return list(np.flatnonzero(self._named).tolist()) if self.marks[STUCK] > 0 else []

    @property
    def course(self) -> GrownError | None:
        """How the error of a sensor went on that the alarm is named by."""
        return None if self.marks[COURSE] == NO_COURSE else GrownError(*self.live[GROWS : GROWN_ERROR + 1].tolist())

    @property
    def began_before(self) -> bool:
        """Whether that is of blocks that are no longer kept."""
        return bool(self.marks[COURSE] == BEGAN_BEFORE)

    def row(self, time: float, row: np.ndarray) -> int:
        """Take a row: what became of it, and `JUDGED` with what that means for alarms of one that completes a block."""
        of = self.numbers
        became = int(take_row(time, row, of.rows, self.live, of.at_rows, self.marks, of.raster))
        if became == FULL:
            became = JUDGED + self.block()
            keep_rows(self.live, of.at_rows, of.rows, of.inside, of.sensors + 1, self.marks)
        return became


def kernels_of(machine: LayoutMachine) -> ModuleType:
    """The kernels of a block of a machine."""
    joined = [len(valves_beside(machine, machine.circuit(x.taking).functions[0])) for x in machine.crossovers]
    return kernels_for((len(c.functions) for c in machine.circuits if c.kind != "crossover"), joined)


def owner_names(machine: LayoutMachine, directions: Sequence[Direction]) -> list[str]:
    """What faults are of: functions, circuits, and whatever else directions begin with."""
    names = [*machine.names, *(c.name for c in machine.circuits), *(d.name.partition(".")[0] for d in directions)]
    return list(dict.fromkeys(names))


def _belonging(machine: LayoutMachine, columns: Sequence[str], names: Sequence[str]) -> np.ndarray:
    """Of each sensor, of what a fault may be that it looks like when it stays: its function, and the circuit of that."""
    found = np.zeros((len(columns), len(names)), dtype=np.int64)
    for k, column in enumerate(columns):
        function = column.partition(".")[0]
        for name in (function, *(c.name for c in machine.circuits if function in c.functions)):
            found[k, names.index(name)] = 1
    return found.ravel()


def _whole(values: Sequence[int]) -> np.ndarray:
    return np.array(values, dtype=np.int64)


def residuals_of(plan: BlockPlan, readings: Readings) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Residuals of each channel, and their variances by the noise of sensors, (n_block, n_instant) each."""
    n = len(plan.directions)
    judge = BlockJudge(plan, [(0.0, 1.0)] * len(plan.places), np.zeros(n), np.zeros(n))
    blocks = []
    for k in range(_blocks_of(readings)):
        judge.load(readings, k)
        blocks.append(judge.residuals())
    channels = range(len(plan.places))
    return [np.array([b[c][0] for b in blocks]) for c in channels], [
        np.array([b[c][1] for b in blocks]) for c in channels
    ]


def scores_of(plan: BlockPlan, readings: Readings, scales: Sequence[tuple[float, float]]) -> tuple[Scores, np.ndarray]:
    """What blocks say of every direction, and `FLAT`, `MOVES` or `RESTS` of each sensor, (n_block, n_column)."""
    n, blocks = len(plan.directions), _blocks_of(readings)
    judge = BlockJudge(plan, scales, np.zeros(n), np.zeros(n))
    scores = Scores(np.empty((blocks, n)), np.empty((blocks, n, n)))
    states = np.empty((blocks, len(plan.columns)), dtype=np.int64)
    for k in range(blocks):
        judge.load(readings, k)
        judge.judge()
        scores.pull[k], scores.information[k], states[k] = judge.pull, judge.information, judge.states
    return scores, states


def _blocks_of(readings: Readings) -> int:
    return len(next(iter(readings.values())))
