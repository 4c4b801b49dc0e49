"""A log as its file holds it: signals in groups of common rows, read block by block."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings

BLOCK = 1 << 16  # rows


class Signal(NamedTuple):
    """A signal of a log.

    Attributes
    ----------
    name : str
    unit : str
        As the log gives it; empty if it gives none.
    group : int
        Signals of one group have common rows.
    kind : str
        ``"stamp"`` for dates, ``"clock"`` for times of day, ``"elapsed"`` for durations: these come in s, whatever a map says.
    beside : str
        Of a date or a time of day that stands alone: the signal that holds the other one, and is read with it.
    doubt : str
        A date that can be read in two ways, where nothing in the log says which.
    other_unit : str
        Another unit that the format allows the numbers to be in; a map may say which.
    """

    name: str
    unit: str
    group: int
    kind: str = ""
    beside: str = ""
    doubt: str = ""
    other_unit: str = ""


class LogBlock(NamedTuple):
    """Some rows of one group.

    Attributes
    ----------
    rows : (n_row,) array of int
        Their numbers in the file, data rows counted from 1.
    time : (n_row,) array or None
        In the log's unit of time; None where the log has no clock of its own and none was asked for.
    values : dict from name to (n_row,) array
        NaN where there is no value.
    text : dict from name to array of int
        Places in the block that hold something that is not a number.
    done : float
        Share of the group that has been read.
    """

    rows: np.ndarray
    time: np.ndarray | None
    values: dict[str, np.ndarray]
    text: dict[str, np.ndarray]
    done: float


Reader = Callable[[int, Sequence[str], str | None, Findings], Iterator[LogBlock]]


@dataclass(frozen=True)
class Log:
    """An opened log.

    Attributes
    ----------
    path : Path
    signals : list of Signal
        Each name once: the first where the file has it more than once.
    duplicates : list of str
        Names that the file has more than once.
    also : dict from str to Signal
        Other names that signals go by, such as the header's own text.
    left_out : dict from str to str
        What the file has and is not read, by name, with the reason.
    own_clock : bool
        Whether every group has a time of its own (MDF), in s.
    read : function (group, names, time, findings) -> iterator of Block
    close : function ()
        Lets go of what the log holds; a log is a context that does so at its end.
    began : float, s since 1970
        When the log's time was zero, by the clock on the wall; 0 where the file does not say.
    """

    path: Path
    signals: list[Signal]
    own_clock: bool
    read: Reader = field(repr=False)
    duplicates: list[str] = field(default_factory=list)
    close: Callable[[], None] = field(default=lambda: None, repr=False)
    began: float = 0.0
    also: dict[str, Signal] = field(default_factory=dict, repr=False)
    left_out: dict[str, str] = field(default_factory=dict, repr=False)

    def __enter__(self) -> "Log":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def signal(self, name: str) -> Signal:
        """Return the signal of a name, or raise an InputError that lists those there are."""
        for signal in self.signals:
            if signal.name == name:
                return signal
        if name in self.also:
            return self.also[name]
        left = next(
            (
                out
                for out in (name, *self.left_out)
                if out in self.left_out and re.match(rf"{re.escape(out)}([.\[/]|$)", name)
            ),
            None,
        )
        if left is not None:
            raise InputError(f"{self.path}: channel {name!r} cannot be read: {self.left_out[left]}")
        names = [s.name for s in self.signals]
        shown = f"{names[:30]}" + (f" and {len(names) - 30} more" if len(names) > 30 else "")
        raise InputError(f"{self.path}: no channel {name!r}; the log has {shown}")


def once(signals: list[Signal]) -> tuple[list[Signal], list[str]]:
    """Signals by name, the first of each, and the names that come more than once."""
    first: dict[str, Signal] = {}
    twice: dict[str, None] = {}
    for signal in signals:
        if signal.name in first:
            twice[signal.name] = None
        else:
            first[signal.name] = signal
    return list(first.values()), list(twice)


def by_reason(left_out: dict[str, str], most: int = 5) -> str:
    """Parts of a log that are not read, by reason."""
    names: dict[str, list[str]] = {}
    for name, reason in left_out.items():
        names.setdefault(reason, []).append(name)
    parts = [
        f"{', '.join(map(repr, group[:most]))}{f' and {len(group) - most} more' if len(group) > most else ''} ({reason})"
        for reason, group in names.items()
    ]
    return "; ".join(parts[:most]) + (f"; and {len(parts) - most} more reasons" if len(parts) > most else "")
