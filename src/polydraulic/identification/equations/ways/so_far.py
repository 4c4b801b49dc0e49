"""What has been found so far: new values of entries, what kept its value and why, what is known only together with others."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.equations.free_numbers import CURVES, Freedom
from polydraulic.identification.equations.identified_file import Identified
from polydraulic.identification.equations.numbers.estimates import Estimate, Estimates
from polydraulic.parameters.layout.parts import Seen
from polydraulic.parameters.layout.schema import LayoutMachine

_TOGETHER = (".inertia", ".friction")  # of which one number bounds another
_MECHANICAL = ("mass", "cg", "inertia")


@dataclass
class SoFar:
    """An identification on its way, which each way adds to.

    Attributes
    ----------
    machine : LayoutMachine
        With what has been found.
    may : Freedom
        What may be changed.
    from_log : str
        Where new values come from.
    changes : dict from path to Identified
    kept, remarks : list of str
        What kept its value, and why; what is determined, and what is not.
    lacks : dict
        What a way could not do, and why.
    seen : dict from function to Seen
        How far the log went, of valves whose curves were found.
    """

    machine: LayoutMachine
    may: Freedom
    from_log: str
    changes: dict[str, Identified] = field(default_factory=dict)
    kept: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    lacks: dict[str, str] = field(default_factory=dict)
    seen: dict[str, Seen] = field(default_factory=dict)

    def found(self) -> LayoutMachine:
        """The machine with all that was found."""
        of = self.machine.functions
        return self.machine._replace(functions=tuple(f._replace(seen=self.seen.get(f.name, f.seen)) for f in of))

    def declare(self, function: str, **effects: Any) -> None:
        """Let a function have other effects, values as in `Effects`."""
        of = self.machine.functions
        new = (f._replace(effects=f.effects._replace(**effects)) if f.name == function else f for f in of)
        self.machine = self.machine._replace(functions=tuple(new))

    def take(self, changes: dict[str, Identified]) -> None:
        """Take new values of entries."""
        self.changes |= changes
        self.machine = self.machine.with_values({path: new.value for path, new in changes.items()})

    def take_estimates(self, estimates: Estimates, source: str) -> None:
        """Take estimates around the values so far: what hardly shows keeps its value, what shows only together with others is named."""
        before = {number.path: number.value for number in self.machine.numbers}
        of = {e.path: e for e in estimates.numbers}
        whole: dict[str, list[str]] = {}
        for path in before:
            whole.setdefault(path.partition("[")[0], []).append(path)
        changes, moved = {}, set[str]()
        for entry in dict.fromkeys(path.partition("[")[0] for path in of):
            paths = whole[entry]
            if all(path not in of or of[path].hidden for path in paths):
                continue
            kept = {p for p in paths if p not in of or of[p].hidden}
            if not _in_order(entry, [before[p] if p in kept else of[p].value for p in paths]):
                moved |= {p for p in kept if p in of}
                kept -= moved
            values = tuple(before[p] if p in kept else of[p].value for p in paths)
            errors = tuple(0.0 if p not in of else np.inf if p in kept else of[p].sd for p in paths)
            many = paths != [entry]
            changes[entry] = Identified(values if many else values[0], errors if many else errors[0], source)
        along = self._along(changes, {e.path: e for e in estimates.numbers if e.hidden}, source)
        self.take(changes | along)
        hidden = [e.path for e in estimates.numbers if e.hidden]
        self.kept += [
            f"{path}: kept; it hardly shows in this log" for path in hidden if path not in along and path not in moved
        ]
        self.remarks += [
            f"{path} hardly shows in this log; its value was not possible beside the others that were found, and moved with them"
            for path in hidden
            if path in along or path in moved
        ]
        self.remarks += [line for line in estimates.trades if not of[line.partition(" ")[0]].hidden]

    def _along(self, changes: dict[str, Identified], hidden: dict[str, Estimate], source: str) -> dict[str, Identified]:
        """What hardly shows, but without which the machine would be impossible: moments of a link, dry friction of a joint."""
        along: dict[str, Identified] = {}
        for table in dict.fromkeys(path.rpartition(".")[0] for path in changes):
            if not table.endswith(_TOGETHER):
                continue
            own = {path: new.value for path, new in changes.items() if path.rpartition(".")[0] == table}
            try:
                self.machine.with_values(own)
            except InputError:
                along |= {
                    path: Identified(e.value, e.sd, source)
                    for path, e in hidden.items()
                    if path.rpartition(".")[0] == table and not path.endswith(".viscous")
                }
        return along


def _in_order(entry: str, values: Sequence[float]) -> bool:
    """Whether values at the knots of a curve rise, or fall if it is a bypass; true of any other entry."""
    if entry.rpartition(".")[2] not in CURVES:
        return True
    way = -1.0 if entry.endswith(".bypass") else 1.0
    return bool(np.all(way * np.diff(values) >= 0.0))


def is_mechanical(path: str) -> bool:
    """Whether an entry is a mass, a centre of gravity, an inertia, or friction."""
    parts = path.split(".")
    return (parts[0] == "links" and parts[2] in _MECHANICAL) or (parts[0] == "functions" and parts[2] == "friction")
