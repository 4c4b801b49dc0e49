"""Names of signals where a log has groups: plain where they are the only one, ``group/name`` for all."""

from collections.abc import Sequence
from typing import NamedTuple

from polydraulic.measure.formats.log import Signal


class GroupName(NamedTuple):
    """How a group is called, and what else it answers to."""

    label: str
    others: tuple[str, ...] = ()


class Named(NamedTuple):
    """Signals of several groups by name.

    Attributes
    ----------
    signals : list of Signal
        All of them. The first of a name has it as it is, the others are ``group/name``.
    duplicates : list of str
        Names that come more than once.
    also : dict from str to Signal
        Other names that may be asked for.
    origin : dict from str to int
        Place in the list given, of all names.
    """

    signals: list[Signal]
    duplicates: list[str]
    also: dict[str, Signal]
    origin: dict[str, int]


def in_groups(found: Sequence[Signal], groups: Sequence[GroupName]) -> Named:
    """Give each signal a name of its own.

    Parameters
    ----------
    found : sequence of Signal
        As the file has them.
    groups : sequence of GroupName
        By the number of the group.
    """
    signals: list[Signal] = []
    twice: dict[str, None] = {}
    also: dict[str, Signal] = {}
    origin: dict[str, int] = {}
    plain = {signal.name for signal in found}
    for n, signal in enumerate(found):
        label = groups[signal.group].label
        full, number = f"{label}/{signal.name}", 1
        if full in origin or full in plain:  # groups of one name
            full = f"{label} {signal.group}/{signal.name}"
        while full in origin or full in plain:
            number += 1
            full = f"{label} {signal.group}/{signal.name}[{number}]"
        if signal.name in origin:
            twice[signal.name] = None
            signals.append(signal._replace(name=full))
        else:
            origin[signal.name] = n
            signals.append(signal)
            also[full] = signal
        origin[full] = n
    known = {signal.name for signal in signals}
    for n, signal in enumerate(found):
        for other in (groups[signal.group].label, *groups[signal.group].others, str(signal.group)):
            name = f"{other}/{signal.name}"
            if name not in known and name not in origin:
                also[name], origin[name] = signals[n], n
    return Named(signals, list(twice), also, origin)
