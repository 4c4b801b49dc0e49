"""What pushes and hangs at the tip of a machine that is moved step by step: as scenarios say it, or as it is from now on."""

from collections.abc import Mapping
from math import ceil, isfinite
from typing import Any

from polydraulic.errors import InputError, briefly
from polydraulic.parameters.loads import DIRECTIONS, Loads, Payload
from polydraulic.parameters.signals import Constant

PAYLOAD = "payload"


def as_loads(load: Loads | Mapping[str, float] | None, before: Loads | None = None) -> Loads:
    """Return loads that are given, or those of a mapping; what a mapping does not name stays as it was.

    Parameters
    ----------
    load : Loads, or mapping, or None
        Of ``"x"``, ``"y"``, ``"z"`` (force along the ground's axes, N) and ``"payload"`` (kg), constant from now on.
    before : Loads, optional

    Raises
    ------
    InputError
        Other names, or values that are not usable.
    """
    if load is None or isinstance(load, Loads):
        return load or Loads()
    before = before or Loads()
    if not isinstance(load, Mapping):
        raise InputError(
            f"load = {briefly(load)}: must be a mapping with {', '.join(DIRECTIONS)} in N and {PAYLOAD} in kg, or Loads"
        )
    for name, value in load.items():
        if name not in (*DIRECTIONS, PAYLOAD):
            raise InputError(f"load names {briefly(name)}: must be one of {[*DIRECTIONS, PAYLOAD]}")
        finite_number(
            value, f"load: {name}", low=0.0 if name == PAYLOAD else None, unit="kg" if name == PAYLOAD else "N"
        )
    force = {name: Constant(float(value)) for name, value in load.items() if name != PAYLOAD}
    payload = Payload((0.0,), (float(load[PAYLOAD]),)) if PAYLOAD in load else before.payload
    return Loads({**before.force, **force}, payload)


def check_kept(new: Loads, first: Loads) -> None:
    """Refuse loads for which a machine was not built.

    Raises
    ------
    InputError
    """
    for what, given, built in (
        ("a force at the tip", new.force, first.force),
        ("a payload", new.payload is not None, first.payload is not None),
    ):
        if given and not built:
            example = '{"x": 0.0}' if what.startswith("a force") else '{"payload": 0.0}'
            raise InputError(
                f"load: has {what}, for which this simulator was not built; build it with load={example}, or with one that has it"
            )


def mass_at(payload: Payload | None, step: int, dt: float) -> tuple[float, int | None]:
    """Mass in kg that hangs at the tip during a step, and the step from which there is another; changes happen at the next whole step."""
    mass = 0.0
    for time, now in zip(payload.time, payload.mass, strict=True) if payload is not None else ():
        begin = ceil(time / dt - 1e-9)
        if begin > step:
            return mass, begin
        mass = now
    return mass, None


def finite_number(value: Any, what: str, *, low: float | None, unit: str) -> float:
    """A finite number.

    Raises
    ------
    InputError
    """
    try:
        found = float(value)
    except (TypeError, ValueError):
        found = float("nan")
    if not isfinite(found) or (low is not None and found < low):
        least = "" if low is None else f", at least {low:g} {unit}"
        raise InputError(f"{what} = {briefly(value)}: must be a finite number in {unit}{least}")
    return found
