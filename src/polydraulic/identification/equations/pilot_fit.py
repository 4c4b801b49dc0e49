"""A pilot from the joystick's voltage and the spool that follows it, and the spool without the noise of its sensor.

The pilot is tau dx/dt + x = clip(gain v, +-travel) after a dead time. Gain, time constant and dead time are those whose spool, run through
each piece of the log on the voltage alone, is nearest to the measured one. Where jets are known, they may shift the target towards the centre, and
the measured spool may lag behind x by half of a hysteresis either way, as in a simulation. A smoother (Rauch, Tung and Striebel) then weighs this spool
against the sensor: what the spool does besides is noise that drives it, of the size that the log shows.
"""

from collections.abc import Container
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.identification.log_pieces import raster_within
from polydraulic.identification.noise import noise_level
from polydraulic.machine.play import followed
from polydraulic.parameters.schema import Pilot

_SETTLED = 3.0  # time constants after the start of a piece, from which on the measured start does not matter
_LONGEST_DEAD = 0.5  # s
# standard errors and s, below which a dead time counts as none: what lies between rows is not known better; so does a gain of as few errors
_SURE, _LEAST_DEAD = 3.0, 1e-3
_LEAST_ROWS = 200
_FOLLOWS = 0.3  # of how much a spool varies, which a pilot that it follows leaves at most
_BLOCK = 5.0  # s, after which errors are independent
# what drives the spool besides the pilot, as a share of the sensor's noise in a row
_ROUGHNESS = np.geomspace(1e-3, 1.0, 25)
_SMALL = 0.01  # of what is unsure of jets, around which the spool is linear in it
_LITTLE, _MOST = 0.01, 100.0  # of the travel: an effect that counts as one, and how many of these it may be


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


class Jets(NamedTuple):
    """Jets of one valve, conductance times drop at its inlet and outlet.

    Attributes
    ----------
    strength : (n_row,) array, m3/s Pa^0.5
        NaN in rows in which a sensor of the circuit is silent.
    unsure : (n_number, n_row) array
        What a standard error of each conductance at a knot that was found makes of it.
    noise : (n_row,) array
        What noise as that of the sensors would make of it, once more.
    """

    strength: np.ndarray
    unsure: np.ndarray
    noise: np.ndarray

    def at(self, rows: np.ndarray) -> "Jets":
        """Those rows, an array of bool."""
        return Jets(self.strength[rows], self.unsure[:, rows], self.noise[rows])


class PilotFit(NamedTuple):
    """A pilot and how well the log knows it.

    Attributes
    ----------
    pilot : Pilot
    errors : Pilot
        Standard errors of its numbers.
    rms : float, m
        Of what is left of the spool.
    rows : int
        That say something.
    effects, effect_errors : SpoolEffects
        What the spool does besides, and standard errors of it.
    """

    pilot: Pilot
    errors: Pilot
    rms: float
    rows: int
    effects: SpoolEffects = NONE
    effect_errors: SpoolEffects = NONE


def fit_pilot(
    time: np.ndarray, segment: np.ndarray, voltage: np.ndarray, spool: np.ndarray, travel: float, start: Pilot,
    effects: SpoolEffects = NONE, jets: Jets | None = None, free: Container[str] = (),
) -> PilotFit | None:  # fmt: skip
    """Pilot whose spool is nearest to the measured one; None where the log does not tell.

    Parameters
    ----------
    time : (n_row,) array, s
        On a raster within each segment.
    segment : (n_row,) array
    voltage : (n_row,) array, V
    spool : (n_row,) array, m
    travel : float, m
        Beyond which the spool does not go.
    start : Pilot
        To begin from.
    effects : SpoolEffects
        What the spool is known to do besides.
    jets : Jets, optional
        None if not given.
    free : container of str
        Which of the effects are to be found as well.
    """
    from scipy.optimize import least_squares

    pieces = pieces_of(segment)
    step = raster_within(time, segment)
    lag0 = max(start.time_constant, step)
    begins = np.repeat(time[pieces[:, 0]], pieces[:, 1] - pieces[:, 0])
    use = time - begins > _SETTLED * lag0
    moving = use & (np.abs(voltage) > 0.05 * np.abs(voltage).max(initial=1e-300))
    if moving.sum() < _LEAST_ROWS or np.ptp(spool[use]) < 20.0 * step * 1e-6:
        return None
    strength = None if jets is None else jets.strength
    strong = 1.0 if strength is None else float(np.quantile(strength, 0.99)) or 1.0
    keys = [key for key in SpoolEffects._fields if key in free]
    # of each effect: what counts as one, the least, and what to begin from
    usual = {"hysteresis": (_LITTLE * travel, 0.0, 1.0), "shift": (_LITTLE * travel / strong, -_MOST, 0.0)}
    more = np.array([usual[key] for key in keys]).reshape(-1, 3).T
    scale = np.array([start.gain, lag0, 0.05, *more[0]])

    def off(x: np.ndarray, jets: np.ndarray | None) -> np.ndarray:
        pilot, does = numbers(x)
        return (driven_spool(pilot, travel, time, pieces, voltage, spool, step, does, jets) - spool)[use]

    def numbers(x: np.ndarray) -> tuple[Pilot, SpoolEffects]:
        values = (x * scale).tolist()
        return Pilot(*values[:3]), effects._replace(**dict(zip(keys, values[3:], strict=True)))

    low = np.array([1e-3, 0.1 * step / lag0, 0.0, *more[1]])
    high = np.array([1e3, 100.0, _LONGEST_DEAD / scale[2], *np.full(len(keys), _MOST)])
    begin = np.clip(
        [
            _first_gain(voltage[use], spool[use], travel) / start.gain,
            1.0,
            0.5 * start.dead_time / scale[2] + 0.1,
            *more[2],
        ],
        low + 0.01 * np.abs(low),
        high * 0.99,
    )
    found = least_squares(
        off,
        begin,
        bounds=(low, high),
        loss="soft_l1",
        f_scale=3.0 * max(noise_level(spool, segment), 1e-7),
        max_nfev=60,
        args=(strength,),
    )
    scatter = _errors(found.jac, found.fun, (time[use] // _BLOCK).astype(np.int64))
    pilot, does = numbers(found.x)
    errors = scale * scatter
    if jets is not None and does.shift:
        bread = np.linalg.pinv(found.jac)
        parts = [(jets.noise, 1.0), *((part, _SMALL) for part in jets.unsure)]
        moved = [bread @ (off(found.x, jets.strength + by * part) - found.fun) / by for part, by in parts]
        errors = scale * np.linalg.norm([scatter, *moved], axis=0)
    if not pilot.gain > _SURE * errors[0]:  # as of a voltage of the wrong sign, against which the spool goes
        return None
    return PilotFit(
        pilot,
        Pilot(*errors[:3].tolist()),
        float(np.sqrt(np.mean(off(found.x, strength) ** 2))),
        int(moving.sum()),
        does,
        NONE._replace(**dict(zip(keys, errors[3:].tolist(), strict=True))),
    )


def moves_against(
    time: np.ndarray, segment: np.ndarray, voltage: np.ndarray, spool: np.ndarray, travel: float, start: Pilot
) -> bool:
    """Whether a spool follows the voltage of the other sign, and not the voltage; arguments as of `fit_pilot`."""
    driven = driven_spool(start, travel, time, pieces_of(segment), voltage, spool, raster_within(time, segment))
    if np.dot(driven - driven.mean(), spool - spool.mean()) >= 0.0:
        return False
    turned = fit_pilot(time, segment, -voltage, spool, travel, start)
    if turned is None or turned.rms > _FOLLOWS * np.std(spool):
        return False
    own = fit_pilot(time, segment, voltage, spool, travel, start)
    return own is None or turned.rms < _FOLLOWS * own.rms


def told_dead_time(value: float, error: float) -> float:
    """A dead time, s, or none where the log does not tell it from none.

    `simulate` holds a voltage over a step: after any dead time, however short, it sees a jump at a step a whole step later.
    """
    return value if value > max(_SURE * error, _LEAST_DEAD) else 0.0


def _first_gain(voltage: np.ndarray, spool: np.ndarray, travel: float) -> float:
    inner = np.abs(spool) < 0.9 * travel
    return float(abs(np.sum(voltage[inner] * spool[inner])) / max(np.sum(voltage[inner] ** 2), 1e-300))


def _errors(jac: np.ndarray, off: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Standard errors from the scatter of whole blocks of time, whose rows are not independent."""
    bread = np.linalg.pinv(jac.T @ jac)
    _, number = np.unique(block, return_inverse=True)
    sums = np.zeros((number.max() + 1, jac.shape[1]))
    np.add.at(sums, number, jac * off[:, None])
    return np.sqrt(np.maximum(np.diag(bread @ (sums.T @ sums) @ bread), 0.0))


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
    return found.copy(), float(np.sqrt(variance))


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
