"""Faults: numbers of a machine, or what its sensors read, that change with time and have a name in common."""

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite, radians
from typing import Literal

from polydraulic.errors import InputError
from polydraulic.parameters.layout.parts import CylinderSize
from polydraulic.parameters.layout.schema import LayoutMachine

How = Literal["times", "plus", "is"]
_HOWS = ("times", "plus", "is")


@dataclass(frozen=True)
class Deviation:
    """How one number, or one reading, differs from what it should be.

    Attributes
    ----------
    of : str
        Path of a number (``circuits.main.pump.flow``), or column that a sensor reads (``boom.angle``).
    how : {"times", "plus", "is"}
        What is done with the healthy value.
    amount : tuple of float
        SI. Each holds from its time on until the next; before the first the value is healthy.
    time : tuple of float, s
        Since the fault began.

    Raises
    ------
    InputError
        Amounts and times that do not go together, or are no finite numbers.
    """

    of: str
    how: How
    amount: tuple[float, ...]
    time: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        where = f"fault of {self.of}"
        if self.how not in _HOWS:
            raise InputError(f"{where}: how = {self.how!r}: must be one of {list(_HOWS)}")
        if len(self.time) != len(self.amount) or not self.time:
            raise InputError(f"{where}: needs one amount per time; got {len(self.time)} and {len(self.amount)}")
        if not all(map(isfinite, (*self.time, *self.amount))):
            raise InputError(f"{where}: times and amounts must be finite numbers")
        if self.time[0] < 0.0 or any(a >= b for a, b in zip(self.time, self.time[1:], strict=False)):
            raise InputError(f"{where}: times must rise from 0 on; got {list(self.time)} s")

    def stage(self, since: float) -> int:
        """How many of the times have come, so many seconds after the beginning."""
        return bisect_right(self.time, since)

    def applied(self, healthy: float, since: float) -> float:
        """What becomes of a healthy value."""
        stage = self.stage(since)
        if stage == 0:
            return healthy
        amount = self.amount[stage - 1]
        return amount if self.how == "is" else healthy * amount if self.how == "times" else healthy + amount


@dataclass(frozen=True)
class Fault:
    """Deviations that begin together.

    Attributes
    ----------
    name : str
    title : str
        What people read.
    numbers : tuple of Deviation
        Of the machine.
    readings : tuple of Deviation
        Of sensors.
    """

    name: str
    title: str
    numbers: tuple[Deviation, ...] = ()
    readings: tuple[Deviation, ...] = ()


def faulty_numbers(machine: LayoutMachine, since: Mapping[Fault, float]) -> dict[str, float]:
    """Values of a machine with faults, for `LayoutMachine.with_values`; later faults act on what earlier ones leave.

    Parameters
    ----------
    machine : LayoutMachine
        Healthy.
    since : mapping from Fault to s
        How long each of them has been there; one that is over, by a negative time, gives healthy values.

    Raises
    ------
    InputError
        A fault of a number that the machine does not have.
    """
    healthy = {number.path: number.value for number in machine.numbers}
    found: dict[str, float] = {}
    for fault, seconds in since.items():
        for deviation in fault.numbers:
            if deviation.of not in healthy:
                raise InputError(f"fault {fault.name!r}: the machine has no number {deviation.of!r}")
            found[deviation.of] = deviation.applied(found.get(deviation.of, healthy[deviation.of]), seconds)
    return found


def faulty_readings(readings: Mapping[str, float], since: Mapping[Fault, float]) -> dict[str, float]:
    """What sensors read, of columns as they are.

    Raises
    ------
    InputError
        A fault of a column that is not among them.
    """
    found = dict(readings)
    for fault, seconds in since.items():
        for deviation in fault.readings:
            if deviation.of not in found:
                raise InputError(f"fault {fault.name!r}: there is no reading {deviation.of!r}")
            found[deviation.of] = deviation.applied(found[deviation.of], seconds)
    return found


def stages(since: Mapping[Fault, float]) -> tuple[int, ...]:
    """Which amounts hold: as long as this is the same, so are the numbers."""
    return tuple(d.stage(seconds) for fault, seconds in since.items() for d in fault.numbers)


def usual_faults(machine: LayoutMachine) -> tuple[Fault, ...]:
    """A few faults that any machine may have: worn pumps, low relief valves, friction, weak valves, lines that leak, sensors that err."""
    return (*_of_pumps(machine), *_of_functions(machine), *_of_sensors(machine))


def _of_pumps(machine: LayoutMachine) -> Iterable[Fault]:
    for c in machine.circuits:
        of = f"circuits of {c.name}" if len(machine.circuits) > 1 else "the pump"
        yield Fault(
            f"{c.name} pump flow low", f"flow of {of} 10 % low", (Deviation(f"{c.pump_path}.flow", "times", (0.9,)),)
        )
        yield Fault(
            f"{c.name} relief low", f"relief of {of} 30 % low", (Deviation(f"{c.pump_path}.relief", "times", (0.7,)),)
        )


def _of_functions(machine: LayoutMachine) -> Iterable[Fault]:
    for f in machine.functions:
        where, kind = f"functions.{f.name}", "cylinder" if isinstance(f.drive, CylinderSize) else "motor"
        rubbing = tuple(
            Deviation(f"{where}.friction.{part}", "times", (3.0,)) for part in ("coulomb", "static", "viscous")
        )
        yield Fault(f"{f.name} friction high", f"friction of {f.name} three times as high", rubbing)
        yield Fault(
            f"{f.name} valve weak",
            f"spool of {f.name}'s {kind} moves a fifth less",
            (Deviation(f"{where}.pilot.gain", "times", (0.8,)),),
        )
        yield Fault(
            f"{f.name} leaks",
            f"lines of {f.name} lose 4 l/min at 200 bar",
            (Deviation(f"{where}.line.leakage", "plus", (4.0 / 60e3 / 200e5,)),),
        )


def _of_sensors(machine: LayoutMachine) -> Iterable[Fault]:
    """Of joints, which coordinated control reads, by the columns of a state: ``NAME.angle`` whatever the joint."""
    for f in machine.functions:
        slides = machine.link(f.moves).joint == "prismatic"
        error, said = (0.05, "50 mm") if slides else (radians(3.0), "3 deg")
        yield Fault(
            f"{f.name} sensor off",
            f"position sensor of {f.name} reads {said} too much (for coordinated control)",
            readings=(Deviation(f"{f.name}.angle", "plus", (error,)),),
        )
