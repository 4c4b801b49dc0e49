"""The state of the machine: one float for each link and quantity.

Links stand in kinematic order everywhere: swing, boom, stick.
"""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.parameters.schema import Machine

N_STATE = 15


class Links(NamedTuple):
    """One float a link."""

    swing: float
    boom: float
    stick: float


class State(NamedTuple):
    """Everything the machine remembers from one step to the next, SI."""

    spool: Links
    p_a: Links
    p_b: Links
    angle: Links
    rate: Links


def initial_state(machine: Machine) -> State:
    """State of `machine` at the start: spools centred, joints at rest, angles and line pressures as in its set."""
    starts = [machine.swing.initial, machine.boom.initial, machine.stick.initial]
    rest = Links(0.0, 0.0, 0.0)
    return State(
        spool=rest,
        p_a=Links(*(start.p_a for start in starts)),
        p_b=Links(*(start.p_b for start in starts)),
        angle=Links(*(start.angle for start in starts)),
        rate=rest,
    )


def to_vector(x: State) -> np.ndarray:
    """State as one vector of shape (15,), quantity by quantity: what an ODE solver owns."""
    return np.array([value for links in x for value in links], dtype=np.float64)


@kernel
def from_vector(v: np.ndarray) -> State:
    """State from a vector of shape (15,)."""
    return State(
        Links(v[0], v[1], v[2]),
        Links(v[3], v[4], v[5]),
        Links(v[6], v[7], v[8]),
        Links(v[9], v[10], v[11]),
        Links(v[12], v[13], v[14]),
    )


@kernel
def store(x: State, v: np.ndarray) -> None:
    """Write a state into the first 15 places of a vector."""
    v[0], v[1], v[2] = x.spool.swing, x.spool.boom, x.spool.stick
    v[3], v[4], v[5] = x.p_a.swing, x.p_a.boom, x.p_a.stick
    v[6], v[7], v[8] = x.p_b.swing, x.p_b.boom, x.p_b.stick
    v[9], v[10], v[11] = x.angle.swing, x.angle.boom, x.angle.stick
    v[12], v[13], v[14] = x.rate.swing, x.rate.boom, x.rate.stick
