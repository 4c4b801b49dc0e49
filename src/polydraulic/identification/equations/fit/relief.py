"""Relief setting of a pump, from rows in which actuators stall with open valves.

What is fitted to flows alone would follow the noise of the pressure there, at which a flow falls from all to nothing.
"""

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import CircuitModel, CircuitRows

_LEAST_ROWS, _BLOCKS = 200, 3
_FLOWS, _HIGHEST = 0.05, 10  # of the pump's flow, and how many such pressures are left to noise
_KNOWN = 0.01  # relative standard error beyond which a relief setting counts as not shown
_NEAR = 10.0  # times the noise of pressure: what is further from where most stalled rows are says nothing
_STRAY = 1e-2  # share of rows of any pressure
_SHORTEST = 10.0  # standard deviations over the mean excess: a shorter one does not show
_DIFFERENCE = 1e-3


def seen_relief(model: CircuitModel, rows: CircuitRows, opens: np.ndarray, spread: float) -> tuple[float, float] | None:
    """Pressure at which actuators stall with open valves, and its standard error, Pa; None where the log hardly has it."""
    pressures, blocks = [], []
    for k, shut in enumerate(opens.tolist()):
        still = (
            rows.known[:, k]
            & (rows.travel[:, :, k].min(axis=1) > 1.2 * shut)
            & (np.abs(rows.q_in[:, k]) < 0.02 * model.pump.flow)
        )
        pressures.append(rows.p_in[still, :, k].mean(axis=1))
        blocks.append(rows.block[still])
    pressure, block = np.concatenate(pressures), np.concatenate(blocks)
    near = np.abs(pressure - model.pump.relief) < 3.0 * spread
    pressure, block = pressure[near], block[near]
    if len(pressure) < _LEAST_ROWS:
        return None
    # a load may push the pressure above the setting: what counts is where most stalled rows are
    width = float(rows.noise_pressure.max())
    ordered = np.sort(pressure)
    within = np.searchsorted(ordered, ordered + 2.0 * width, side="right") - np.arange(len(ordered))
    densest = int(np.argmax(within))
    stalled = np.abs(pressure - ordered[densest] - width) < _NEAR * width
    blocks_there = np.unique(block[stalled])
    if np.count_nonzero(stalled) < _LEAST_ROWS or len(blocks_there) < _BLOCKS:
        return None
    value, sd = _least_pressure(pressure[stalled], block[stalled], width)
    # a load that holds an actuator above the setting stalls it too: the setting lies between that and where oil still flows
    flowing = rows.known & (rows.travel.min(axis=1) > 1.2 * opens) & (rows.q_in > _FLOWS * model.pump.flow)
    below = np.sort(rows.p_in.mean(axis=1)[flowing])[-_HIGHEST:]
    gap = max(value - float(below[0]), 0.0) if len(below) == _HIGHEST else np.inf
    error = float(np.hypot(np.hypot(sd, width / np.sqrt(len(blocks_there))), 0.5 * gap))
    return (value, error) if error < _KNOWN * value else None


def _least_pressure(pressure: np.ndarray, block: np.ndarray, noise: float) -> tuple[float, float]:
    """Setting below which no stalled row is but by noise, and its standard error by blocks of time, Pa.

    Loads push the pressure of some rows above it: by an exponential distribution, whose mean is found together with the setting.
    """
    from scipy.optimize import minimize

    middle = float(np.median(pressure))
    z = (pressure - middle) / noise

    def likely(x: np.ndarray) -> np.ndarray:
        return _log_density(z - x[0], min(float(np.exp(x[1])), _SHORTEST))

    starts = [np.array([place, rate]) for place in (-1.0, 0.0) for rate in (-0.5, 1.0)]
    found = [
        minimize(lambda x: -float(likely(x).sum()), start, method="Nelder-Mead", options={"maxiter": 200})
        for start in starts
    ]
    best = min(found, key=lambda one: float(one.fun)).x
    steps = _DIFFERENCE * np.eye(2)
    scores = np.column_stack([(likely(best + step) - likely(best - step)) / (2.0 * _DIFFERENCE) for step in steps])
    _, own = np.unique(block, return_inverse=True)
    pulls = np.zeros((own.max() + 1, 2))
    np.add.at(pulls, own, scores)
    bread = np.linalg.pinv(scores.T @ scores)
    covariance = bread @ (pulls.T @ pulls) @ bread * len(pulls) / (len(pulls) - 1)
    return middle + noise * float(best[0]), noise * float(np.sqrt(covariance[0, 0]))


def _log_density(above: np.ndarray, rate: float) -> np.ndarray:
    """Of normal noise and what a load adds, both in standard deviations of the noise, with a few strays."""
    from scipy.special import log_ndtr

    own = np.log(rate) - rate * above + 0.5 * rate**2 + log_ndtr(above - rate)
    return np.asarray(np.log((1.0 - _STRAY) * np.exp(own) + _STRAY / (2.0 * _NEAR)))
