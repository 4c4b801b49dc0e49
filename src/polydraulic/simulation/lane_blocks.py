"""Machines that run side by side in lanes: what is kept of them, whatever their layout."""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import sincos
from polydraulic.flow.lanes import LANES


class LaneBlock(NamedTuple):
    """Machines that run side by side, and what is kept of them.

    Attributes
    ----------
    rows : (n_row * LANES,) array
        The first rows hold the states at the start, then at the end; row STEPS the steps made. Behind those of a step stand scratch of
        networks, and three rows for the place of the tip.
    machine : (n <= LANES,) array of int
        Places of the lanes' machines in the results; lanes beyond are filled up and not kept.
    signal : (LANES,) array of int
        Place of each lane's voltages.
    lowest, highest : (n_column, LANES) arrays
        Scratch for the ranges of the columns that are kept; none for n_column = 0.
    """

    rows: np.ndarray
    machine: np.ndarray
    signal: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray


class Tips(NamedTuple):
    """Links between the tip and the ground, the outermost first, of the machines of a block.

    Attributes
    ----------
    row : int
        First of three rows for the tip's place; 0 if it is not kept.
    angle : (n_link,) array of int
        Rows of their positions.
    axis : (n_link,) array of int
        Axis, 0 to 2, about which a link turns or along which it slides.
    sign : (n_link,) array
        Of its position.
    slides : (n_link,) array of bool
    at : (n_link, 3, LANES) array
        Joint of each link in its parent, m.
    point : (3, LANES) array
        The tip in the last link, m.
    """

    row: int
    angle: np.ndarray
    axis: np.ndarray
    sign: np.ndarray
    slides: np.ndarray
    at: np.ndarray
    point: np.ndarray


class Kept(NamedTuple):
    """What to keep, and where.

    Attributes
    ----------
    columns : (n_column,) array of int
        Rows of a block that are kept.
    circuits : bool
        Whether pump flows or pressures are among them.
    every : int
        A row is recorded every so many steps; 0 for none.
    rows : (n_machine, n_time, n_column) array
    final : (n_machine, n_column) array
    lowest, highest : (n_machine, n_column) arrays
        Filled if the block has scratch for them.
    tips : Tips
    """

    columns: np.ndarray
    circuits: bool
    every: int
    rows: np.ndarray
    final: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    tips: Tips


@kernel
def place_tips(block: LaneBlock, tips: Tips) -> None:
    """Place of the tip of every machine: a point that is carried from link to link, as `machine.reach.tip` does."""
    for j in range(3):
        x, start = block.rows[(tips.row + j) * LANES :], tips.point[j]
        for lane in range(LANES):
            x[lane] = start[lane]
    for k in range(tips.angle.shape[0]):
        axis, sign, position = tips.axis[k], tips.sign[k], block.rows[tips.angle[k] * LANES :]
        if tips.slides[k]:
            along = block.rows[(tips.row + axis) * LANES :]
            for lane in range(LANES):
                along[lane] = along[lane] + sign * position[lane]
        else:
            first, second = (
                block.rows[(tips.row + (axis + 1) % 3) * LANES :],
                block.rows[(tips.row + (axis + 2) % 3) * LANES :],
            )
            for lane in range(LANES):
                turn, u, v = sincos(sign * position[lane]), first[lane], second[lane]
                first[lane], second[lane] = turn.cos * u - turn.sin * v, turn.sin * u + turn.cos * v
        for j in range(3):
            x, at = block.rows[(tips.row + j) * LANES :], tips.at[k, j]
            for lane in range(LANES):
                x[lane] = x[lane] + at[lane]


@kernel
def keep_row(block: LaneBlock, kept: Kept, place: int) -> None:
    """Record a row of every machine."""
    if kept.tips.row > 0:
        place_tips(block, kept.tips)
    for lane in range(block.machine.shape[0]):
        machine = block.machine[lane]
        for c in range(kept.columns.shape[0]):
            kept.rows[machine, place, c] = block.rows[kept.columns[c] * LANES + lane]


@kernel
def keep_range(block: LaneBlock, kept: Kept) -> None:
    """Widen the ranges by what the rows hold now."""
    for c in range(block.lowest.shape[0]):
        value, lowest, highest = block.rows[kept.columns[c] * LANES :], block.lowest[c], block.highest[c]
        for lane in range(LANES):
            lowest[lane] = min(lowest[lane], value[lane])
            highest[lane] = max(highest[lane], value[lane])


@kernel
def keep_final(block: LaneBlock, kept: Kept) -> None:
    """Record the end, and the ranges."""
    if kept.tips.row > 0:
        place_tips(block, kept.tips)
    for lane in range(block.machine.shape[0]):
        machine = block.machine[lane]
        for c in range(kept.columns.shape[0]):
            kept.final[machine, c] = block.rows[kept.columns[c] * LANES + lane]
        for c in range(block.lowest.shape[0]):
            kept.lowest[machine, c], kept.highest[machine, c] = block.lowest[c, lane], block.highest[c, lane]
