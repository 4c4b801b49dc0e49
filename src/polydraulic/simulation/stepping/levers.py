"""What stands at the levers: voltages as an array or by name, and what is refused of them."""

from collections.abc import Collection, Mapping, Sequence
from math import ceil, isfinite
from typing import Any

import numpy as np

from polydraulic.display import amount
from polydraulic.errors import InputError, briefly
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.input_check import BEYOND, full_lever
from polydraulic.simulation.layout.methods.event_log import event_limits
from polydraulic.simulation.layout.seen import seen_limits
from polydraulic.simulation.stepping.marks import Hand

LONGEST_DELAY = 100_000  # steps of a dead time, each of which is remembered


def hand_of(machine: LayoutMachine, dt: float, locked: Collection[str]) -> Hand:
    """What a machine makes of levers that stand still during each step of `dt` seconds; dead times are rounded up to whole steps.

    Raises
    ------
    InputError
        A dead time of more steps than `LONGEST_DELAY`.
    """
    wait = [max(ceil(f.pilot.dead_time / dt - 1e-9), 0) for f in machine.functions]
    for f, steps in zip(machine.functions, wait, strict=True):
        if steps > LONGEST_DELAY:
            raise InputError(
                f"functions.{f.name}.pilot.dead_time = {f.pilot.dead_time:g} s: is {steps} steps of {dt:g} s; at most {LONGEST_DELAY} are "
                "remembered: use longer steps"
            )
    return Hand(
        np.array([BEYOND * full_lever(f) for f in machine.functions]),
        np.array([int(name not in locked) for name in machine.names], dtype=np.int64),
        np.array(wait, dtype=np.int64),
        event_limits(machine),
        seen_limits(machine),
    )


def named_voltages(inputs: Mapping[str, Any], names: Sequence[str], locked: Collection[str]) -> list[Any]:
    """Voltages in the order of the functions; those that are not named get 0 V.

    Raises
    ------
    InputError
        A function that the machine does not have, or that is locked.
    """
    for name in inputs:
        if name not in names:
            raise InputError(f"inputs name {briefly(name)}, which the machine does not have; it has {list(names)}")
        if name in locked:
            raise InputError(
                f"inputs name {name}, which is locked; leave it out, or build the simulator without locking it"
            )
    return [inputs.get(name, 0.0) for name in names]


def lever_voltages(inputs: Any, names: Sequence[str], shape: tuple[int, ...]) -> np.ndarray:
    """Voltages as an array of floats in the order of the functions, one row a machine where there are many.

    Raises
    ------
    InputError
        Anything but numbers, or of another shape.
    """
    try:
        found = np.asarray(inputs)
    except ValueError:  # rows of several lengths
        found = np.empty(0, dtype=object)
    if found.dtype.kind not in "fiu":
        raise InputError(
            f"inputs = {briefly(inputs)}: must be numbers in V, in the order {', '.join(names)}, or a mapping of names to V"
        )
    if found.shape != shape:
        raise InputError(
            f"inputs have the shape {found.shape}; the machine is moved by {', '.join(names)}: give {shape}"
        )
    return found.astype(np.float64)


def refused(function: MachineFunction, value: float, where: str = "") -> InputError:
    """Say why a voltage is refused."""
    full = full_lever(function)
    if not isfinite(value):
        return InputError(f"{function.name}{where}: the lever's voltage is {value}; it must be a number in V")
    return InputError(
        f"{function.name}{where}: the lever's voltage is {amount(value, 'V')}; {amount(full, 'V')} gives full travel, and at most "
        f"{amount(BEYOND * full, 'V')} to either side is taken: check its unit"
    )
