"""Parameters of a block of machines, and what its driver is given beside them."""

from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import overload

from polydraulic._kernel import INLINED_OPTIONS


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


def of_block(own: Any, b: Any) -> Any:
    """Parameters of a block where its machines have some of their own, else None."""
    return None if own is None else own[b]


@overload(of_block, jit_options=INLINED_OPTIONS)
def _of_block_compiled(own: Any, b: Any) -> Any:
    # numba wants the signature of `of_block`, annotations included
    def none(own: Any, b: Any) -> Any:
        return None

    def mine(own: Any, b: Any) -> Any:
        return own[b]

    return none if isinstance(own, types.NoneType) else mine
