"""What the driver of blocks of machines is given beside their parameters."""

from typing import NamedTuple

import numpy as np


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
