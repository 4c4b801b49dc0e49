"""Sensors that stay at what they read: for how many blocks in succession one hardly moves although its function works."""

from collections.abc import Mapping, Sequence

import numpy as np

from polydraulic.machine.valve import spool_edges
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.watch.blocks import BlockShape
from polydraulic.watch.kernels.stays import FLAT, MOVES
from polydraulic.watch.plan import Plan

_NOISE = 1.6  # standard deviations of a sensor's noise, below which it does not move
_LEAST = 5  # blocks
_TIMES = 3  # the longest of healthy work


def states_table(
    plan: Plan, machine: LayoutMachine, columns: Sequence[str], shape: BlockShape, noise: Mapping[str, float]
) -> list[int]:
    """The table that `sensor_states` reads, with its numbers in a plan.

    A function works where its valve is open (by the spool, or the voltage, whichever is not asked about) and two of its other sensors move: at a
    stop all of them rest. A pump's pressure is asked about while the first function that it feeds works.
    """
    limits = plan.numbers([_NOISE * noise.get(column, 0.0) for column in columns])
    table = [len(columns), shape.before, shape.inside, 1 + len(columns), limits]
    for column in columns:
        name, _, what = column.partition(".")
        name = machine.circuit(name).functions[0] if what == "p_pump" else name
        others = [k for k, other in enumerate(columns) if other != column and other.startswith(f"{name}.")]
        f = machine.function(name)
        by_spool = f"{name}.spool" in columns and what != "spool"
        tells = f"{name}.spool" if by_spool else f"{name}.voltage"
        known = tells in columns and (what != "voltage" or by_spool)
        edge = plan.numbers((1.0 if by_spool else f.pilot.gain, spool_edges(f.valve)[0]))
        table += [1 + columns.index(tells) if known else 0, edge, len(others), *others]
    return table


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
