"""Spool motion in closed form for voltages that are known in advance, and when the spools pass the knots of their tables.

Between the corners of the voltages a pilot's command is a straight line or a sine, so that its spool follows exactly (`spool_curves`), or lags behind
by a play (`lagging_spools`). A force that is known in advance is the same without a past.
"""

from collections.abc import Sequence
from math import asin, ceil, inf, pi
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.parameters.schema import Pilot
from polydraulic.parameters.signals import Constant, Piecewise, Signal, Sine
from polydraulic.simulation.solvers.lagging_spools import NONE, lagging
from polydraulic.simulation.solvers.spool_curves import LOOK, N_COEFFICIENT, SAME, spool_curve

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


@driver
def _crossings(starts: np.ndarray, c: np.ndarray, levels: np.ndarray, found: np.ndarray) -> int:
    """Times at which inputs pass their levels, (n_input, n_level); more than `found` holds are counted, not kept."""
    n = 0
    for piece in range(starts.shape[0] - 1):
        t0, t1 = starts[piece], starts[piece + 1]
        parts = int((t1 - t0) / LOOK) + 1
        for link in range(levels.shape[0]):
            before = spool_curve(c[piece], link, t0, t0).x
            for part in range(parts):
                low = t0 + (t1 - t0) * part / parts
                high = t0 + (t1 - t0) * (part + 1) / parts
                after = spool_curve(c[piece], link, t0, high).x
                for level in levels[link]:
                    if (before < level) != (after < level):
                        a, b = low, high
                        for _ in range(60):
                            middle = 0.5 * (a + b)
                            inside = (spool_curve(c[piece], link, t0, middle).x < level) == (before < level)
                            a, b = (middle, b) if inside else (a, middle)
                        if n < found.shape[0]:
                            found[n] = b
                        n += 1
                before = after
    return n


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
        both = np.unique([side * knot for knot in one.knots for side in (-1.0, 1.0)])
        row[: len(both)] = both
    return levels


def _corners(signal: Signal, pilot: Pilot, travel: float, t_end: float) -> list[float]:
    """Times at which a pilot's command has a corner, its limits among them."""
    delay, limit = pilot.dead_time, travel / pilot.gain
    if isinstance(signal, Constant):
        return [delay]
    if isinstance(signal, Piecewise):
        t, v = np.asarray(signal.time, dtype=float), np.asarray(signal.voltage, dtype=float)
        found = list(t)
        for level in (-limit, limit):
            passing = np.flatnonzero((v[:-1] - level) * (v[1:] - level) < 0.0)
            share = (level - v[passing]) / (v[passing + 1] - v[passing])
            found += list(t[passing] + share * (t[passing + 1] - t[passing]))
        return [delay, *(time + delay for time in found if time > 0.0)]
    if abs(signal.amplitude) <= limit or signal.omega == 0.0:
        return [delay]
    first, omega = asin(limit / abs(signal.amplitude)), abs(signal.omega)
    angles = [k * pi + side * first for k in range(ceil(omega * t_end / pi) + 2) for side in (-1.0, 1.0)]
    return [delay, *(angle / omega + delay for angle in angles if angle > 0.0)]


def _command(c: np.ndarray, starts: np.ndarray, signal: Signal, pilot: Pilot, travel: float) -> None:
    """Coefficients (n_piece, N_COEFFICIENT) of one spool in all pieces, but for what is left of its past."""
    tau, delay = pilot.time_constant, pilot.dead_time
    length = np.diff(starts)
    early, middle, late = (starts[:-1] + share * length for share in (0.25, 0.5, 0.75))
    alive = middle > delay
    first, command, last = (pilot.gain * signal(t - delay) for t in (early, middle, late))
    slope = np.where(alive, (last - first) / (late - early), 0.0)
    c[:, 0] = np.where(alive, command, 0.0) - slope * (middle - starts[:-1]) - tau * slope
    c[:, 1], c[:, 6], c[:, 7] = slope, delay, 1.0 / tau if tau > 0.0 else 0.0
    if isinstance(signal, Sine):
        turn = signal.omega * tau
        share = pilot.gain * signal.amplitude / (1.0 + turn * turn)
        c[alive, 0:2] = 0.0
        c[alive, 3], c[alive, 4], c[alive, 5] = share, -turn * share, signal.omega
    full = alive & (np.abs(command) >= travel)
    c[full, 1:6] = 0.0
    c[full, 0] = np.copysign(travel, command[full])
