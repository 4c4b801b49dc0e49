"""What a log lets be watched of a machine: residuals and faults by its columns, and the plan of its blocks."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.watch.block import BlockPlan, block_plan
from polydraulic.watch.blocks import BlockShape, block_shape
from polydraulic.watch.channels import WatchChannel, channels_of
from polydraulic.watch.directions import Direction, directions_of
from polydraulic.watch.kernels.rows import JITTER

_SLOWEST = 0.1  # s between rows: filters of motion want some on both sides of a block


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
    if raster > _SLOWEST * (1.0 + JITTER):
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


def plan_of(of: Watched, noise: Mapping[str, float]) -> BlockPlan:
    """The plan of blocks, with the standard deviation of each sensor's white noise, SI."""
    return block_plan(of.machine, of.columns, of.shape, of.channels, of.directions, noise)


def ways_of(directions: Sequence[Direction]) -> np.ndarray:
    """Which ways each goes, (n_direction, 2) of bool."""
    return np.array([[True, d.both] for d in directions])


def tests_of(directions: Sequence[Direction]) -> int:
    """How many tests run at once."""
    return int(ways_of(directions).sum())
