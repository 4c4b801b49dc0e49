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
    "p_pump": 1.0,
    "p_out": 1.0,
    "volume_a": 1e-9,
    "volume_b": 1e-9,
    "torque": 1e-3,
}
_FEW = 20  # residuals of a channel, below which nothing is learnt


def first_variances(residuals: Residuals, healthy: Case, noise: Mapping[str, float]) -> list[int]:
    """Steps of variances by the sensors' noise alone, infinite where a residual counts for nothing; where that of each channel begins.

    Parameters
    ----------
    residuals : Residuals
    healthy : Case
    noise : mapping from column to float
        Standard deviation of white noise, SI.
    """
    plan, own = residuals.plan, residuals.of(healthy)
    gain = float(np.sqrt((smoothing(SMOOTH) ** 2).sum()))
    found = []
    for channel in residuals.channels:
        what = channel.name.rpartition(".")[2]
        white = noise.get(channel.name, 0.0) ** 2 if what in ("spool", "q_in", "p_pump") else 0.0
        found.append(plan.filled(residuals.length(channel), "same_number", plan.numbers((white,))))
    for column in residuals.columns:
        what, sd = column.rpartition(".")[2], noise.get(column, 0.0)
        if sd == 0.0 or what in ("q_in", "p_pump", "angle", "position"):
            continue
        sd = sd * gain if what == "spool" else sd
        up, down = (residuals.of(case_of_shift(healthy, column, sign * _NEAR * sd)) for sign in (1.0, -1.0))
        for place, channel in enumerate(residuals.channels):
            kind = channel.name.rpartition(".")[2]
            if up[place] == own[place] or kind in ("spool", "torque"):
                continue
            share = 1.0 / _NEAR / (np.sqrt(residuals.shape.window) if kind.startswith("volume") else 1.0)
            n = residuals.length(channel)
            plan.step("add_moved", found[place], n, own[place], up[place], down[place], plan.numbers((share,)))
    for place, channel in enumerate(residuals.channels):
        name, _, what = channel.name.partition(".")
        if what == "torque":
            residuals.add_friction_unsure(found[place], channel, healthy)
        elif what.startswith("volume"):
            _add_noise_of_windows(residuals, found[place], healthy, name, what, noise, gain)
        n, mask = residuals.length(channel), residuals.counts(channel, healthy)
        least = plan.numbers((_LEAST[what] ** 2,))
        found[place] = plan.filled(n, "where_worth", found[place], own[place], mask, least)
    return found


def case_of_shift(healthy: Case, column: str, amount: float) -> Case:
    """The healthy machine with a sensor that reads too much."""
    return Case(healthy.machine, healthy.payload, {**healthy.shifts, column: amount}, healthy.mechanics)


def _add_noise_of_windows(
    residuals: Residuals, variance: int, healthy: Case, name: str, what: str, noise: Mapping[str, float], gain: float
) -> None:
    """Of balances of volume: noise of the position at both ends, of pressures through the compliance, and of measured flows."""
    shape, line = residuals.shape, healthy.machine.function(name).line
    position = max(noise.get(f"{name}.angle", 0.0), noise.get(f"{name}.position", 0.0)) * gain
    side = what[-1]
    compliance = (line.compliance_a if side == "a" else line.compliance_b) * noise.get(f"{name}.p_{side}", 0.0)
    flow = max(noise.get(f"{name}.q_in", 0.0), noise.get(f"{name}.q_out", 0.0))
    rest = 2.0 * (compliance / (shape.window * shape.raster)) ** 2 + flow**2 / shape.window
    residuals.add_window_noise(variance, name, healthy, position, rest)


def channel_scales(own: Sequence[np.ndarray], variances: Sequence[np.ndarray]) -> list[tuple[float, float]]:
    """What healthy blocks show of each channel beyond the noise of sensors: a variance to add, and a factor for residuals that go together.

    The variance is such that the middle half of the residuals is as wide as it should be; the factor compares means over blocks with it.

    Parameters
    ----------
    own, variances : sequence of (n_block, n_instant) array
        Residuals, and variances by the noise of sensors, of each channel.
    """
    found = []
    for r, variance in zip(own, variances, strict=True):
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
