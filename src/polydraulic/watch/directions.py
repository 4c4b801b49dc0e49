"""What each fault would do to the residuals of a log: the machine of the catalogue's fault in place of the healthy one.

A direction is the smallest size of a fault that counts; residuals are linear enough in it that larger ones lie on it, too.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.parameters.deviations import PAYLOAD
from polydraulic.parameters.fault_catalogue import FaultKind, fault_catalogue
from polydraulic.parameters.faults import faulty_machine
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.watch.residuals import Case, case_of

_BOTH = ("bias",)  # kinds that go either way
_SAME = ("drift",)  # that look as another kind does at any time
_BY_RUNS = ("freeze",)  # that no residual is needed for
_BY_SIZE = ("pump_relief_low", "line_relief_low")  # that show near a setting alone: each size is a direction of its own
_STICKS = 0.05  # of the spool's travel
COLD = "oil.cold"
_COLD_FRICTION = 1.0


class Direction(NamedTuple):
    """A fault, or a condition, that a log may show.

    Attributes
    ----------
    name, title : str
        As of the catalogue; ``{}`` stands where its size does.
    kind : str
        Part of the name behind the last dot.
    case : Case
        The machine with it.
    size : float
        For which `case` is made.
    unit : str
        Of the size: ``1`` or ``kg``.
    both : bool
        Whether it goes either way.
    harmless : bool
        Whether it is no fault but unusual work: a payload, cold oil.
    """

    name: str
    title: str
    kind: str
    case: Case
    size: float
    unit: str
    both: bool
    harmless: bool

    @property
    def smallest(self) -> str:
        """Title with the size."""
        return self.title.format(f"{100.0 * self.size:.3g} %" if self.unit == "1" else f"{self.size:.3g} {self.unit}")


def directions_of(machine: LayoutMachine, columns: frozenset[str]) -> tuple[Direction, ...]:
    """Directions of a machine whose log has these columns."""
    found = []
    for fault in fault_catalogue(machine):
        kind = fault.name.rpartition(".")[2]
        if kind in (*_SAME, *_BY_RUNS) or not {change.of for change in fault.readings} <= columns:
            continue
        least = min(map(abs, fault.sizes)) if fault.sizes else None
        found += [_direction(machine, fault, kind, size) for size in (fault.sizes if kind in _BY_SIZE else [least])]
    known = {d.name for d in found}
    sticking = [d for f in machine.functions if (d := _sticks(machine, f)).name not in known]
    return (*found, *sticking, _cold_oil(machine))


def _direction(machine: LayoutMachine, kind: FaultKind, last: str, size: float | None) -> Direction:
    fault = kind.fault(size, 0.0) if size is not None else kind.fault()
    payload = sum(d.amount[-1] for d in fault.numbers if d.of == PAYLOAD)
    shifts = {d.of: d.amount[-1] for d in fault.readings}
    changed = faulty_machine(machine, [(fault, 0.0)])
    return Direction(
        kind.name, kind.title(size) if last in _BY_SIZE else kind.words, last, case_of(changed, payload, shifts), size or 1.0,
        kind.quantity.unit, last in _BOTH, last == "payload_unknown",
    )  # fmt: skip


def _sticks(machine: LayoutMachine, f: MachineFunction) -> Direction:
    """A spool that sticks, of a machine whose file knows of no hysteresis."""
    late = _STICKS * f.valve.knots[-1]
    sticky = f._replace(effects=f.effects._replace(hysteresis=late + (f.effects.hysteresis or 0.0)))
    changed = machine._replace(functions=tuple(sticky if g.name == f.name else g for g in machine.functions))
    title = f"spool of {f.name} sticks: it follows {{}} of its travel late"
    return Direction(f"{f.name}.spool_sticks", title, "spool_sticks", case_of(changed), _STICKS, "1", False, False)


def _cold_oil(machine: LayoutMachine) -> Direction:
    thick = {
        f"functions.{f.name}.friction.viscous": (1.0 + _COLD_FRICTION) * f.friction.viscous for f in machine.functions
    }
    return Direction(
        COLD, "oil cold: viscous friction of all joints {} higher", "cold", case_of(machine.with_values(thick)), _COLD_FRICTION, "1",
        False, True,
    )  # fmt: skip


class Scores(NamedTuple):
    """What blocks say of every direction, from residuals r, effects S of the directions, and variances v.

    Attributes
    ----------
    pull : (n_block, n_direction) array
        Sum of S r / v.
    information : (n_block, n_direction, n_direction) array
        Sum of S S' / v.
    """

    pull: np.ndarray
    information: np.ndarray
