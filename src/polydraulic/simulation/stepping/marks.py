"""What the compiled drivers and Python tell each other: places in the counters of a machine, and why a call ended.

A machine that is moved step by step is a few flat arrays, which drivers change in place; nothing else has memory.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.simulation.layout.methods.event_log import EventLimits
from polydraulic.simulation.layout.seen import SeenLimits

# places in `counts`
STEPS = 0  # made since the start
UNSETTLED = 1  # of these, steps whose flows did not converge
OUTSIDE = 2  # and steps outside the flow model's domain
CHANGES = 3  # pairs of rows in `changes`
STOP = 4  # 1: end a call after a step in which an event begins or ends
STATUS = 5  # why the last call ended
WHICH = 6  # function whose lever was refused
BEYOND = 7  # steps beyond the log that the machine was identified from
FLAGS = 8  # conditions that hold; then those of the step before

# all steps made; a lever's voltage; a rate diverged; `changes` is full, or stopped
DONE, REFUSED, LOST, NOTED = 0, 1, 2, 3
MOST_CHANGES = 64  # pairs of rows that a call may leave


class Hand(NamedTuple):
    """What a machine makes of levers, and which events are seen.

    Attributes
    ----------
    most : (n_function,) array, V
        Largest voltage to either side.
    moves : (n_function,) array of int
        1, or 0 of a function that is locked.
    wait : (n_function,) array of int
        Dead time in steps.
    limits : EventLimits
    seen : SeenLimits
        Of the log that the machine was identified from.
    """

    most: np.ndarray
    moves: np.ndarray
    wait: np.ndarray
    limits: EventLimits
    seen: SeenLimits


class Levered(NamedTuple):
    """Levers of all machines.

    Attributes
    ----------
    given, taken : (n, n_input) and (n, 1, n_input) arrays, V and N
        Levers, then the force; what of them reaches the machines in a step.
    moves : (n_function,) array of int
        0 of functions that are locked.
    wait : (n_block, n_function, LANES) array of int
        Dead times in steps.
    delay : (n_block, n_function, n_wait, LANES) array, V
        Levers of the last steps, where there are dead times.
    """

    given: np.ndarray
    taken: np.ndarray
    moves: np.ndarray
    wait: np.ndarray
    delay: np.ndarray


class Again(NamedTuple):
    """Machines that begin anew: room for a copy of a block, which they are, and their states."""

    scratch: np.ndarray
    mask: np.ndarray
    states: np.ndarray
