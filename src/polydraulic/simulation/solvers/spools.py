"""Spool motion in closed form for voltages that are known in advance, and when the spools pass the knots of their tables.

Between the corners of the voltages a pilot's command is a straight line or a sine, so that its spool follows exactly (`spool_curves`), or lags behind
by a play (`lagging_spools`). A force that is known in advance is the same without a past.
"""

from collections.abc import Sequence
from math import asin, ceil, inf, log, pi
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.parameters.schema import Pilot
from polydraulic.parameters.signals import Constant, Piecewise, Signal, Sine
from polydraulic.simulation.solvers.lagging_spools import NONE, lagging
from polydraulic.simulation.solvers.spool_curves import (
    LOOK,
    N_COEFFICIENT,
    SAME,
    KnownCurve,
    along_curve,
    curve_of,
    spool_curve,
)

_QUARTERS = np.array([0.25, 0.5, 0.75])
SHORTEST = 1e-3  # s that are integrated where the start alone is wanted, with its flows


@driver
def inputs_at(c: np.ndarray, t0: float, t: float, x: np.ndarray, v: np.ndarray) -> None:
    """Values and rates of all inputs at the time t of a piece that begins at t0 and has the coefficients c, (n_input, N_COEFFICIENT)."""
    for k in range(c.shape[0]):
        curve = spool_curve(c, k, t0, t)
        x[k] = curve.x
        v[k] = curve.v


@driver
def _chain(starts: np.ndarray, c: np.ndarray) -> None:
    """What is left of each spool's past at the start of a piece: it begins where the piece before has ended, the first at rest."""
    for link in range(c.shape[1]):
        x = 0.0
        for piece in range(c.shape[0]):
            if c[piece, link, 7] == 0.0:  # nothing lags
                continue
            c[piece, link, 2] = x - spool_curve(c[piece], link, starts[piece], starts[piece]).x
            x = spool_curve(c[piece], link, starts[piece], starts[piece + 1]).x


@kernel
def _turns_at(k: KnownCurve, length: float) -> float:
    """After which time of a piece a curve without a sine turns back; its end if it does not."""
    ratio = k.c2 * k.rate / k.c1 if k.c1 != 0.0 else 0.0
    after = log(ratio) / k.rate if ratio > 1.0 else length
    return min(after, length)


@driver
def _crossings(starts: np.ndarray, c: np.ndarray, levels: np.ndarray, found: np.ndarray) -> int:
    """Times at which inputs pass their levels, (n_input, n_level); more than `found` holds are counted, not kept.

    They are sought between the places where a curve turns back; of sines, which have many, in parts of `LOOK`.
    """
    n = 0
    for piece in range(starts.shape[0] - 1):
        t0, t1 = starts[piece], starts[piece + 1]
        for link in range(levels.shape[0]):
            curve = curve_of(c[piece], link)
            parts = int((t1 - t0) / LOOK) + 1 if curve.w != 0.0 else 2
            turn = t0 + _turns_at(curve, t1 - t0)
            before, low = along_curve(curve, t0, t0).x, t0
            for part in range(parts):
                high = t0 + (t1 - t0) * (part + 1) / parts if curve.w != 0.0 else (turn if part == 0 else t1)
                after = along_curve(curve, t0, high).x
                for level in levels[link]:
                    if (before < level) != (after < level):
                        a, b = low, high
                        for _ in range(60):
                            middle = 0.5 * (a + b)
                            inside = (along_curve(curve, t0, middle).x < level) == (before < level)
                            a, b = (middle, b) if inside else (a, middle)
                        if n < found.shape[0]:
                            found[n] = b
                        n += 1
                before, low = after, high
    return n


@driver
def _limits_passed(t: np.ndarray, v: np.ndarray, limit: float, found: np.ndarray) -> int:
    """Times at which straight lines between points pass a limit to either side."""
    n = 0
    for k in range(t.shape[0] - 1):
        for side in (-1.0, 1.0):
            before, after = v[k] - side * limit, v[k + 1] - side * limit
            if before * after < 0.0:
                found[n] = t[k] - before / (v[k + 1] - v[k]) * (t[k + 1] - t[k])
                n += 1
    return n


@driver
def _fill_curves(
    c: np.ndarray,
    starts: np.ndarray,
    commands: np.ndarray,
    tau: float,
    delay: float,
    travel: float,
    wave: float,
    omega: float,
) -> None:
    """Coefficients (n_piece, N_COEFFICIENT) of one spool, but for what is left of its past.

    Parameters
    ----------
    c : array
        Zeros, filled.
    starts : (n_piece + 1,) array, s
    commands : (n_piece, 3) array, m
        What drives the spool at 1/4, 1/2 and 3/4 of each piece.
    tau, delay : float, s
    travel : float, m
    wave : float, m
        Amplitude of a sine of `omega` in rad/s; 0 where pieces are straight lines.
    """
    share = 1.0 / (1.0 + omega * tau * (omega * tau))
    for piece in range(c.shape[0]):
        length, middle = starts[piece + 1] - starts[piece], commands[piece, 1]
        c[piece, 6], c[piece, 7] = delay, 1.0 / tau if tau > 0.0 else 0.0
        if starts[piece] + 0.5 * length <= delay:
            continue
        if abs(middle) >= travel:
            c[piece, 0] = travel if middle > 0.0 else -travel
        elif wave != 0.0:
            c[piece, 3], c[piece, 4], c[piece, 5] = share * wave, -omega * tau * share * wave, omega
        else:
            slope = (commands[piece, 2] - commands[piece, 0]) / (0.5 * length)
            c[piece, 0], c[piece, 1] = middle - slope * (0.5 * length + tau), slope


class SpoolMotion(NamedTuple):
    """Spool motion of a run, and whatever else is known in advance."""

    starts: np.ndarray  # (n_piece + 1,) s, corners of the commands and the end
    coefficients: np.ndarray  # (n_piece, n_input, N_COEFFICIENT)
    breaks: np.ndarray  # (n_break,) s, rising: corners and knots passed; the end is the last
    driven: np.ndarray  # as coefficients, of what drives spools with hysteresis


class KnownInput(NamedTuple):
    """A signal that is known in advance and what follows it; a force follows at once, without limit.

    Attributes
    ----------
    signal : Signal
    pilot : Pilot
        Its time constant may be 0.
    travel : float
        Limit of gain times signal, to either side.
    knots : sequence of float
        Magnitudes that the input may pass, its zero among them.
    later : sequence of (s, Pilot)
        Other pilots that take over at these times, which are corners.
    lags : sequence of (s, m)
        From these times on it lags behind by so much to either side; without any it does not.
    """

    signal: Signal
    pilot: Pilot
    travel: float
    knots: Sequence[float] = ()
    later: Sequence[tuple[float, Pilot]] = ()
    lags: Sequence[tuple[float, float]] = ()


def known_force(signal: Signal) -> KnownInput:
    """A force, as an input."""
    return KnownInput(signal, Pilot(gain=1.0, time_constant=0.0, dead_time=0.0), inf)


def known_motion(inputs: Sequence[KnownInput], t_end: float, corners: Sequence[float] = ()) -> SpoolMotion:
    """Closed form of all inputs from rest, and when each passes one of its knots.

    Parameters
    ----------
    inputs : sequence of KnownInput
    t_end : float, s
    corners : sequence of float, s
        Times at which something else happens.
    """
    times = [0.0, t_end, *corners]
    for one in inputs:
        for pilot in dict.fromkeys([one.pilot, *(pilot for _, pilot in one.later)]):
            times += _corners(one.signal, pilot, one.travel, t_end)
    starts = np.unique(np.array([t for t in times if 0.0 <= t <= t_end]))
    starts = np.concatenate([starts[:-1][np.diff(starts) > SAME], starts[-1:]])
    c = np.zeros((len(starts) - 1, len(inputs), N_COEFFICIENT))
    for place, one in enumerate(inputs):
        pieces = [0, *(int(np.abs(starts - t).argmin()) for t, _ in one.later), len(c)]
        pilots = [one.pilot, *(pilot for _, pilot in one.later)]
        for pilot, first, end in zip(pilots, pieces[:-1], pieces[1:], strict=True):
            _command(c[first:end, place], starts[first : end + 1], one.signal, pilot, one.travel)
    _chain(starts, c)
    starts, driven, c = lagging(starts, c, _half_widths(inputs, starts))
    levels = _levels(inputs)
    found = np.empty(1024)
    n = _crossings(starts, c, levels, found)
    if n > len(found):
        found = np.empty(n)
        _crossings(starts, c, levels, found)
    breaks = np.unique(np.concatenate([starts[1:], found[:n]]))
    # of two breaks at the same time the later stays, so that the end does
    breaks = breaks[np.append(np.diff(breaks) > SAME, True)]
    return SpoolMotion(starts, c, breaks, driven)


def _half_widths(inputs: Sequence[KnownInput], starts: np.ndarray) -> np.ndarray:
    """By how much inputs lag behind in each piece, (n_piece, n_input)."""
    halves = np.full((len(starts) - 1, len(inputs)), NONE)
    for place, one in enumerate(inputs):
        for t, half in one.lags:
            halves[int(np.abs(starts - t).argmin()) :, place] = half
    return halves


def _levels(inputs: Sequence[KnownInput]) -> np.ndarray:
    """Knots to both sides of each input, (n_input, n_level); NaN, which nothing passes, where there are fewer."""
    levels = np.full((len(inputs), 2 * max(len(one.knots) for one in inputs)), np.nan)
    for row, one in zip(levels, inputs, strict=True):
        both = sorted({side * knot for knot in one.knots for side in (-1.0, 1.0)})
        row[: len(both)] = both
    return levels


def _corners(signal: Signal, pilot: Pilot, travel: float, t_end: float) -> list[float]:
    """Times at which a pilot's command has a corner, its limits among them."""
    delay, limit = pilot.dead_time, travel / pilot.gain
    if isinstance(signal, Constant):
        return [delay]
    if isinstance(signal, Piecewise):
        t, v = (np.ascontiguousarray(values, dtype=float) for values in (signal.time, signal.voltage))
        passed = np.empty(2 * len(t))
        found = [*t.tolist(), *passed[: _limits_passed(t, v, limit, passed)].tolist()]
        return [delay, *(time + delay for time in found if time > 0.0)]
    if abs(signal.amplitude) <= limit or signal.omega == 0.0:
        return [delay]
    first, omega = asin(limit / abs(signal.amplitude)), abs(signal.omega)
    angles = [k * pi + side * first for k in range(ceil(omega * t_end / pi) + 2) for side in (-1.0, 1.0)]
    return [delay, *(angle / omega + delay for angle in angles if angle > 0.0)]


def _command(c: np.ndarray, starts: np.ndarray, signal: Signal, pilot: Pilot, travel: float) -> None:
    """Coefficients (n_piece, N_COEFFICIENT) of one spool in all pieces, but for what is left of its past."""
    inside = starts[:-1, None] + _QUARTERS * np.diff(starts)[:, None] - pilot.dead_time
    wave, omega = (pilot.gain * signal.amplitude, signal.omega) if isinstance(signal, Sine) else (0.0, 0.0)
    commands = pilot.gain * signal(inside)
    _fill_curves(c, starts, commands, pilot.time_constant, pilot.dead_time, travel, wave, omega)
