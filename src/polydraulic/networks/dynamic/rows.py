"""One row of a dynamic model: what it may answer, and what a measured row shows of how strong a joint is.

Free runs of the package and exported C (`export.c.run`) are made of the same text.
"""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.networks.dynamic.joint_strength import (
    STRONGEST,
    WEAKEST,
    Belief,
    StrengthNumbers,
    after_window,
)

STATES = 10  # numbers kept of a joint: its belief, then of a window that is not over rates, their sizes, travel, rows, and rows at an end


class OutputLimits(NamedTuple):
    """Of an output."""

    down: float  # smallest change from row to row
    up: float  # largest change
    low: float  # ends of its range
    high: float


@kernel
def answer(limits: OutputLimits, upwards: float, downwards: float, y: float, last: float) -> float:
    """What a row answers behind `last`, of a network that says `y` and a joint that is so strong upwards and downwards."""
    strength = upwards if y > last else downwards
    stronger = min(max(last + strength * (y - last), limits.low), limits.high) if strength != 1.0 else y
    return min(max(stronger, last + limits.down), last + limits.up)


@kernel
def begin_strength(states: np.ndarray, numbers: StrengthNumbers) -> None:
    """Nothing was measured yet: as strong as in the mean, as unsure as strengths differ."""
    for i in range(STATES):
        states[i] = 0.0
    states[2] = numbers.spread * numbers.spread
    states[4] = numbers.lean * numbers.lean


@kernel
def see_row(
    states: np.ndarray, limits: OutputLimits, numbers: StrengthNumbers, y: float, last: float, measured: float
) -> None:
    """Take a row that was measured behind `last`, where the network says `y`."""
    rate = min(max(y, last + limits.down), last + limits.up) - last
    states[5] += rate
    states[6] += abs(rate)
    states[7] += measured - last
    states[8] += 1.0
    states[9] += 1.0 if y <= limits.low or y >= limits.high else 0.0
    if states[8] >= numbers.rows:
        path = states[6] if states[9] == 0.0 else 0.0  # a joint at its end does not follow its valve
        before = Belief(states[0], states[1], states[2], states[3], states[4])
        belief = after_window(before, numbers, states[5], path, states[7])
        states[0] = belief.both
        states[1] = belief.lean
        states[2] = belief.var_both
        states[3] = belief.covariance
        states[4] = belief.var_lean
        for i in range(5, STATES):
            states[i] = 0.0


@kernel
def strength_of(both: float, lean: float) -> float:
    """The factor of a rate that a belief comes to; one way it leans up, and down the other."""
    return min(max(1.0 + both + lean, WEAKEST), STRONGEST)
