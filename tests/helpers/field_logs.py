"""Logs of valves and pumps with what a static model does not know: play, lag, noise with a memory."""

import numpy as np

RASTER = 0.01
BLOCKS = 12  # of a log, every fourth of which is held out: 5 s of a minute


def walk(rng, n, every, low, high):
    """Straight lines between random values, one each `every` s; (n,) array."""
    time, knots = RASTER * np.arange(n), np.arange(0.0, RASTER * n + every, every)
    return np.interp(time, knots, rng.uniform(low, high, knots.size))


def valve_log(seed, n=6000, play=0.25, noise=0.6, sine=True):
    """Command (%), supply and load pressure (bar), and flow (l/min) of a spool with play (mm)."""
    rng = np.random.default_rng(seed)
    time = RASTER * np.arange(n)
    command = 0.9 * np.sin(2.0 * np.pi * time / 12.0 + seed) if sine else walk(rng, n, 1.5, -1.0, 1.0)
    spool = np.zeros(n)
    for k in range(1, n):
        spool[k] = min(max(spool[k - 1], 10.0 * command[k] - play), 10.0 * command[k] + play)
    supply, load = walk(rng, n, 3.0, 60.0, 280.0), walk(rng, n, 2.0, 5.0, 55.0)
    opening = np.sign(spool) * np.interp(np.abs(spool), [0.0, 1.5, 4.0, 10.0], [0.0, 0.0, 2.0, 9.0])
    flow = opening * np.sqrt(np.maximum(supply - load, 0.0))
    X = np.column_stack([100.0 * command, supply, load]) + rng.normal(0.0, (0.05, 0.4, 0.4), (n, 3))
    return X, flow + noise * rng.normal(size=n)


def pump_log(seed, n=6000, noise=0.8):
    """Swash command (%), speed (1/min), pressure (bar), temperature (degC), and flow (l/min) of a pump that lags behind."""
    rng = np.random.default_rng(seed)
    command, speed, pressure = (
        walk(rng, n, *ends) for ends in ((2.5, 0.1, 1.0), (6.0, 900.0, 2100.0), (1.7, 20.0, 320.0))
    )
    warm = 40.0 + 20.0 * np.arange(n) / n
    swash, error = np.zeros(n), np.zeros(n)
    for k in range(1, n):
        swash[k] = swash[k - 1] + 0.03 * (command[k] - swash[k - 1])
        error[k] = 0.9 * error[k - 1] + noise * rng.normal()
    leak = 0.012 * pressure * (1.0 + 0.02 * (warm - 40.0))
    flow = np.minimum(0.1 * speed * swash - leak, 28000.0 / pressure)
    X = np.column_stack([100.0 * command, speed, pressure, warm]) + rng.normal(0.0, (0.3, 4.0, 1.0, 0.2), (n, 4))
    return X, flow + error


FIELD_LOGS = {
    "valve": valve_log,
    "valve with coarse play": lambda seed: valve_log(seed, play=0.6, noise=1.5, sine=False),
    "valve, short": lambda seed: valve_log(seed, n=3000, sine=False),
    "valve without play": lambda seed: valve_log(seed, play=0.0, sine=False),
    "pump": pump_log,
    "pump, short and noisy": lambda seed: pump_log(seed, n=3000, noise=2.5),
}


def held_out(n):
    """Which rows are held out, (n,) array of bool."""
    return np.arange(n) * BLOCKS // n % 4 == 3
