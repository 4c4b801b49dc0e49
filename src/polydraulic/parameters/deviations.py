"""Faults as data: numbers of a machine, or what its sensors read, that change with time and have a name in common; and when they are there."""

import re
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from numbers import Real
from typing import Any, Literal, NamedTuple

from polydraulic.display import amount, readable
from polydraulic.errors import InputError, briefly
from polydraulic.units import read_unit

PAYLOAD = "payload"  # what hangs at the tip and nobody knows of, kg: healthy 0, no number of a machine file
UNKNOWN_PAYLOAD = "tip.payload_unknown"  # the one fault whose size is no share
STAGES = 20  # of a fault that grows
LATEST = 1e9  # s
How = Literal["times", "plus", "is", "holds"]
_HOWS = ("times", "plus", "is", "holds")
_TEXT = re.compile(
    r"(?P<name>\S+)(?:\s+(?P<size>(?!from\b|to\b|over\b)\S.*?))??(?:\s+from\s+(?P<begin>.+?))?(?:\s+to\s+(?P<end>.+?))?(?:\s+over\s+(?P<growth>.+?))?"
)
_AMOUNT = re.compile(r"(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?P<unit>\S*)")


@dataclass(frozen=True)
class Deviation:
    """How one number, or one reading, differs from what it should be.

    Attributes
    ----------
    of : str
        Path of a number (``circuits.main.pump.flow``), ``payload``, or column that a sensor reads (``boom.angle``).
    how : {"times", "plus", "is", "holds"}
        What is done with the healthy value; ``"holds"``, of readings alone: it stays what it was when the fault began, whatever the amount.
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
        if not (isinstance(self.amount, Sequence) and isinstance(self.time, Sequence)):
            raise InputError(f"{where}: amounts and times must be tuples, for example ({self.amount},)")
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
        """What becomes of a healthy value; of one that holds, the value that it had at the beginning is the healthy one."""
        stage = self.stage(since)
        if stage == 0 or self.how == "holds":
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
        Of the machine, and of its payload.
    readings : tuple of Deviation
        Of sensors.
    """

    name: str
    title: str
    numbers: tuple[Deviation, ...] = ()
    readings: tuple[Deviation, ...] = ()


class TimedFault(NamedTuple):
    """A fault that is there from a time on until another, s."""

    fault: Fault
    begin: float
    end: float = inf

    def __str__(self) -> str:
        end = f" to {readable(self.end, 9)} s" if self.end < inf else ""
        return f"{self.fault.name} from {readable(self.begin, 9)} s{end}: {self.fault.title}"

    def after(self, seconds: float) -> "TimedFault":
        """The same, its times counted from another moment."""
        return self._replace(begin=self.begin - seconds, end=self.end - seconds)

    def since(self, t: float) -> float:
        """How long it has been there, s; negative if it is not there."""
        return t - self.begin if t < self.end else -1.0

    def changes(self, of: Iterable[Deviation]) -> list[float]:
        """Times at which some of its deviations change, s."""
        stages = {self.begin + s for deviation in of for s in deviation.time}
        return sorted({t for t in stages if t < self.end} | ({self.end} if self.end < inf and stages else set()))


@dataclass(frozen=True)
class ScheduledFault:
    """A fault that is to happen: which one, how large, from when to when.

    Attributes
    ----------
    fault : str or Fault
        Name of one in the machine's catalogue, ``boom.pump_worn``, or one of your own.
    size : float, optional
        SI: a share (0.05 for 5 %), or kg; the catalogue's if not given. A fault of your own has its size in its numbers.
    begin, end : float, s
    growth : float, s, optional
        Over which it grows to its size, in `STAGES` stages; at once if 0, as the catalogue says if not given.

    Raises
    ------
    InputError
        Times that cannot be; what is no number; a size or growth of a fault of your own.

    Examples
    --------
    >>> worn = ScheduledFault("boom.pump_worn", 0.1, begin=60.0, growth=300.0)
    >>> str(worn)
    'boom.pump_worn 10 % from 60 s over 300 s'
    >>> scheduled("boom.pump_worn 10 % from 1 min over 300 s") == worn
    True
    """

    fault: str | Fault
    size: float | None = None
    begin: float = 0.0
    end: float = inf
    growth: float | None = None

    def __post_init__(self) -> None:
        where = f"fault {self.name!r}"
        for key, given in (("size", self.size), ("begin", self.begin), ("end", self.end), ("growth", self.growth)):
            if given is not None and (isinstance(given, bool) or not isinstance(given, Real)):
                raise InputError(f"{where}: {key} = {briefly(given)}: must be a number in SI, without a unit")
        for key, value in (("begin", self.begin), ("growth", 0.0 if self.growth is None else self.growth)):
            if not 0.0 <= value <= LATEST:
                raise InputError(f"{where}: {key} = {value} s: must lie in [0, {LATEST:g}] s")
        if not (self.end > self.begin and (self.end <= LATEST or self.end == inf)):
            raise InputError(f"{where}: end = {self.end} s: must be later than its beginning, {self.begin:g} s")
        if isinstance(self.fault, Fault) and (self.size is not None or self.growth is not None):
            raise InputError(f"{where}: size and growth are those of its numbers; leave them out here")

    @property
    def name(self) -> str:
        """Of the fault."""
        return self.fault.name if isinstance(self.fault, Fault) else str(self.fault)

    def __str__(self) -> str:
        size = "" if self.size is None else f" {shown_size(self.size, size_unit(self.name))}"
        end = f" to {readable(self.end, 9)} s" if self.end < inf else ""
        growth = f" over {readable(self.growth, 9)} s" if self.growth is not None else ""
        return f"{self.name}{size} from {readable(self.begin, 9)} s{end}{growth}"


def size_unit(name: str) -> str:
    """SI unit of the size of a fault, by its name: a share, or kg."""
    return "kg" if name == UNKNOWN_PAYLOAD else "1"


def shown_size(size: float, unit: str) -> str:
    """A size as people read and write it."""
    return f"{readable(100.0 * size)} %" if unit == "1" else amount(size, unit)


def scheduled(text: "str | Fault | ScheduledFault") -> ScheduledFault:
    """Read when a fault is there: ``NAME [SIZE] [from TIME] [to TIME] [over TIME]``, sizes and times with their units.

    Parameters
    ----------
    text : str, Fault or ScheduledFault
        A fault of your own begins at 0.

    Raises
    ------
    InputError
        What is no such text: which part, and what is allowed.

    Examples
    --------
    >>> scheduled("boom.pump_worn").begin, scheduled("lift.leak_out 5 % from 10 s to 20 s").size
    (0.0, 0.05)
    """
    if isinstance(text, ScheduledFault):
        return text
    if isinstance(text, Fault):
        return ScheduledFault(text)
    match = _TEXT.fullmatch(text.strip()) if isinstance(text, str) else None
    if match is None:
        raise InputError(
            f"fault {briefly(text)}: must be NAME [SIZE] [from TIME] [to TIME] [over TIME], "
            "for example 'boom.pump_worn 10 % from 60 s over 300 s'"
        )
    given = match.groupdict()
    found = ScheduledFault(given["name"])
    if given["size"] is not None:
        found = replace(found, size=_amount(given["size"], size_unit(found.name), f"fault {text!r}: size"))
    times: dict[str, Any] = {
        key: _amount(given[key], "s", f"fault {text!r}: {key}") for key in ("begin", "end", "growth") if given[key]
    }
    return replace(found, **times)


def _amount(text: str, kind: str, where: str) -> float:
    """A number with its unit, in SI."""
    match = _AMOUNT.fullmatch(text.strip())
    example = {"s": "60 s", "kg": "300 kg"}.get(kind, "10 %")
    if match is None or not match["unit"]:
        raise InputError(f"{where} = {briefly(text)}: must be a number with its unit, for example {example}")
    try:
        unit = read_unit(match["unit"])
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
    if unit.si != kind:
        raise InputError(f"{where} = {text!r}: must be a number with its unit, for example {example}")
    return unit.to_si(float(match["number"]))
