"""Spool that a pilot drives, and the spool without the noise of its sensor.

Voltage and jets alone drive it through each piece of a log, and it may lag behind by half of a hysteresis either way, as in a simulation. A smoother
(Rauch, Tung and Striebel) then weighs this spool against the sensor: what the spool does besides is noise that drives it, of the size that the log shows.
"""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.identification.log_pieces import raster_within
from polydraulic.machine.play import followed
from polydraulic.parameters.schema import Pilot

# what drives the spool besides the pilot, as a share of the sensor's noise in a row
_ROUGHNESS = np.geomspace(1e-3, 1.0, 25)


class SpoolEffects(NamedTuple):
    """What keeps a spool from where its pilot drives it.

    Attributes
    ----------
    hysteresis : float, m
    shift : float, m/(m3/s Pa^0.5)
        Towards the centre, for each unit of its jets (`prepare_shift`).
    """

    hysteresis: float = 0.0
    shift: float = 0.0


NONE = SpoolEffects()


def pieces_of(segment: np.ndarray) -> np.ndarray:
    """First row of each piece, and the row behind its last one, (n_piece, 2)."""
    cuts = np.flatnonzero(np.diff(segment)) + 1
    return np.column_stack([np.concatenate([[0], cuts]), np.concatenate([cuts, [len(segment)]])]).astype(np.int64)


def driven_spool(
    pilot: Pilot,
    travel: float,
    time: np.ndarray,
    pieces: np.ndarray,
    voltage: np.ndarray,
    spool: np.ndarray,
    step: float,
    effects: SpoolEffects = NONE,
    jets: np.ndarray | None = None,
) -> np.ndarray:
    """Spool that voltage and jets alone drive through each piece from where it is measured at first, (n_row,) in m."""
    keep, pushed = _pushed(pilot, travel, time, pieces, voltage, step)
    found, back = np.empty(len(spool)), np.zeros(len(spool))
    if jets is not None:
        back = effects.shift * jets
    target = np.clip(pilot.gain * voltage, -travel, travel)
    _run(pieces, pushed, spool, target, back, keep, 0.5 * effects.hysteresis, found)
    return found


def smooth_spool(
    pilot: Pilot,
    travel: float,
    time: np.ndarray,
    segment: np.ndarray,
    voltage: np.ndarray,
    spool: np.ndarray,
    noise: float,
    effects: SpoolEffects = NONE,
    jets: np.ndarray | None = None,
) -> tuple[np.ndarray, float]:
    """Spool, (n_row,) in m, from pilot and sensor together, and the standard deviation of what it is off by."""
    pieces, step = pieces_of(segment), raster_within(time, segment)
    keep, pushed = _pushed(pilot, travel, time, pieces, voltage, step)
    if effects != NONE:
        driven = driven_spool(pilot, travel, time, pieces, voltage, spool, step, effects, jets)
        pushed = driven - keep * np.concatenate([driven[:1], driven[:-1]])
    found, work = np.empty(len(spool)), np.empty((len(spool), 3))
    r = max(noise, 1e-9) ** 2
    likely = [_smoothed(pieces, pushed, spool, keep, r * share * share, r, found, work)[0] for share in _ROUGHNESS]
    best = _ROUGHNESS[int(np.argmax(likely))]
    _, variance = _smoothed(pieces, pushed, spool, keep, r * best * best, r, found, work)
    return found, float(np.sqrt(variance))


def _pushed(
    pilot: Pilot, travel: float, time: np.ndarray, pieces: np.ndarray, voltage: np.ndarray, step: float
) -> tuple[float, np.ndarray]:
    """What a row keeps of the spool before, and what the voltage adds to that since, (n_row,) in m.

    The voltage is straight between rows, so that after a dead time it bends between rows, too.
    """
    rows = int(pilot.dead_time / step)
    late = max(pilot.dead_time - rows * step, 0.0)
    keep, first, second = _weights(pilot.time_constant, late)
    keep_on, first_on, second_on = _weights(pilot.time_constant, step - late)
    pushed = np.empty(len(voltage))
    weights = keep_on * first, keep_on * second + first_on, second_on
    _push(pieces, time, voltage, pilot.gain, travel, pilot.dead_time, rows, *weights, pushed)
    return keep * keep_on, pushed


def _weights(time_constant: float, step: float) -> tuple[float, float, float]:
    """What is kept over a time of the spool, and taken of the target at its begin and end, which is straight between them."""
    if step < 1e-9:
        return 1.0, 0.0, 0.0
    keep = float(np.exp(-step / time_constant))
    second = 1.0 - (1.0 - keep) * time_constant / step
    return keep, 1.0 - keep - second, second


@driver
def _push(
    pieces: np.ndarray, time: np.ndarray, voltage: np.ndarray, gain: float, travel: float, dead_time: float, rows: int, of_last: float, of_bend: float,
    of_own: float, pushed: np.ndarray,
) -> None:  # fmt: skip
    """What the targets of the row before, of the row since which a dead time bends the voltage, and of a row itself add to the spool."""
    for piece in range(pieces.shape[0]):
        begin, end = pieces[piece, 0], pieces[piece, 1]
        last, left = 0.0, begin
        for k in range(begin, end):
            here, at = voltage[k], time[k] - dead_time
            if at < time[begin] or k == begin:
                here = voltage[begin]
            elif dead_time > 0.0:
                while left + 1 < k and time[left + 1] <= at:
                    left += 1
                here = voltage[left] + (voltage[left + 1] - voltage[left]) / (time[left + 1] - time[left]) * (
                    at - time[left]
                )
            target = min(max(gain * here, -travel), travel)
            bent = min(max(gain * voltage[max(k - rows - 1, begin)], -travel), travel)
            pushed[k] = of_last * last + of_bend * bent + of_own * target
            last = target


@driver
def _run(
    pieces: np.ndarray,
    pushed: np.ndarray,
    spool: np.ndarray,
    target: np.ndarray,
    back: np.ndarray,
    keep: float,
    half: float,
    found: np.ndarray,
) -> None:
    """Driver x and the spool s that lags behind it; `back` shifts the target towards the centre, up to which a spool goes."""
    for piece in range(pieces.shape[0]):
        begin, end = pieces[piece, 0], pieces[piece, 1]
        s = spool[begin]
        x = followed(target[begin], s, half)  # as if the pilot had settled
        found[begin] = s
        for k in range(begin + 1, end):
            x = keep * x + pushed[k]
            less = min((1.0 - keep) * 0.5 * (back[k - 1] + back[k]), abs(x))
            x = x - less if x >= 0.0 else x + less
            s = followed(s, x, half)
            found[k] = s


@driver
def _smoothed(
    pieces: np.ndarray,
    pushed: np.ndarray,
    spool: np.ndarray,
    keep: float,
    q: float,
    r: float,
    found: np.ndarray,
    work: np.ndarray,
) -> tuple[float, float]:
    """Forwards a Kalman filter, backwards the smoother; log likelihood and mean variance."""
    likely, total, rows = 0.0, 0.0, 0
    for piece in range(pieces.shape[0]):
        begin, end = pieces[piece, 0], pieces[piece, 1]
        x, p = spool[begin], r
        found[begin] = x
        work[begin, 0], work[begin, 1], work[begin, 2] = p, x, p
        for k in range(begin + 1, end):
            ahead = keep * x + pushed[k]
            before = keep * keep * p + q
            s = before + r
            off = spool[k] - ahead
            likely -= 0.5 * (np.log(s) + off * off / s)
            x = ahead + before / s * off
            p = before * r / s
            found[k] = x
            work[k, 0], work[k, 1], work[k, 2] = p, ahead, before
        total += p
        rows += 1
        variance = p
        for back in range(end - begin - 1):
            k = end - 2 - back
            c = work[k, 0] * keep / work[k + 1, 2]
            found[k] += c * (found[k + 1] - work[k + 1, 1])
            variance = work[k, 0] + c * c * (variance - work[k + 1, 2])
            total += variance
            rows += 1
    return likely, total / max(rows, 1)
