"""Relief setting of a pump, from rows in which actuators stall with open valves.

What is fitted to flows alone would follow the noise of the pressure there, at which a flow falls from all to nothing. A port has the pump's
pressure where nothing flows between the two: what passes a valve loses pressure at the bypasses before it.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import CircuitModel, CircuitRows

_LEAST_ROWS, _BLOCKS = 200, 3
_STILL, _FLOWS, _HIGHEST = 0.02, 0.05, 10  # of the pump's flow, and how many pressures with a flow are left to noise
_OPEN = 1.2  # of the travel at which a valve opens
_DROP = 0.1  # standard deviations of pressure that what may still flow loses at most before a valve
_KNOWN = 0.01  # relative standard error beyond which a relief setting counts as not shown
_GAP = 0.02  # of the setting, from where oil still flows, beyond which nothing says that the pump has reached it
_NEAR = 10.0  # times the noise of pressure: what is further from where most stalled rows are says nothing
_STRAY = 1e-2  # share of rows of any pressure
_SHORTEST = 10.0  # standard deviations over the mean excess: a shorter one does not show
_CELL = 0.05  # standard deviations
_DIFFERENCE = 1e-3


class _Setting(NamedTuple):
    value: float  # Pa
    sd: float  # Pa


def seen_relief(model: CircuitModel, rows: CircuitRows, opens: np.ndarray, spread: float) -> tuple[float, float] | None:
    """Pressure at which actuators stall with open valves, and its standard error, Pa; None where the log hardly has it.

    Parameters
    ----------
    model : CircuitModel
        Its bypasses say where a valve lets nothing pass, and its pump where to look.
    rows : CircuitRows
    opens : (n,) array, m
        Travels at which the valves open.
    spread : float, Pa
        How far the pump's relief setting may be off.
    """
    still = stalled(model, rows, opens)
    pressure, block = rows.p_in.mean(axis=1)[still], rows.block[np.nonzero(still)[0]]
    near = np.abs(pressure - model.pump.relief) < 3.0 * spread
    pressure, block = pressure[near], block[near]
    if len(pressure) < _LEAST_ROWS:
        return None
    # a load may push the pressure above the setting: what counts is where most stalled rows are
    width = float(rows.noise_pressure.max())
    ordered = np.sort(pressure)
    within = np.searchsorted(ordered, ordered + 2.0 * width, side="right") - np.arange(len(ordered))
    densest = int(np.argmax(within))
    there = np.abs(pressure - ordered[densest] - width) < _NEAR * width
    blocks_there = np.unique(block[there])
    if np.count_nonzero(there) < _LEAST_ROWS or len(blocks_there) < _BLOCKS:
        return None
    # nobody knows how loads push: most rows by little, or hardly any by nothing
    one, other = (_least_pressure(pressure[there], block[there], width, humped) for humped in (False, True))
    value = 0.5 * (one.value + other.value)
    # a load that holds an actuator above the setting stalls it too: the setting may be anywhere between that and where oil still flows
    flowing = rows.known & (rows.travel.min(axis=1) > _OPEN * opens) & (rows.q_in > _FLOWS * model.pump.flow)
    below = np.sort(rows.p_in.mean(axis=1)[flowing])[-_HIGHEST:]
    gap = max(value - float(below[0]), 0.0) if len(below) == _HIGHEST else np.inf
    if gap > _GAP * value:
        return None
    parts = 0.5 * (one.sd + other.sd), 0.5 * (one.value - other.value), width / np.sqrt(len(blocks_there))
    error = float(np.linalg.norm([*parts, gap / np.sqrt(12.0)]))
    return (value, error) if error < _KNOWN * value else None


def stalled(model: CircuitModel, rows: CircuitRows, opens: np.ndarray) -> np.ndarray:
    """Rows in which the port of an open valve has the pump's pressure and takes no flow, (n_window, n).

    Nothing flows on from there, since one of the bypasses from it on is shut and no actuator before that takes anything; and the bypasses
    before it are so wide that what may flow unseen loses hardly any pressure.
    """
    unseen = _STILL * model.pump.flow
    wide = unseen / np.sqrt(_DROP * float(rows.noise_pressure.max()))
    least, most = rows.travel.min(axis=1), rows.travel.max(axis=1)
    still = rows.known & (np.abs(rows.q_in) < unseen)
    before = np.ones(len(still), dtype=bool)
    clear, ends = np.empty_like(still), np.empty_like(still)
    for k, v in enumerate(model.valves):
        clear[:, k] = before
        before = before & (np.interp(most[:, k], v.knots, v.bypass) > wide)
        ends[:, k] = np.interp(least[:, k], v.knots, v.bypass) <= 0.0
    onward = np.zeros(len(still), dtype=bool)
    for k in reversed(range(len(model.valves))):
        onward = still[:, k] & (ends[:, k] | onward)
        ends[:, k] = onward
    return np.asarray(ends & clear & (least > _OPEN * opens))


def _least_pressure(pressure: np.ndarray, block: np.ndarray, noise: float, humped: bool) -> _Setting:
    """Setting below which no stalled row is but by noise, and its standard error by blocks of time.

    Loads push the pressure of rows above it: by an exponential distribution or, `humped`, by the sum of two such, whose mean is found
    together with the setting.
    """
    from scipy.optimize import minimize

    middle = float(np.median(pressure))
    z = (pressure - middle) / noise
    cells, counts = np.unique(np.round(z / _CELL), return_counts=True)

    def likely(x: np.ndarray, at: np.ndarray) -> np.ndarray:
        return _log_density(at - x[0], min(float(np.exp(x[1])), _SHORTEST), humped)

    starts = [np.array([place, rate]) for place in (-1.0, 0.0) for rate in (-0.5, 1.0)]
    found = [
        minimize(
            lambda x: -float(counts @ likely(x, _CELL * cells)), start, method="Nelder-Mead", options={"maxiter": 200}
        )
        for start in starts
    ]
    best = min(found, key=lambda one: float(one.fun)).x
    steps = _DIFFERENCE * np.eye(2)
    scores = np.column_stack(
        [(likely(best + step, z) - likely(best - step, z)) / (2.0 * _DIFFERENCE) for step in steps]
    )
    _, own = np.unique(block, return_inverse=True)
    pulls = np.zeros((own.max() + 1, 2))
    np.add.at(pulls, own, scores)
    bread = np.linalg.pinv(scores.T @ scores)
    covariance = bread @ (pulls.T @ pulls) @ bread * len(pulls) / (len(pulls) - 1)
    return _Setting(middle + noise * float(best[0]), noise * float(np.sqrt(covariance[0, 0])))


def _log_density(above: np.ndarray, rate: float, humped: bool) -> np.ndarray:
    """Of normal noise and what a load adds, both in standard deviations of the noise, with a few strays."""
    from scipy.special import log_ndtr, ndtr

    late = above - rate
    if humped:
        # rate squared times an excess, of which noise leaves the mean of what is positive; for rounding far below the setting never negative
        excess = np.maximum(late * ndtr(late) + np.exp(-0.5 * late * late) / np.sqrt(2.0 * np.pi), 0.0)
        own = rate**2 * np.exp(np.minimum(-rate * above + 0.5 * rate**2, 600.0)) * excess
    else:
        own = rate * np.exp(-rate * above + 0.5 * rate**2 + log_ndtr(late))
    return np.asarray(np.log((1.0 - _STRAY) * own + _STRAY / (2.0 * _NEAR)))
