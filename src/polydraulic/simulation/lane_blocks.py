"""Machines that run side by side in lanes: what is kept of them, whatever their layout."""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.flow.lanes import LANES


class LaneBlock(NamedTuple):
    """Machines that run side by side, and what is kept of them.

    Attributes
    ----------
    rows : (N_ROW * LANES,) array
        The first 15 rows hold the states at the start, then at the end; row STEPS the steps made.
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
    """

    columns: np.ndarray
    circuits: bool
    every: int
    rows: np.ndarray
    final: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray


@kernel
def keep_row(block: LaneBlock, kept: Kept, place: int) -> None:
    """Record a row of every machine."""
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
    for lane in range(block.machine.shape[0]):
        machine = block.machine[lane]
        for c in range(kept.columns.shape[0]):
            kept.final[machine, c] = block.rows[kept.columns[c] * LANES + lane]
        for c in range(block.lowest.shape[0]):
            kept.lowest[machine, c], kept.highest[machine, c] = block.lowest[c, lane], block.highest[c, lane]
