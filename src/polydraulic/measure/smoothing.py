"""Derivatives of measured signals by local polynomials (Savitzky and Golay), and what these assume."""

from math import pi
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError

ORDER = 3
LEAST = 5  # samples


class Assumption(NamedTuple):
    """What a derivative assumes and costs.

    Attributes
    ----------
    window : float, s
    bandwidth : float, Hz
        Motion up to this frequency is seen with at least 0.71 of its rate.
    noise_gain : float, 1/s
        Standard deviation of the derivative for each unit of white noise of the signal.
    """

    window: float
    bandwidth: float
    noise_gain: float

    def __str__(self) -> str:
        return (
            f"a cubic over {self.window:g} s: assumes that the motion is smooth over this time and the noise of neighbouring "
            f"samples independent; passes motion up to {self.bandwidth:.3g} Hz; noise sigma of the signal becomes {self.noise_gain:.3g} sigma "
            "per second"
        )


def window_length(raster: float, window: float) -> int:
    """Odd number of samples in a window, at least `LEAST`."""
    return max(LEAST, 2 * round(0.5 * window / raster) + 1)


def differentiate(values: np.ndarray, raster: float, window: float) -> np.ndarray:
    """Differentiate evenly spaced samples without a gap.

    Parameters
    ----------
    values : (n,) array
    raster : float, s
    window : float, s
        Of the local cubic; shortened to the samples there are.

    Returns
    -------
    (n,) array
        At both ends from the cubic of the last whole window.

    Raises
    ------
    InputError
        If there are fewer than `LEAST` samples.

    References
    ----------
    Savitzky and Golay, Analytical Chemistry 36 (1964) 1627.
    """
    n = len(values)
    if n < LEAST:
        raise InputError(f"{n} samples cannot be differentiated: {LEAST} at least")
    length = min(window_length(raster, window), n - 1 + n % 2)
    slopes, middle = _slopes(length), length // 2
    begin, end = slopes[:middle] @ values[:length], slopes[middle + 1 :] @ values[-length:]
    return np.concatenate([begin, np.convolve(values, slopes[middle, ::-1], "valid"), end]) / raster


def _slopes(length: int) -> np.ndarray:
    """Weights of the samples of a window in the slope of its cubic at each of them, (length, length), for samples 1 apart.

    Not from scipy.signal, whose import takes longer than most logs.
    """
    middle = length // 2
    place = (np.arange(length) - middle) / middle
    fit = np.linalg.pinv(np.vander(place, ORDER + 1, increasing=True))
    powers = np.arange(1, ORDER + 1)
    return (powers * place[:, None] ** (powers - 1)) @ fit[1:] / middle


def assumption(raster: float, window: float) -> Assumption:
    """What `differentiate` assumes with this raster and window."""
    length = window_length(raster, window)
    c = _slopes(length)[length // 2] / raster
    omega = np.linspace(1e-3, pi, 2000) / raster
    place = (np.arange(length) - length // 2) * raster
    response = np.sin(np.outer(omega, place)) @ c / omega
    passed = np.flatnonzero(np.abs(response) < 0.5**0.5)
    limit = omega[passed[0]] if passed.size else omega[-1]
    return Assumption(length * raster, float(limit / (2.0 * pi)), float(np.sqrt(np.sum(c * c))))
