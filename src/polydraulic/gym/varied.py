"""Machines that are a little different in every episode: which of their numbers, how far, and the machine with them."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine

_FRICTION = ("coulomb", "static", "viscous")


class Variation(NamedTuple):
    """A number that can be drawn anew for every episode."""

    unit: str
    low: float
    high: float
    each: bool  # one for every function, not one for the machine
    means: str


VARIATIONS = {
    "valve_gain": Variation("1", 0.2, 2.5, True, "travel of a spool for each volt, in shares of the machine's own"),
    "friction": Variation("1", 0.0, 10.0, True, "dry and viscous friction of a joint, in shares of the machine's own"),
    "dead_time": Variation("s", 0.0, 1.0, True, "of a pilot, on top of the machine's own"),
    "payload": Variation("kg", 0.0, 1e5, False, "a mass at the tip, which it carries from the start"),
}
Ranges = dict[str, tuple[float, float]]


def checked_ranges(randomize: Mapping[str, tuple[float, float]] | None) -> Ranges:
    """Ranges to draw from, in the order of `VARIATIONS`.

    Raises
    ------
    InputError
        Other names, no two numbers in rising order, numbers out of their range.
    """
    if randomize is not None and not isinstance(randomize, Mapping):
        raise InputError(
            f"randomize = {briefly(randomize)}: must name numbers and their ranges, such as {{'payload': (0, 500)}}"
        )
    given = dict(randomize or {})
    unknown = [name for name in given if name not in VARIATIONS]
    if unknown:
        raise InputError(f"randomize names {briefly(unknown[0])}; there are {list(VARIATIONS)}")
    found: Ranges = {}
    for name, of in VARIATIONS.items():
        if name not in given:
            continue
        try:
            low, high = (float(value) for value in given[name])
        except (TypeError, ValueError):
            low = high = np.nan
        if not of.low <= low <= high <= of.high:
            raise InputError(
                f"randomize: {name} = {briefly(given[name])}: must be two numbers in rising order, from {of.low:g} to {of.high:g} {of.unit}"
            )
        found[name] = (low, high)
    return found


def draw_count(ranges: Ranges, n_function: int) -> int:
    """How many numbers an episode draws for its machine."""
    return sum(n_function if VARIATIONS[name].each else 1 for name in ranges)


def parameters_from(ranges: Ranges, n_function: int, draws: np.ndarray) -> dict[str, np.ndarray]:
    """Parameters of machines, from `draw_count` uniform numbers each, (n_draw, n): by name, (n_function, n) or (1, n)."""
    found, at = {}, 0
    for name, (low, high) in ranges.items():
        rows = n_function if VARIATIONS[name].each else 1
        found[name] = low + (high - low) * draws[at : at + rows]
        at += rows
    return found


def varied_machine(machine: LayoutMachine, parameters: Mapping[str, np.ndarray]) -> LayoutMachine:
    """The machine with parameters of its own, by name (n_function,) or (1,) values; all of one layout."""
    functions = list(machine.functions)
    for name, values in parameters.items():
        if VARIATIONS[name].each:
            functions = [_varied(f, name, float(value)) for f, value in zip(functions, values, strict=True)]
    found = machine._replace(functions=tuple(functions))
    return with_payload(found, float(parameters["payload"][0])) if "payload" in parameters else found


def _varied(f: MachineFunction, name: str, value: float) -> MachineFunction:
    pilot, friction = f.pilot, f.friction
    if name == "valve_gain":
        pilot = pilot._replace(gain=pilot.gain * value)
    elif name == "dead_time":
        pilot = pilot._replace(dead_time=pilot.dead_time + value)
    else:
        friction = friction._replace(**{key: getattr(friction, key) * value for key in _FRICTION})
    return f._replace(pilot=pilot, friction=friction)
