"""The state of the machine: one float for each link and quantity.

Links stand in kinematic order everywhere: swing, boom, stick.
"""

from typing import NamedTuple

from polydraulic.parameters.schema import Machine


class Links(NamedTuple):
    """One float per link."""

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
