"""Sensors that hardly move in a block although their function works."""

from math import sqrt

import numpy as np

from polydraulic._kernel import driver

FLAT, MOVES, RESTS = 1, 0, -1
_OTHERS = 2  # sensors of a function that move while it works


@driver
def sensor_states(
    ints: np.ndarray, floats: np.ndarray, live: np.ndarray, at_rows: int, marks: np.ndarray, states: int, s: int
) -> None:
    """`FLAT`, `MOVES` or `RESTS` of each sensor; behind these stands which of them are flat, whether their functions work or not.

    From `s` on `ints` holds how many sensors there are, the first row that is judged and how many, numbers of a row, and where in `floats` the
    largest deviation of a flat one stands; of each sensor which tells whether its valve is open (a place in a row, 0: none), where factor and
    edge of that stand, how many others its function has, and which.
    """
    sensors, first, n, width, number = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for c in range(sensors):
        mean, squares = 0.0, 0.0
        for i in range(first, first + n):
            mean += live[at_rows + i * width + 1 + c]
        mean = mean / float(n)
        for i in range(first, first + n):
            off = live[at_rows + i * width + 1 + c] - mean
            squares += off * off
        marks[states + sensors + c] = 1 if sqrt(squares / float(n)) <= floats[number + c] else 0
    at = s + 5
    for c in range(sensors):
        opens, edge, others = ints[at], ints[at + 1], ints[at + 2]
        lively = 0
        for k in range(others):
            lively += 1 - marks[states + sensors + ints[at + 3 + k]]
        at += 3 + others
        wide = 0
        if opens > 0:
            for i in range(first, first + n):
                wide += 1 if abs(live[at_rows + i * width + opens] * floats[edge]) > floats[edge + 1] else 0
        works = lively >= _OTHERS and 2 * wide > n
        flat = FLAT if marks[states + sensors + c] > 0 else MOVES
        marks[states + c] = flat if works else RESTS
