"""Logs of a system with memory, made here: what dynamic models are tried on."""

import numpy as np

from polydraulic.tables import Table


def memory_log(seed=0, n=600, gain=0.3, noise=0.003, raster=0.02, pause=True):
    """First order from the square of u, and z that follows y; a pause of 5 s after half of the rows."""
    rng = np.random.default_rng(seed)
    u, y, z = np.repeat(rng.uniform(-1.0, 1.0, size=n // 10), 10), np.zeros(n), np.zeros(n)
    for t in range(1, n):
        y[t] = 0.8 * y[t - 1] + gain * u[t - 1] ** 2
        z[t] = 0.5 * z[t - 1] + 0.4 * y[t - 1]
    y, z = (values + noise * rng.normal(size=n) for values in (y, z))
    time = raster * np.arange(n) + 5.0 * (pause & (np.arange(n) >= n // 2))
    return Table({"time": time, "u": u, "y": y, "z": z}, {"time": "s", "u": "V", "y": "Pa", "z": "m"})
