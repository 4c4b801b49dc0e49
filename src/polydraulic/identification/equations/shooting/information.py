"""What windows of sensors say of numbers before anything is fitted: their information, where states at the start are not known either."""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.shooting.runs import Slopes
from polydraulic.identification.equations.shooting.windows import Windows

_PRESSURE_SPREAD = 30e5, 5e6  # Pa, of pressures at the start that are measured, and that are not
# by which what is known of positions and rates at the start is loosened: the rows themselves count, too
_STATE_FACTOR = 10.0
_LEAST_SPREAD = 1e-4, 1e-2  # rad or m, rad/s or m/s


class ChannelInformation(NamedTuple):
    """Products of slopes of each channel and window, over its noise.

    Attributes
    ----------
    numbers : (n_channel, n, n) array
        Over numbers, summed over windows.
    cross : (n_channel, n_window, n_state, n) array
    states : (n_channel, n_window, n_state, n_state) array
    state_spread : (n_state,) array
    """

    numbers: np.ndarray
    cross: np.ndarray
    states: np.ndarray
    state_spread: np.ndarray


def state_spreads(windows: Windows) -> np.ndarray:
    """Standard deviations of pressures at A and B, positions and rates at the start of windows, (4 n_function,)."""
    n = windows.position.shape[1]
    known = windows.p_a is not None and windows.p_b is not None and not np.isnan([windows.p_a, windows.p_b]).any()
    pressure = np.full(2 * n, _PRESSURE_SPREAD[0 if known else 1])
    position = np.maximum(_STATE_FACTOR * windows.position_sd, _LEAST_SPREAD[0])
    rate = np.maximum(_STATE_FACTOR * windows.rate_sd, _LEAST_SPREAD[1])
    return np.concatenate([pressure, position, rate])


def channel_information(slopes: Slopes, noise: np.ndarray, state_spread: np.ndarray) -> ChannelInformation:
    """Information of each channel by itself.

    Parameters
    ----------
    slopes : Slopes
    noise : (n_channel,) array
        Standard deviation of white noise.
    state_spread : (n_state,) array
    """
    of_numbers, of_states = (part / noise[:, None] for part in slopes)
    return ChannelInformation(
        np.einsum("wrcn,wrcm->cnm", of_numbers, of_numbers, optimize=True),
        np.einsum("wrcs,wrcn->cwsn", of_states, of_numbers, optimize=True),
        np.einsum("wrcs,wrct->cwst", of_states, of_states, optimize=True),
        state_spread,
    )


def information_of(channels: ChannelInformation, chosen: list[int]) -> np.ndarray:
    """Information of some channels together about the numbers, (n, n), once the states are eliminated."""
    inner = channels.states[chosen].sum(0) + np.diag(1.0 / channels.state_spread**2)
    cross = channels.cross[chosen].sum(0)
    scale = np.sqrt(np.einsum("wss->ws", inner))
    inner = inner / (scale[:, :, None] * scale[:, None, :])
    cross = cross / scale[..., None]
    known = np.einsum("wsn,wsm->nm", cross, np.linalg.solve(inner, cross), optimize=True)
    return np.asarray(channels.numbers[chosen].sum(0) - known)


def left_unsure(information: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Standard deviations of numbers, as shares of what they were, (n,), with information and priors together."""
    scaled = information * np.outer(spread, spread)
    covariance = np.linalg.inv(0.5 * (scaled + scaled.T) + np.eye(len(spread)))
    return np.sqrt(np.clip(np.diagonal(covariance), 0.0, 1.0))
