"""Sensors that stay at what they read: for how many blocks in succession one hardly moves although its function works."""

import numpy as np

from polydraulic.machine.valve import spool_edges
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.watch.blocks import BlockShape
from polydraulic.watch.residuals import Readings

FLAT, MOVES, RESTS = 1, 0, -1
_NOISE = 1.6  # standard deviations of a sensor's noise, below which it does not move
_OTHERS = 2  # sensors of a function that move while it works
_LEAST = 5  # blocks
_TIMES = 3  # the longest of healthy work


def flat_blocks(
    machine: LayoutMachine, readings: Readings, shape: BlockShape, noise: dict[str, float]
) -> dict[str, np.ndarray]:
    """Of each sensor and block: `FLAT`, `MOVES`, or `RESTS` where the function does not work, (n_block,) of int.

    A function works where its valve is open (by the spool, or the voltage, whichever is not asked about) and two of its other sensors move: at a
    stop all of them rest.
    """
    flat = {
        column: values[:, shape.judged].std(axis=1) <= _NOISE * noise.get(column, 0.0)
        for column, values in readings.items()
    }
    found = {}
    for column in readings:
        name, _, what = column.partition(".")
        others = [~state for other, state in flat.items() if other != column and other.startswith(f"{name}.")]
        lively = (
            np.sum(others, axis=0) >= _OTHERS if len(others) >= _OTHERS else np.zeros(len(flat[column]), dtype=bool)
        )
        works = lively & _open(machine, readings, shape, name, what)
        found[column] = np.where(works, np.where(flat[column], FLAT, MOVES), RESTS)
    return found


def _open(machine: LayoutMachine, readings: Readings, shape: BlockShape, name: str, what: str) -> np.ndarray:
    """Whether a valve is open for most of a block, (n_block,) of bool; not where nothing says so."""
    f = machine.function(name)
    by_spool = f"{name}.spool" in readings and what != "spool"
    column = f"{name}.spool" if by_spool else f"{name}.voltage"
    if column not in readings or (what == "voltage" and not by_spool):
        return np.zeros(len(next(iter(readings.values()))), dtype=bool)
    travel = readings[column][:, shape.judged] * (1.0 if by_spool else f.pilot.gain)
    return np.asarray((np.abs(travel) > spool_edges(f.valve)[0]).mean(axis=1) > 0.5)


def longest_flat(states: dict[str, np.ndarray]) -> dict[str, int]:
    """Most flat blocks in succession of each sensor; blocks in which the function rests count for nothing."""
    found = {}
    for column, state in states.items():
        run = most = 0
        for value in state.tolist():
            run = run + 1 if value == FLAT else 0 if value == MOVES else run
            most = max(most, run)
        found[column] = most
    return found


def too_long(longest: int) -> int:
    """Flat blocks from which on a sensor is frozen."""
    return max(_TIMES * longest + 2, _LEAST)
