"""Steps over windows of rows: balances of volume; where they are worth something, and what noise makes of them."""

from math import inf

import numpy as np

from polydraulic._kernel import driver
from polydraulic.watch.kernels.signals import NOTHING, is_known


@driver
def volume_balance(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Mean flow that motion and compliance took in each window, less that which came through the valve, for one side of an actuator.

    The other side's pressure and the spool tell what leaks and which way flow goes; oil that a relief valve may have let go is left out.
    """
    out, n, volume, pressure, smoothed = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    other, spool, into, away = ints[s + 5], ints[s + 6], ints[s + 7], ints[s + 8]
    first, long, side_a, number = ints[s + 9], ints[s + 10], ints[s + 11], ints[s + 12]
    seconds, leakage, external = floats[number], floats[number + 1], floats[number + 2]
    compliance, relief, band, least_loss = (
        floats[number + 3],
        floats[number + 4],
        floats[number + 5],
        floats[number + 6],
    )
    for w in range(n):
        begin = first + w * long
        passing, entering, most = 0.0, 0.0, 0.0
        for i in range(long + 1):
            at = begin + i
            p = work[pressure + at]
            fed = work[spool + at] >= 0.0
            fed = fed if side_a != 0 else not fed
            through = work[into + at] if fed else -work[away + at]
            through = through - leakage * (p - work[other + at]) - external * p
            share = 0.5 if i == 0 or i == long else 1.0
            passing += share * through
            entering += share * max(through, 0.0)
            most = max(most, work[smoothed + at])
        passing, entering = passing / float(long), entering / float(long)
        moved = (work[volume + begin + long] - work[volume + begin]) / seconds
        pressed = compliance * (work[pressure + begin + long] - work[pressure + begin]) / seconds
        lost = 0.0 if most < relief else entering + max(-moved, 0.0)
        # as much as does not go elsewhere
        near = max(passing - moved - least_loss, 0.0)
        lost = near if abs(most - relief) < band else lost
        # what is let go is found from the same flows: where they are not known, both would cancel to something that seems to be
        work[out + w] = moved + pressed - passing + lost if is_known(passing) else NOTHING


@driver
def within(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """1 of windows in all rows of which a signal lies between two numbers, else 0."""
    out, n, of, first = ints[s], ints[s + 1], ints[s + 2], ints[s + 3]
    long, stride, number = ints[s + 4], ints[s + 5], ints[s + 6]
    low, high = floats[number], floats[number + 1]
    for w in range(n):
        fine = 1.0
        for i in range(long + 1):
            x = work[of + first + w * stride + i]
            fine = fine if x > low and x < high else 0.0
        work[out + w] = fine


@driver
def above(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """1 of rows in which a signal is above a number, else 0."""
    out, n, of, first, number = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for i in range(n):
        work[out + i] = 1.0 if work[of + first + i] > floats[number] else 0.0


@driver
def clear_of_relief(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """0 of rows in which a valve of a circuit feeds a port near the relief setting, else 1."""
    out, n, first, number, valves = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for i in range(n):
        fine = 1.0
        for v in range(valves):
            pressure, spool = ints[s + 5 + 2 * v], ints[s + 6 + 2 * v]
            near = work[pressure + first + i] > floats[number] and abs(work[spool + first + i]) > floats[number + 1 + v]
            fine = 0.0 if near else fine
        work[out + i] = fine


@driver
def same_number(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """The same number everywhere."""
    out, n, number = ints[s], ints[s + 1], ints[s + 2]
    for i in range(n):
        work[out + i] = floats[number]


@driver
def add_moved(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Add to a variance what noise of a sensor does, by the larger change of a residual when the sensor is moved either way."""
    out, n, own, up, down, number = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4], ints[s + 5]
    for i in range(n):
        r = work[own + i]
        one, other = abs(work[up + i] - r), abs(work[down + i] - r)
        square = max(one, other) * floats[number]
        square = square * square
        # what is not known at one of them adds nothing: the residual is judged by the other sensors
        work[out + i] += square if is_known(square) else 0.0


@driver
def add_window_noise(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Add to a variance the noise of a balance: that of the position at both ends by the larger lever, and the rest."""
    out, n, lever_a, lever_b = ints[s], ints[s + 1], ints[s + 2], ints[s + 3]
    first, long, number = ints[s + 4], ints[s + 5], ints[s + 6]
    for w in range(n):
        at = first + w * long
        moved = floats[number] * max(work[lever_a + at], work[lever_b + at])
        work[out + w] += moved * moved + floats[number + 1]


@driver
def where_worth(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """A variance with the least that there is, infinite where a residual is worth nothing or not known."""
    out, n, variance, own, mask, number = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4], ints[s + 5]
    for i in range(n):
        r = work[own + i]
        fine = work[mask + i] > 0.0 and is_known(r)
        work[out + i] = work[variance + i] + floats[number] if fine else inf
