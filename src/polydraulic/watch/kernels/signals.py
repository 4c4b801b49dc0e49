"""Steps from sensors to spools, pressures at ports, flows and volumes, row by row of a block.

A step reads its own places from `ints` behind `s`, in the order of its first lines: where in `work` its rows begin, how many they are, and where
in `floats` its numbers stand. What is not known is `NOTHING`, which no sensor reads and whose square is a number.
"""

from math import sqrt

import numpy as np

from polydraulic._kernel import driver, kernel

NOTHING, _KNOWN = 1e150, 1e100


@kernel
def is_known(x: float) -> bool:
    """Whether nothing that it was made of is `NOTHING`."""
    return abs(x) < _KNOWN


@kernel
def interpolated(floats: np.ndarray, knots: int, values: int, n: int, x: float) -> float:
    """A curve of n knots, straight between them, and constant beyond the first and the last."""
    j = 0
    for k in range(1, n - 1):
        if x < floats[knots + k]:
            break
        j = k
    low, high = floats[knots + j], floats[knots + j + 1]
    slope = (floats[values + j + 1] - floats[values + j]) / (high - low)
    inside = slope * (max(x, low) - low) + floats[values + j]
    return floats[values + j + 1] if x >= high else inside


@driver
def read(ints: np.ndarray, floats: np.ndarray, live: np.ndarray, work: np.ndarray, s: int) -> None:
    """A sensor less what it reads too much; its place is that in the first row."""
    out, n, column, width, number = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    shift = floats[number]
    for i in range(n):
        work[out + i] = live[column + i * width] - shift


@driver
def smooth(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Weighted sums of neighbours; rows at both ends keep their values."""
    out, n, of, weights, half = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for i in range(n):
        work[out + i] = work[of + i]
    for i in range(half, n - half):
        total = 0.0
        for k in range(2 * half + 1):
            total += floats[weights + k] * work[of + i - half + k]
        work[out + i] = total


@driver
def not_below_zero(ints: np.ndarray, work: np.ndarray, s: int) -> None:
    """A pressure, which is none below zero."""
    out, n, of = ints[s], ints[s + 1], ints[s + 2]
    for i in range(n):
        work[out + i] = max(work[of + i], 0.0)


@driver
def spool_by_voltage(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Spool that a voltage drives from where it is at first, the voltage straight between rows; with play it follows late."""
    out, n, voltage, spool, number = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    gain, most, late = floats[number], floats[number + 1], floats[number + 2]
    keep, first, second = floats[number + 3], floats[number + 4], floats[number + 5]
    half = floats[number + 6]
    x, before = 0.0, 0.0
    for i in range(n):
        at = max(float(i) - late, 0.0)
        lower = int(at)
        upper = min(lower + 1, n - 1)
        share = at - float(lower)
        seen = work[voltage + lower] * (1.0 - share) + work[voltage + upper] * share
        target = min(max(gain * seen, -most), most)
        if i == 0:
            x = target
            if spool >= 0:
                x = (work[spool] + work[spool + 1] + work[spool + 2]) / 3.0
        else:
            x = keep * x + first * before + second * target
        before = target
        work[out + i] = x
    if half > 0.0:
        for i in range(1, n):
            work[out + i] = min(max(work[out + i - 1], work[out + i] - half), work[out + i] + half)


@driver
def port(ints: np.ndarray, work: np.ndarray, s: int) -> None:
    """The first pressure where a spool is on the positive side, the second where it is not."""
    out, n, spool, ahead, behind = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for i in range(n):
        work[out + i] = work[ahead + i] if work[spool + i] >= 0.0 else work[behind + i]


@driver
def opening_of_outlet(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Conductance of an outlet at a spool."""
    out, n, spool, knots, count = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for i in range(n):
        x = work[spool + i]
        side = knots + count if x >= 0.0 else knots + 2 * count
        work[out + i] = interpolated(floats, knots, side, count, abs(x))


@driver
def flow_out(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Flow through an outlet to the return line."""
    out, n, conductance, pressure, number = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    rest = floats[number]
    for i in range(n):
        work[out + i] = work[conductance + i] * sqrt(max(work[pressure + i] - rest, 0.0))


@driver
def outlet_pressure(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Pressure above the return line, less that which the measured flow needs; `NOTHING` where the outlet is hardly open."""
    out, n, conductance, pressure, flow = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    first, number = ints[s + 5], ints[s + 6]
    rest, least = floats[number], floats[number + 1]
    for i in range(n):
        k, q = work[conductance + first + i], max(work[flow + first + i], 0.0)
        root = q / max(k, least)
        work[out + i] = work[pressure + first + i] - rest - root * root if k > least else NOTHING


@driver
def straight_volumes(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Volumes of both sides but for a constant, and levers, where these do not depend on the position; n rows each."""
    out, n, position, number = ints[s], ints[s + 1], ints[s + 2], ints[s + 3]
    a, b = floats[number], floats[number + 1]
    for i in range(n):
        work[out + i] = a * work[position + i]
        work[out + n + i] = -b * work[position + i]
        work[out + 2 * n + i] = a
        work[out + 3 * n + i] = b


@driver
def tabled_volumes(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """The same from tables of volumes and levers over equal steps of the position."""
    out, n, position, number, count = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    low, step = floats[number], floats[number + 1]
    for i in range(n):
        at = min(max((work[position + i] - low) / step, 0.0), float(count - 1))
        j = min(int(at), count - 2)
        share = at - float(j)
        for k in range(4):
            left = floats[number + 2 + k * count + j]
            work[out + k * n + i] = left + share * (floats[number + 3 + k * count + j] - left)


@driver
def difference(ints: np.ndarray, work: np.ndarray, s: int) -> None:
    """One signal less another, from a row on."""
    out, n, one, other, first = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for i in range(n):
        work[out + i] = work[one + first + i] - work[other + first + i]
