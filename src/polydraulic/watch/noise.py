"""Variance of every residual: noise of its sensors through the equations, and what healthy blocks show beyond it."""

from collections.abc import Mapping, Sequence

import numpy as np

from polydraulic.watch.blocks import SMOOTH, smoothing
from polydraulic.watch.residuals import Case, Residuals

_NEAR = 2.0  # standard deviations by which a sensor is moved to see what its noise does
_NORMAL = 0.6745  # median of the absolute value of a standard normal variable
# SI, if nothing is noisy
_LEAST = {
    "spool": 1e-8,
    "q_in": 1e-9,
    "p_out": 1.0,
    "volume_a": 1e-9,
    "volume_b": 1e-9,
    "torque": 1e-3,
}
_FEW = 20  # residuals of a channel, below which nothing is learnt


def first_variances(residuals: Residuals, healthy: Case, noise: Mapping[str, float]) -> list[np.ndarray]:
    """Variances by the sensors' noise alone, infinite where a residual counts for nothing; (n_block, n_instant) each.

    Parameters
    ----------
    residuals : Residuals
    healthy : Case
    noise : mapping from column to float
        Standard deviation of white noise, SI.
    """
    own, counts = residuals.of(healthy), residuals.counts(healthy)
    gain = float(np.sqrt((smoothing(SMOOTH) ** 2).sum()))
    whole: list[np.ndarray] = [np.zeros_like(r) for r in own]
    for column in residuals.readings:
        what, sd = column.rpartition(".")[2], noise.get(column, 0.0)
        if sd == 0.0 or what in ("q_in", "angle", "position"):
            continue
        sd = sd * gain if what == "spool" else sd
        both = [residuals.of(case_of_shift(healthy, column, sign * _NEAR * sd)) for sign in (1.0, -1.0)]
        for place, channel in enumerate(residuals.channels):
            kind = channel.name.rpartition(".")[2]
            if both[0][place] is own[place] or kind in ("spool", "torque"):
                continue
            off = np.maximum(*(np.abs(r[place] - own[place]) for r in both)) / _NEAR
            whole[place] += np.nan_to_num(off) ** 2 / (residuals.shape.window if kind.startswith("volume") else 1.0)
    found = []
    for place, channel in enumerate(residuals.channels):
        name, _, what = channel.name.partition(".")
        variance = whole[place]
        if what in ("spool", "q_in"):
            variance = variance + noise.get(channel.name, 0.0) ** 2
        elif what == "torque":
            variance = variance + residuals.friction_unsure(channel, healthy) ** 2
        elif what.startswith("volume"):
            variance = variance + _of_windows(residuals, healthy, name, what, noise, gain)
        fine = counts[place] & np.isfinite(own[place]) & np.isfinite(variance)
        found.append(np.where(fine, variance + _LEAST[what] ** 2, np.inf))
    return found


def case_of_shift(healthy: Case, column: str, amount: float) -> Case:
    """The healthy machine with a sensor that reads too much."""
    return Case(healthy.machine, healthy.payload, {**healthy.shifts, column: amount}, healthy.mechanics)


def _of_windows(
    residuals: Residuals, healthy: Case, name: str, what: str, noise: Mapping[str, float], gain: float
) -> np.ndarray:
    """Of balances of volume: noise of the position at both ends, of pressures through the compliance, and of measured flows."""
    shape, line = residuals.shape, healthy.machine.function(name).line
    seconds = shape.window * shape.raster
    lever = residuals.lever(name, healthy)  # at the beginning of each window
    position = max(noise.get(f"{name}.angle", 0.0), noise.get(f"{name}.position", 0.0)) * gain * lever
    side = what[-1]
    compliance = (line.compliance_a if side == "a" else line.compliance_b) * noise.get(f"{name}.p_{side}", 0.0)
    flow = max(noise.get(f"{name}.q_in", 0.0), noise.get(f"{name}.q_out", 0.0))
    return np.asarray(2.0 * (position**2 + compliance**2) / seconds**2 + flow**2 / shape.window)


def channel_scales(residuals: Residuals, healthy: Case, variances: Sequence[np.ndarray]) -> list[tuple[float, float]]:
    """What healthy blocks show of each channel beyond the noise of sensors: a variance to add, and a factor for residuals that go together.

    The variance is such that the middle half of the residuals is as wide as it should be; the factor compares means over blocks with it.
    """
    found = []
    for r, variance in zip(residuals.of(healthy), variances, strict=True):
        fine = np.isfinite(r) & np.isfinite(variance)
        if fine.sum() < _FEW:
            found.append((0.0, 1.0))
            continue
        more = _added(r[fine], variance[fine])
        z = np.where(fine, r / np.sqrt(np.where(fine, variance, 1.0) + more), 0.0)
        count = fine.sum(axis=1)
        z -= np.where(fine, np.median(z[fine]), 0.0)
        sums = z.sum(axis=1)[count > 1] / np.sqrt(count[count > 1])
        together = (float(np.median(np.abs(sums))) / _NORMAL) ** 2 if len(sums) else 1.0
        found.append((more, max(together, 1.0)))
    return found


def _added(r: np.ndarray, variance: np.ndarray) -> float:
    """Variance to add so that the median of |r| / sd is that of a normal variable."""
    low, high = 0.0, float(np.median(r * r)) / _NORMAL**2 + 1e-300
    off = r - np.median(r)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if np.median(np.abs(off) / np.sqrt(variance + middle)) > _NORMAL:
            low = middle
        else:
            high = middle
    return high


def whole_variances(
    residuals: Residuals, healthy: Case, noise: Mapping[str, float], scales: Sequence[tuple[float, float]]
) -> list[np.ndarray]:
    """Variances as healthy blocks showed them."""
    first = first_variances(residuals, healthy, noise)
    return [(v + more) * together for v, (more, together) in zip(first, scales, strict=True)]
