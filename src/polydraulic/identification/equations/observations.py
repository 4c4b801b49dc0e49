"""What counts of a log for a circuit and for outlets: rows with measured flows, or windows of rows over which volumes are balanced.

Where no flow is measured, what enters a line in a window moves the actuator and compresses the oil: the mean of the flow over the window is
(change of volume + compliance times change of pressure) / time + leakage. Nothing is differentiated. A window counts while the
spool stays on one side and no valve of the line (relief, make-up) can have opened.
"""

import itertools
from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.sensors import Signals
from polydraulic.parameters.layout.parts import MachineFunction

WINDOW = 0.3  # s
_MARGIN = 5e5  # Pa from the floor and from the line's relief setting
_BLOCK, _BLOCKS = 30.0, 20  # s, and how many of them at least: shorter ones of a short log


class Balance(NamedTuple):
    """Rows in windows of equal length, and flows into and out of an actuator in these.

    Attributes
    ----------
    rows : (n_window, n_long) array of int
        Of the log; windows of a single row where flows are measured.
    q_in, q_out : (n_window,) array, m3/s
        Mean flows through the valve; 0 where they are not known.
    rates_in, rates_out : (n_window, 2) array, m3/s2
        How these flows change with the clocks of the sensors of pressure and of position; none where flows are measured.
    known_in, known_out : (n_window,) array of bool
    noise_in, noise_out : float, m3/s
    """

    rows: np.ndarray
    q_in: np.ndarray
    q_out: np.ndarray
    rates_in: np.ndarray
    rates_out: np.ndarray
    known_in: np.ndarray
    known_out: np.ndarray
    noise_in: float
    noise_out: float


def mean_weights(long: int) -> np.ndarray:
    """Weights of the rows of a window whose sum is the mean over its time, (long,)."""
    if long == 1:
        return np.ones(1)
    weights = np.ones(long)
    weights[[0, -1]] = 0.5
    return weights / (long - 1)


def blocks_of_time(time: np.ndarray) -> np.ndarray:
    """Number of the block of time of each row, (n_row,); every fifth is held out."""
    length = min(_BLOCK, float(time[-1] - time[0]) / _BLOCKS * (1.0 + 1e-9))
    return ((time - time[0]) // max(length, 1e-9)).astype(np.int64)


def windows(segment: np.ndarray, long: int) -> np.ndarray:
    """Rows of windows that follow each other within segments, (n_window, long)."""
    starts = []
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(segment)) + 1, [len(segment)]])
    for begin, end in itertools.pairwise(cuts):
        starts.append(np.arange(begin, end - long + 1, max(long - 1, 1)))
    first = np.concatenate(starts)
    return first[:, None] + np.arange(long)


def balance(f: MachineFunction, floor: float, s: Signals, rows: np.ndarray, raster: float, measured: bool) -> Balance:
    """Flows of a function in windows.

    Parameters
    ----------
    f : MachineFunction
    floor : float, Pa
        Below which make-up valves let no line fall.
    s : Signals
    rows : (n_window, n_long) array of int
    raster : float, s
    measured : bool
        Whether flows are taken from their sensors; windows are single rows then.
    """
    return _read(s, rows) if measured else _balanced(f, floor, s, rows, raster)


def _read(s: Signals, rows: np.ndarray) -> Balance:
    """Flows as their sensors read them."""
    silent = np.full(len(s.values["q_in"]), np.nan)
    q_in, q_out = (s.values.get(what, silent)[rows[:, 0]] for what in ("q_in", "q_out"))
    known_in, known_out = ~np.isnan(q_in), ~np.isnan(q_out)
    none = np.zeros((len(rows), 2))
    return Balance(
        rows, np.nan_to_num(q_in), np.nan_to_num(q_out), none, none, known_in, known_out, s.noise["q_in"], s.noise.get("q_out", np.inf)
    )  # fmt: skip


def _balanced(f: MachineFunction, floor: float, s: Signals, rows: np.ndarray, raster: float) -> Balance:
    """Flows as volumes and pressures tell them; not known where spools change sides or a valve of the line can have opened."""
    forward = s.values["spool"][rows] > 0.0
    ahead, one_side = forward[:, 0], forward.all(axis=1) | (~forward).all(axis=1)
    a, b = (_into(f, floor, s, side, rows, raster) for side in ("a", "b"))
    q_in, q_out = np.where(ahead, a.flow, b.flow), np.where(ahead, -b.flow, -a.flow)
    known_in, known_out = ~np.isnan(q_in), ~np.isnan(q_out)
    noise = max(a.noise, b.noise)
    return Balance(
        rows,
        np.where(known_in, q_in, 0.0),
        np.where(known_out, q_out, 0.0),
        np.where(known_in[:, None], np.where(ahead[:, None], a.rates, b.rates), 0.0),
        np.where(known_out[:, None], np.where(ahead[:, None], -b.rates, -a.rates), 0.0),
        known_in & one_side & np.where(ahead, a.shut, b.shut),
        known_out & one_side & np.where(ahead, b.shut, a.shut),
        noise,
        noise,
    )


class _Into(NamedTuple):
    """What enters a line through the valve in each window; `shut` where no valve of the line can have opened."""

    flow: np.ndarray  # (n_window,) m3/s
    rates: np.ndarray  # (n_window, 2) m3/s2, with the clocks of pressure and position
    shut: np.ndarray  # (n_window,) of bool
    noise: float  # m3/s


def _into(f: MachineFunction, floor: float, s: Signals, side: str, rows: np.ndarray, raster: float) -> _Into:
    """Of one side of the actuator: what displaces it and compresses the oil there, and what leaks away."""
    line, other = f.line, "b" if side == "a" else "a"
    compliance = line.compliance_a if side == "a" else line.compliance_b
    p, far, volume = (s.values[what] for what in (f"p_{side}", f"p_{other}", f"volume_{side}"))
    p_rate, volume_rate = s.rates[f"p_{side}"], s.rates[f"volume_{side}"]
    first, last, time = rows[:, 0], rows[:, -1], raster * (rows.shape[1] - 1)
    weights = mean_weights(rows.shape[1])
    leaks = line.leakage * ((p - far)[rows] @ weights) + line.external_leakage * (p[rows] @ weights)
    stored = volume[last] - volume[first] + compliance * (p[last] - p[first])
    changes = [compliance * (p_rate[last] - p_rate[first]), volume_rate[last] - volume_rate[first]]
    of_noise = np.hypot(s.noise[f"volume_{side}"], compliance * s.noise[f"p_{side}"])
    return _Into(
        stored / time + leaks,
        np.column_stack(changes) / time,
        ((p[rows] > floor + _MARGIN) & (p[rows] < line.relief - _MARGIN)).all(axis=1),
        float(np.sqrt(2.0) * of_noise / time),
    )
