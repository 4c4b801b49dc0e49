"""How much of a sensor's signal is noise: from differences that a smooth signal hardly has."""

from collections.abc import Sequence

import numpy as np

_WEIGHTS = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
# of its range: no sensor is finer, and a signal that mostly rests, without any noise, would weigh endlessly
_FINEST = 1e-5
_NORMAL = 0.6745  # median of the absolute value of a standard normal variable


def noise_level(values: np.ndarray, segment: np.ndarray) -> float:
    """Standard deviation of white noise on a signal that is smooth from row to row, in the signal's unit; 0 where too few rows follow each other.

    Fourth differences remove what a cubic follows; of what is left the median counts, so that the signal's own jumps do not.

    Parameters
    ----------
    values : (n_row,) array
        NaN in rows in which the sensor is silent.
    segment : (n_row,) array
        Rows of one segment follow each other.
    """
    if len(values) < len(_WEIGHTS):
        return 0.0
    rough = np.convolve(values, _WEIGHTS, mode="valid")
    within = (segment[4:] == segment[:-4]) & ~np.isnan(rough)
    if not within.any():
        return 0.0
    level = np.median(np.abs(rough[within])) / _NORMAL / np.sqrt(np.sum(_WEIGHTS**2))
    return float(max(level, _FINEST * np.ptp(values[~np.isnan(values)])))


def noise_of_pieces(pieces: Sequence[np.ndarray]) -> float:
    """`noise_level` of a signal in pieces without gaps, (n_row,) arrays each."""
    return noise_level(np.concatenate(pieces), np.repeat(np.arange(len(pieces)), [len(piece) for piece in pieces]))


def robust_deviation(values: np.ndarray) -> float:
    """Standard deviation about zero, by the median; one where nothing is there."""
    return float(np.median(np.abs(values))) / _NORMAL + 1e-9 if len(values) else 1.0
