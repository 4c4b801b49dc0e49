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
    assert s.spool is not None
    assert s.p_a is not None
    assert s.p_b is not None
    forward = s.spool[rows] > 0.0
    if measured:
        assert s.q_in is not None
        flows = [np.full(len(rows), np.nan) if q is None else q[rows[:, 0]] for q in (s.q_in, s.q_out)]
        known = [~np.isnan(q) for q in flows]
        return Balance(
            rows,
            np.where(known[0], flows[0], 0.0),
            np.where(known[1], flows[1], 0.0),
            np.zeros((len(rows), 2)),
            np.zeros((len(rows), 2)),
            known[0],
            known[1],
            s.noise["q_in"],
            s.noise.get("q_out", np.inf),
        )
    assert s.volume_a is not None
    assert s.volume_b is not None
    assert s.rate_a is not None
    assert s.rate_b is not None
    assert s.volume_rate_a is not None
    assert s.volume_rate_b is not None
    time, line = raster * (rows.shape[1] - 1), f.line
    weights = mean_weights(rows.shape[1])
    leak = line.leakage * ((s.p_a - s.p_b)[rows] @ weights)
    lost_a, lost_b = (line.external_leakage * (p[rows] @ weights) for p in (s.p_a, s.p_b))
    last, first = rows[:, -1], rows[:, 0]
    into_a = (
        (s.volume_a[last] - s.volume_a[first] + line.compliance_a * (s.p_a[last] - s.p_a[first])) / time + leak + lost_a
    )
    into_b = (
        (s.volume_b[last] - s.volume_b[first] + line.compliance_b * (s.p_b[last] - s.p_b[first])) / time - leak + lost_b
    )
    rates_a, rates_b = (
        np.column_stack([c * (p[last] - p[first]), v[last] - v[first]]) / time
        for c, p, v in (
            (line.compliance_a, s.rate_a, s.volume_rate_a),
            (line.compliance_b, s.rate_b, s.volume_rate_b),
        )
    )
    one_side = forward.all(axis=1) | (~forward).all(axis=1)
    ahead = forward[:, 0]
    shut = [((p[rows] > floor + _MARGIN) & (p[rows] < line.relief - _MARGIN)).all(axis=1) for p in (s.p_a, s.p_b)]
    noise = {
        side: float(np.hypot(np.sqrt(2.0) * s.noise[f"volume_{side}"], np.sqrt(2.0) * c * s.noise[f"p_{side}"]) / time)
        for side, c in (("a", line.compliance_a), ("b", line.compliance_b))
    }
    q_in, q_out = np.where(ahead, into_a, into_b), np.where(ahead, -into_b, -into_a)
    known_in, known_out = ~np.isnan(q_in), ~np.isnan(q_out)
    return Balance(
        rows,
        np.where(known_in, q_in, 0.0),
        np.where(known_out, q_out, 0.0),
        np.where(known_in[:, None], np.where(ahead[:, None], rates_a, rates_b), 0.0),
        np.where(known_out[:, None], np.where(ahead[:, None], -rates_b, -rates_a), 0.0),
        known_in & one_side & np.where(ahead, *shut),
        known_out & one_side & np.where(ahead, shut[1], shut[0]),
        max(noise.values()),
        max(noise.values()),
    )
