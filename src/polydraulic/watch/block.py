"""Blocks judged by compiled kernels: what each says of every direction, and of every sensor. Plain arrays, filled anew with each block."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.watch.blocks import BlockShape
from polydraulic.watch.channels import WatchChannel
from polydraulic.watch.directions import Direction, Scores
from polydraulic.watch.flat import states_table
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
    directions : int
        How many.
    places : tuple of ChannelPlace
    arrays : PlanArrays
        Its tables are those of `score` and `sensor_states`.
    """

    machine: LayoutMachine
    columns: tuple[str, ...]
    shape: BlockShape
    directions: int
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
    return BlockPlan(machine, tuple(columns), shape, len(directions), places, residuals.plan.arrays(table, states))


class BlockJudge:
    """A block after the other.

    Parameters
    ----------
    plan : BlockPlan
    scales : sequence of (float, float)
        Of each channel: variance to add, and factor, as healthy blocks showed them.
    offset, jitter : (n_direction,) array
        Of healthy work.

    Attributes
    ----------
    rows : (n_row (1 + n_column),) array
        The block: time and values of each row, to be filled by the caller.
    work : array
        Room of the plan's steps.
    pull, white_pull, white_information : (n_direction,) arrays
    information : (n_direction n_direction,) array
    states : (2 n_column,) array of int
        Of each sensor `FLAT`, `MOVES` or `RESTS`, and then what the kernel needs.
    """

    def __init__(
        self, plan: BlockPlan, scales: Sequence[tuple[float, float]], offset: np.ndarray, jitter: np.ndarray
    ) -> None:
        n, columns = plan.directions, len(plan.columns)
        self.plan, self.kernels = (
            plan,
            kernels_for(len(c.functions) for c in plan.machine.circuits if c.kind != "crossover"),
        )
        self.rows, self.work = np.zeros(plan.shape.rows * (1 + columns)), np.zeros(plan.arrays.size)
        self.pull, self.information = np.zeros(n), np.zeros(n * n)
        self.white_pull, self.white_information = np.zeros(n), np.zeros(n)
        self.states = np.zeros(2 * columns, dtype=np.int64)
        self._numbers = np.array(scales, dtype=np.float64).ravel(), offset.astype(float), jitter.astype(float)
        self._room = np.zeros(n * (2 * n + 1))

    def load(self, readings: Readings, k: int) -> None:
        """Fill `rows` with a block of readings; its times stay what they are."""
        rows = self.rows.reshape(self.plan.shape.rows, -1)
        for place, column in enumerate(self.plan.columns, 1):
            rows[:, place] = readings[column][k]

    def residuals(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Residual and variance by the noise of sensors of each channel, of the block in `rows`; copies."""
        arrays = self.plan.arrays
        self.kernels.run_plan(arrays.ints, arrays.floats, self.rows, self.work)
        return [
            (self.work[p.own : p.own + p.length].copy(), self.work[p.variance : p.variance + p.length].copy())
            for p in self.plan.places
        ]

    def judge(self) -> None:
        """Fill everything else from the block in `rows`."""
        arrays = self.plan.arrays
        self.kernels.judge_block(
            arrays.ints, arrays.floats, self.rows, *self._numbers, self.work, self.pull, self.information, self._room,
            self.white_pull, self.white_information, self.states, *arrays.tables,
        )  # fmt: skip


def residuals_of(plan: BlockPlan, readings: Readings) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Residuals of each channel, and their variances by the noise of sensors, (n_block, n_instant) each."""
    n = plan.directions
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
    n, blocks = plan.directions, _blocks_of(readings)
    judge = BlockJudge(plan, scales, np.zeros(n), np.zeros(n))
    scores = Scores(np.empty((blocks, n)), np.empty((blocks, n, n)))
    states = np.empty((blocks, len(plan.columns)), dtype=np.int64)
    for k in range(blocks):
        judge.load(readings, k)
        judge.judge()
        scores.pull[k], scores.information[k] = judge.pull, judge.information.reshape(n, n)
        states[k] = judge.states[: len(plan.columns)]
    return scores, states


def _blocks_of(readings: Readings) -> int:
    return len(next(iter(readings.values())))
