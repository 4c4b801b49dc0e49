"""Voltage signals: functions of time, v(t), given as data.

A signal takes times of any shape and returns volts of the same shape. Outside the times of a piecewise signal or a
recording its first or last value holds.
"""

from dataclasses import dataclass, field

import numpy as np

from polydraulic.errors import InputError


@dataclass(frozen=True)
class Sine:
    """amplitude sin(omega t)."""

    amplitude: float
    omega: float

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Volts at the times `t`."""
        return self.amplitude * np.sin(self.omega * np.asarray(t))


@dataclass(frozen=True)
class Constant:
    """A step at t = 0 that stays."""

    voltage: float = 0.0

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Volts at the times `t`."""
        return np.full(np.shape(t), self.voltage)


@dataclass(frozen=True)
class Piecewise:
    """Straight lines between (time, voltage) points; a recording is the same with many points.

    Raises
    ------
    InputError
        If there are no points, or the times do not rise.
    """

    time: np.ndarray = field(repr=False)
    voltage: np.ndarray = field(repr=False)

    def __post_init__(self) -> None:
        if len(self.time) != len(self.voltage) or not len(self.time):
            raise InputError(
                f"a signal needs one voltage per time; got {len(self.time)} times, {len(self.voltage)} voltages"
            )
        backward = np.flatnonzero(np.diff(self.time) <= 0.0)
        if backward.size:
            at = backward[0] + 1
            raise InputError(f"signal times must rise; time {at} is {self.time[at]} after {self.time[at - 1]}")

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Volts at the times `t`."""
        return np.interp(t, self.time, self.voltage)


Signal = Sine | Constant | Piecewise
