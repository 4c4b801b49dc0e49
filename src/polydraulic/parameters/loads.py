"""What pushes and hangs at a machine's tip while it works: a force over time, a payload over time."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.entries import read_quantity
from polydraulic.parameters.keys import check_keys
from polydraulic.parameters.quantity import Quantity
from polydraulic.parameters.signals import Constant, Piecewise, Signal, Sine

DIRECTIONS = ("x", "y", "z")  # of the ground
_FORCE, _MASS, _TIME = Quantity("N"), Quantity("kg", low=0.0), Quantity("s", low=0.0)
_KINDS = {"constant": ("force",), "piecewise": ("time", "force"), "sine": ("amplitude", "omega")}


@dataclass(frozen=True)
class Payload:
    """Masses at the tip, each from its time on until the next; before the first there is none."""

    time: tuple[float, ...]  # s
    mass: tuple[float, ...]  # kg

    def __post_init__(self) -> None:
        if len(self.time) != len(self.mass) or not self.time:
            raise InputError(f"a payload needs one mass per time; got {len(self.time)} times, {len(self.mass)} masses")
        if any(a >= b for a, b in zip(self.time, self.time[1:], strict=False)):
            raise InputError(f"the times of a payload must rise; got {list(self.time)} s")


@dataclass(frozen=True)
class Loads:
    """All that acts at the tip.

    Attributes
    ----------
    force : mapping from "x", "y", "z" of the ground to Signal, in N
    payload : Payload or None
    """

    force: Mapping[str, Signal] = field(default_factory=dict)
    payload: Payload | None = None

    def forces(self, t: np.ndarray) -> np.ndarray:
        """Forces at the times `t`, (n_time, 3) in N."""
        return np.column_stack([self.force.get(direction, Constant())(t) for direction in DIRECTIONS])


def read_loads(data: Mapping[str, Any], path: Path) -> Loads:
    """Loads of a scenario file.

    Parameters
    ----------
    data : mapping
        The file; ``[force.x]`` with ``kind = "constant"`` and ``force``, ``"piecewise"`` with ``time`` and ``force``, or ``"sine"`` with
        ``amplitude`` and ``omega``; ``[payload]`` with lists ``time`` and ``mass``.
    path : Path
        For messages.

    Raises
    ------
    InputError
        Unknown or missing keys, wrong units or values.
    """
    force = data.get("force", {})
    check_keys(force, DIRECTIONS, (), "force", str(path))
    signals = {direction: _signal(item, f"force.{direction}", path) for direction, item in force.items()}
    return Loads(signals, _payload(data["payload"], path) if "payload" in data else None)


def _signal(item: Any, where: str, path: Path) -> Signal:
    kind = item.get("kind") if isinstance(item, Mapping) else None
    if kind not in _KINDS:
        raise InputError(f"{path}: {where}.kind = {kind!r}: must be one of {sorted(_KINDS)}")
    check_keys(item, ("kind", *_KINDS[kind]), _KINDS[kind], where, str(path))
    if kind == "sine":
        amplitude = read_quantity(item["amplitude"], _FORCE, f"{where}.amplitude", path)
        return Sine(amplitude, read_quantity(item["omega"], Quantity("rad/s"), f"{where}.omega", path))
    if kind == "constant":
        return Constant(read_quantity(item["force"], _FORCE, f"{where}.force", path))
    time = np.array(read_quantity(item["time"], _TIME, f"{where}.time", path, -1))
    values = np.array(read_quantity(item["force"], _FORCE, f"{where}.force", path, -1))
    try:
        return Piecewise(time, values)
    except InputError as error:
        raise InputError(f"{path}: {where}: {error}") from error


def _payload(item: Any, path: Path) -> Payload:
    check_keys(item, ("time", "mass"), ("time", "mass"), "payload", str(path))
    time = read_quantity(item["time"], _TIME, "payload.time", path, -1)
    mass = read_quantity(item["mass"], _MASS, "payload.mass", path, -1)
    try:
        return Payload(time, mass)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
