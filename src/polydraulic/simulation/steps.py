"""How many steps a run has, and which of them are recorded."""

from math import isfinite
from typing import Any

from polydraulic.errors import InputError
from polydraulic.parameters.quantity import is_number
from polydraulic.parameters.scenario import Scenario

FASTEST = 1e3  # rad/s or m/s; beyond it the numbers mean nothing
DIVERGED = 4  # status of a step that is not made, beside OK, NOT_CONVERGED and OUT_OF_DOMAIN of the flows
MOST_STEPS = 1_000_000_000  # in a run


def _check_number(what: str, value: Any) -> None:
    """Raise InputError of what is no number, such as a text with a unit."""
    if not is_number(value):
        raise InputError(f"{what} = {value!r}: must be a number, in s")


def check_time_step(dt: float) -> None:
    """Raise InputError unless `dt` is a positive, finite time in s."""
    _check_number("dt", dt)
    if not (isfinite(dt) and dt > 0.0):
        raise InputError(f"dt = {dt} s: the time step must be positive and finite, for example 0.005")


def n_steps(scenario: Scenario, dt: float, t_end: float | None, every: int = 1) -> int:
    """Whole steps in a run.

    Raises
    ------
    InputError
        If there is none or more than `MOST_STEPS`, `dt` is not a positive time, or `every` is no positive whole number.
    """
    check_time_step(dt)
    duration = scenario.duration if t_end is None else t_end
    _check_number("duration", duration)
    if not (isfinite(duration) and duration >= dt):
        raise InputError(f"duration = {duration} s: must be finite and at least one time step, {dt} s")
    if not isinstance(every, int) or every < 1:
        raise InputError(f"every = {every!r}: must be a whole number, at least 1")
    steps = duration / dt + 1e-9
    if steps > MOST_STEPS:
        raise InputError(
            f"duration = {duration:g} s: makes {steps:.3g} steps of {dt} s; at most {MOST_STEPS:g} are made: run a shorter time"
        )
    return int(steps)


def recorded_steps(dt: float, every: int, raster: float | None) -> int:
    """Every how many steps a row is recorded, from `every` or from a raster in seconds.

    Raises
    ------
    InputError
        If both are given, or the raster is no whole number of steps.
    """
    if raster is None:
        return every
    _check_number("raster", raster)
    _check_number("dt", dt)
    if not dt > 0.0:  # whoever prepares the machine refuses such a dt
        return every
    if every != 1:
        raise InputError(f"every = {every!r} and raster = {raster} s both say when to record; give one of them")
    steps = raster / dt
    if not (isfinite(steps) and steps > 0.5 and abs(steps - round(steps)) < 1e-6):
        raise InputError(
            f"raster = {raster} s: must be a whole number of time steps of {dt} s, for example {10 * dt:g}"
        )
    return round(steps)
