"""A log that we make ourselves: two joints behind dead zone, dead time and lag, which share a pump, as coarse sensors read them."""

import numpy as np

from polydraulic.tables import Table

RASTER = 0.05
DEAD_TIME, LAG = 2, 1.5  # rows
EDGES = ((0.3, -0.2), (0.25, -0.35))  # of both dead zones
FULL = 0.8


def joint_log(n=3000, seed=0, *, stop=1.2, noise=0.003, gap=True, speed=1.0):
    """Two levers and two joints; the first one meets a stop at `stop`. They go at `speed` of their usual one."""
    rng = np.random.default_rng(seed)
    levers = np.stack([_lever(rng, n) for _ in range(2)])
    moved, place, joints = np.zeros(2), np.zeros(2), np.zeros((2, n))
    for t in range(1, n):
        delayed = levers[:, t - DEAD_TIME] if t >= DEAD_TIME else np.zeros(2)
        moved = moved + (1.0 - np.exp(-1.0 / LAG)) * (delayed - moved)
        open_ = [_opening(x, *edges) for x, edges in zip(moved, EDGES, strict=True)]
        share = 1.0 - 0.3 * abs(open_[1]), 1.0 - 0.2 * abs(open_[0])
        rate = 0.05 * open_[0] * share[0] * (1.0 + 0.2 * place[0]), 0.04 * open_[1] * share[1] * (1.0 - 0.3 * place[0])
        place = np.clip(place + speed * np.array(rate), [-1.5, -2.0], [stop, 2.0])
        joints[:, t] = place
    read = 0.002 * np.round((joints + rng.normal(scale=noise, size=joints.shape)) / 0.002)
    time = RASTER * np.arange(n)
    time[n // 3 :] += 7.0 * gap
    columns = {"time": time, "lever.a": levers[0], "lever.b": levers[1], "a": read[0], "b": read[1]}
    units = {"time": "s", "lever.a": "V", "lever.b": "V", "a": "rad", "b": "m"}
    return Table(columns, units)


def _lever(rng, n):
    """Pushes of half a second to two seconds with rests between them, to and fro."""
    found, sign = [], 1.0
    while len(found) < n:
        sign = -sign if rng.uniform() < 0.8 else sign
        size = sign * rng.uniform(0.1, 1.0)
        found += [size] * int(rng.integers(10, 40)) + [0.0] * int(rng.integers(4, 20))
    return np.array(found[:n])


def _opening(x, high, low):
    return min(max(x - high, 0.0) / (FULL - high), 1.0) - min(max(low - x, 0.0) / (FULL + low), 1.0)
