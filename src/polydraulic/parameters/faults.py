"""What faults make of a machine's numbers, of its payload, and of what its sensors read."""

from collections.abc import Iterable, Mapping, MutableMapping, Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.deviations import PAYLOAD, Deviation, Fault, TimedFault
from polydraulic.parameters.layout.schema import LayoutMachine

Since = Sequence[tuple[Fault, float]]  # how long each of them has been there, s; negative where it is not
_SAME = 1e-9  # s
_SAME_STEP = 1e-9  # of a step


class FaultyPart(NamedTuple):
    """A machine as it is from a time on.

    Attributes
    ----------
    begin : float, s
    machine : LayoutMachine
    payload : float, kg
        At its tip, of which nobody knows.
    """

    begin: float
    machine: LayoutMachine
    payload: float


def faulty_numbers(machine: LayoutMachine, since: Since) -> dict[str, float]:
    """Values of a machine with faults, for `LayoutMachine.with_values`; later faults act on what earlier ones leave.

    Parameters
    ----------
    machine : LayoutMachine
        Healthy.
    since : sequence of (Fault, s)
        How long each of them has been there; one that is not there, by a negative time, gives healthy values.

    Raises
    ------
    InputError
        A fault of a number that the machine does not have.
    """
    healthy = {number.path: number.value for number in machine.numbers}
    found: dict[str, float] = {}
    for fault, seconds in since:
        for deviation in fault.numbers:
            if deviation.of == PAYLOAD:
                continue
            if deviation.of not in healthy:
                raise InputError(f"fault {fault.name!r}: the machine has no number {deviation.of!r}")
            if deviation.how == "holds":
                raise InputError(
                    f"fault {fault.name!r}: {deviation.of} holds: readings do, numbers of a machine are constant"
                )
            found[deviation.of] = deviation.applied(found.get(deviation.of, healthy[deviation.of]), seconds)
    return found


def unknown_payload(since: Since) -> float:
    """What hangs at the tip besides what is known, kg."""
    found = 0.0
    for fault, seconds in since:
        for deviation in fault.numbers:
            if deviation.of == PAYLOAD:
                found = deviation.applied(found, seconds)
    return found


def faulty_machine(machine: LayoutMachine, since: Since) -> LayoutMachine:
    """The machine with the numbers that faults leave it.

    Raises
    ------
    InputError
        A number that the machine does not have, or that a fault drives beyond its range.
    """
    if not any(fault.numbers for fault, _ in since):  # to walk through all numbers of a machine takes milliseconds
        return machine
    values = faulty_numbers(machine, since)
    try:
        return machine.with_values(values)
    except InputError as error:
        names = ", ".join(dict.fromkeys(fault.name for fault, _ in since if fault.numbers))
        raise InputError(f"with the faults {names}: {error}") from error


def faulty_parts(machine: LayoutMachine, faults: Sequence[TimedFault], t_end: float) -> list[FaultyPart]:
    """A machine between the times at which its numbers, or its unknown payload, change; one part where they do not."""
    times = {t for timed in faults for t in timed.changes(timed.fault.numbers) if 0.0 < t < t_end}
    parts: list[FaultyPart] = []
    for t in sorted({0.0, *times}):
        since = [(timed.fault, timed.since(t + _SAME)) for timed in faults]
        part = FaultyPart(t, faulty_machine(machine, since), unknown_payload(since))
        if not parts or part[1:] != parts[-1][1:]:
            parts.append(part)
    return parts


def first_step(t: float, dt: float, n_step: int) -> int:
    """The first of so many steps that what happens at a time acts in."""
    return min(ceil(t / dt - _SAME_STEP), n_step)


def faulty_readings(
    readings: Mapping[str, float], since: Since, held: MutableMapping[tuple[str, str], float]
) -> dict[str, float]:
    """What sensors read, of columns as they are.

    Parameters
    ----------
    readings : mapping from column to value
    since : sequence of (Fault, s)
    held : mapping from names of a fault and a column to value
        What frozen sensors hold; kept here from call to call.

    Raises
    ------
    InputError
        A fault of a column that is not among them.
    """
    found = dict(readings)
    for fault, seconds in since:
        for deviation in fault.readings:
            if deviation.of not in found:
                raise InputError(f"fault {fault.name!r}: there is no reading {deviation.of!r}")
            value = deviation.applied(found[deviation.of], seconds)
            if deviation.how == "holds" and deviation.stage(seconds) > 0:
                value = held.setdefault((fault.name, deviation.of), value)
            elif deviation.how == "holds":
                held.pop((fault.name, deviation.of), None)
            found[deviation.of] = value
    return found


def faulty_column(
    column: str,
    time: np.ndarray,
    values: np.ndarray,
    faults: Sequence[TimedFault],
    held: MutableMapping[tuple[str, str], float],
) -> np.ndarray:
    """What a sensor reads over time, of a column as it is.

    Parameters
    ----------
    column : str
    time, values : (n_time,) arrays
    faults : sequence of TimedFault
    held : mapping from names of a fault and a column to value
        What frozen sensors hold, their last reading before; kept here from call to call, for faults that began before the first time.
    """
    found = values
    for timed in faults:
        for deviation in timed.fault.readings:
            if deviation.of == column:
                found = _deviating(deviation, timed, time, found, held)
    return found


def _deviating(
    deviation: Deviation,
    timed: TimedFault,
    time: np.ndarray,
    values: np.ndarray,
    held: MutableMapping[tuple[str, str], float],
) -> np.ndarray:
    column = deviation.of
    stage = np.array([deviation.stage(timed.since(t + _SAME)) for t in time.tolist()])
    there = stage > 0
    if not there.any():
        return values
    if deviation.how == "holds":
        key, last = (timed.fault.name, column), float(values[max(int(np.argmax(there)) - 1, 0)])
        if timed.begin >= 0.0:
            held.pop(key, None)  # what the same sensor held at another time
        value = held.setdefault(key, last)
        if not there[-1]:
            del held[key]
        return np.where(there, value, values)
    amount = np.array(deviation.amount)[np.maximum(stage, 1) - 1]
    changed = amount if deviation.how == "is" else values * amount if deviation.how == "times" else values + amount
    return np.where(there, changed, values)


def stages(since: Since) -> tuple[int, ...]:
    """Which amounts hold: as long as this is the same, so are the numbers."""
    return tuple(d.stage(seconds) for fault, seconds in since for d in fault.numbers)


def unread_faults(faults: Iterable[TimedFault], columns: Iterable[str]) -> list[str]:
    """Columns that faults let sensors misread and that nobody reads."""
    known = set(columns)
    return [d.of for timed in faults for d in timed.fault.readings if d.of not in known]
