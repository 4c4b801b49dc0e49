"""A pilot from the joystick's voltage and the spool that follows it.

The pilot is tau dx/dt + x = clip(gain v, +-travel) after a dead time. Gain, time constant and dead time are those whose spool, run through
each piece of the log on the voltage alone, is nearest to the measured one. Where jets are known, they may shift the target towards the centre, and
the measured spool may lag behind x by half of a hysteresis either way. Jets are as wrong as the conductances that they follow from: each of these may
be off as far as its standard error, and what the spool says of it is found with the rest.
"""

from collections.abc import Container
from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.spool_motion import NONE, SpoolEffects, driven_spool, pieces_of
from polydraulic.identification.log_pieces import raster_within
from polydraulic.identification.noise import noise_level
from polydraulic.parameters.schema import Pilot

_SETTLED = 3.0  # time constants after the start of a piece, from which on the measured start does not matter
_LONGEST_DEAD = 0.5  # s
# standard errors and s, below which a dead time counts as none: what lies between rows is not known better; so does a gain of as few errors
_SURE, _LEAST_DEAD = 3.0, 1e-3
_LEAST_ROWS = 200
_FOLLOWS = 0.3  # of how much a spool varies, which a pilot that it follows leaves at most
_BLOCK = 5.0  # s, after which errors are independent
_FAR = 10.0  # standard errors, by which a conductance is off at most
_LITTLE, _MOST = 0.01, 100.0  # of the travel: an effect that counts as one, and how many of these it may be


class Jets(NamedTuple):
    """Jets of one valve, conductance times drop at its inlet and outlet.

    Attributes
    ----------
    strength : (n_row,) array, m3/s Pa^0.5
        NaN in rows in which a sensor of the circuit is silent.
    unsure : (n_number, n_row) array
        What a standard error more of each conductance at a knot makes of it, zero of those that are known.
    noise : (n_row,) array
        What noise as that of the sensors would make of it, once more.
    moved : (n_number,) array
        By how many standard errors these conductances are off already from what was known of them before.
    """

    strength: np.ndarray
    unsure: np.ndarray
    noise: np.ndarray
    moved: np.ndarray

    def at(self, rows: np.ndarray) -> "Jets":
        """Those rows, an array of bool."""
        return Jets(self.strength[rows], self.unsure[:, rows], self.noise[rows], self.moved)


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
    moved, moved_errors : (n_number,) array
        By how many standard errors conductances are off from those that made its jets, and standard errors of that, in the same unit; none without a
        shift.
    """

    pilot: Pilot
    errors: Pilot
    rms: float
    rows: int
    effects: SpoolEffects = NONE
    effect_errors: SpoolEffects = NONE
    moved: np.ndarray = np.empty(0)
    moved_errors: np.ndarray = np.empty(0)


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
    unsure, before = np.empty((0, len(time))), np.empty(0)
    shows: np.ndarray = np.zeros(0, dtype=bool)
    pushes = effects.shift != 0.0 or "shift" in free
    if jets is not None and pushes:
        shows = np.asarray(jets.unsure.any(axis=1))
        unsure, before = jets.unsure[shows], jets.moved[shows]
    sensor = max(noise_level(spool, segment), 1e-7)
    # rows of a block err together: what was known of a conductance before counts against them as against one
    of_block = sensor * np.sqrt(_BLOCK / step)
    strong = 1.0 if strength is None else float(np.quantile(strength, 0.99)) or 1.0
    keys = [key for key in SpoolEffects._fields if key in free]
    first = 3 + len(keys)  # of the conductances among the numbers
    # of each effect: what counts as one, the least, and what to begin from
    usual = {"hysteresis": (_LITTLE * travel, 0.0, 1.0), "shift": (_LITTLE * travel / strong, -_MOST, 0.0)}
    more = np.array([usual[key] for key in keys]).reshape(-1, 3).T
    scale = np.array([start.gain, lag0, 0.05, *more[0], *np.ones(len(before))])

    def off(x: np.ndarray, strength: np.ndarray | None) -> np.ndarray:
        pilot, does, further = numbers(x)
        if strength is not None and pushes:
            strength = strength + further @ unsure
        driven = driven_spool(pilot, travel, time, pieces, voltage, spool, step, does, strength)
        return np.append((driven - spool)[use], of_block * (before + further))

    def numbers(x: np.ndarray) -> tuple[Pilot, SpoolEffects, np.ndarray]:
        values = (x * scale).tolist()
        return Pilot(*values[:3]), effects._replace(**dict(zip(keys, values[3:first], strict=True))), x[first:]

    def loss(squares: np.ndarray) -> np.ndarray:
        """Rows that are far off count less, what was known before does not; with both derivatives."""
        root = np.sqrt(1.0 + squares)
        found = np.stack([2.0 * (root - 1.0), 1.0 / root, -0.5 * root**-3])
        told = len(squares) - len(before)
        found[:, told:] = squares[told:], np.ones(len(before)), np.zeros(len(before))
        return found

    low = np.array([1e-3, 0.1 * step / lag0, 0.0, *more[1], *np.full(len(before), -_FAR)])
    high = np.array([1e3, 100.0, _LONGEST_DEAD / scale[2], *np.full(len(keys), _MOST), *np.full(len(before), _FAR)])
    begin = np.clip(
        [
            _first_gain(voltage[use], spool[use], travel) / start.gain,
            1.0,
            0.5 * start.dead_time / scale[2] + 0.1,
            *more[2],
            *np.zeros(len(before)),
        ],
        low + 0.01 * np.abs(low),
        high * 0.99,
    )
    found = least_squares(
        off,
        begin,
        bounds=(low, high),
        loss=loss if len(before) else "soft_l1",
        f_scale=3.0 * sensor,
        max_nfev=60,
        args=(strength,),
    )
    block: np.ndarray = (time[use] // _BLOCK).astype(np.int64)
    own = block.max() + 1 + np.arange(len(before))
    left = found.fun[: len(block)]
    scatter = _errors(found.jac, np.append(left, np.full(len(before), of_block)), np.append(block, own))
    pilot, does, further = numbers(found.x)
    errors = scale * scatter
    if jets is not None and does.shift:
        noise = np.linalg.pinv(found.jac) @ (off(found.x, jets.strength + jets.noise) - found.fun)
        errors = scale * np.hypot(scatter, noise)
    of_jets, of_errors = np.zeros(len(shows)), np.ones(len(shows))
    of_jets[shows], of_errors[shows] = further, errors[first:]
    if not pilot.gain > _SURE * errors[0]:  # as of a voltage of the wrong sign, against which the spool goes
        return None
    return PilotFit(
        pilot,
        Pilot(*errors[:3].tolist()),
        float(np.sqrt(np.mean(left**2))),
        int(moving.sum()),
        does,
        NONE._replace(**dict(zip(keys, errors[3:first].tolist(), strict=True))),
        of_jets,
        of_errors,
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
