"""The faults that a machine can have, each with its usual size: one catalogue for runs, logs, batches and the cockpit."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

from polydraulic.errors import InputError
from polydraulic.parameters.deviations import (
    PAYLOAD,
    STAGES,
    UNKNOWN_PAYLOAD,
    Deviation,
    Fault,
    How,
    ScheduledFault,
    TimedFault,
    scheduled,
    shown_size,
)
from polydraulic.parameters.layout.parts import MachineFunction, PumpParameters, SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine, position_column, position_columns
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.quantity import Quantity

_AT = 200e5  # Pa, at which leaks are stated
_NEVER = 1e9  # Pa, a torque limit that begins here never does
_DRIFT = 600.0  # s over which a sensor drifts if nothing else is said
_LESS = Quantity("1", above=0.0, high=0.9)  # of something that falls
_MORE = Quantity("1", above=0.0, high=20.0)  # of something that rises
_SPAN = Quantity("1", low=-1.0, high=1.0)  # of a sensor's range
_MASS = Quantity("kg", above=0.0, high=1e6)
_USUAL_PAYLOAD = 0.05  # of the mass of all links


class Change(NamedTuple):
    """How a number, or a reading, follows from the size of a fault: `base` + `per` times size is the amount of a `Deviation`."""

    of: str
    how: How
    base: float
    per: float


@dataclass(frozen=True)
class FaultKind:
    """A fault that a machine can have.

    Attributes
    ----------
    name : str
        ``boom.pump_worn``: what it is of, and what it is.
    words : str
        What changes; ``{}`` stands where its size does.
    sizes : tuple of float
        Usual ones, SI: shares (0.05 for 5 %) or kg; the first is taken if none is given. Empty for what is there or not.
    quantity : Quantity
        Unit of the size, and the range it may lie in.
    numbers, readings : tuple of Change
        Of the machine, and of sensors.
    growth : float, s
        Over which it grows if nothing else is said.
    """

    name: str
    words: str
    sizes: tuple[float, ...]
    quantity: Quantity
    numbers: tuple[Change, ...] = ()
    readings: tuple[Change, ...] = ()
    growth: float = 0.0

    @property
    def size(self) -> float | None:
        """The usual size."""
        return self.sizes[0] if self.sizes else None

    def shown(self, size: float) -> str:
        """A size as people read it."""
        return shown_size(size, self.quantity.unit)

    def title(self, size: float | None = None) -> str:
        """What happens, with its size."""
        size = self.size if size is None else size
        return self.words if size is None else self.words.format(self.shown(size))

    def fault(self, size: float | None = None, growth: float | None = None) -> Fault:
        """The fault with a size.

        Parameters
        ----------
        size : float, optional
            SI; the usual one if not given.
        growth : float, s, optional
            Over which it grows to its size, in `STAGES` equal stages; as the catalogue says if not given.

        Raises
        ------
        InputError
            A size of what has none, or out of its range; growth of what is there or not.
        """
        if not self.sizes:
            if size is not None or growth:
                raise InputError(f"fault {self.name!r}: is there or not; it has no size, and does not grow")
        elif size is not None and not self.quantity.allows(size):
            raise InputError(f"fault {self.name!r}: size = {self.shown(size)}: must be {self._range()}")
        whole = (self.size or 0.0) if size is None else size
        over = self.growth if growth is None else growth
        sizes = [whole * k / STAGES for k in range(1, STAGES + 1)] if over > 0.0 else [whole]
        times = tuple(over * k / STAGES for k in range(1, STAGES + 1)) if over > 0.0 else (0.0,)

        def deviations(changes: tuple[Change, ...]) -> tuple[Deviation, ...]:
            return tuple(Deviation(c.of, c.how, tuple(c.base + c.per * s for s in sizes), times) for c in changes)

        return Fault(self.name, self.title(whole), deviations(self.numbers), deviations(self.readings))

    def _range(self) -> str:
        low, high = max(self.quantity.low, self.quantity.above), self.quantity.high
        return f"{'above' if self.quantity.above >= low else 'from'} {self.shown(low)} {'and at most' if self.quantity.above >= low else 'to'} {self.shown(high)}"


def fault_catalogue(machine: LayoutMachine | str | Path) -> tuple[FaultKind, ...]:
    """All faults that a machine can have: of its pumps, functions, payload and sensors.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set

    Examples
    --------
    >>> faults = {kind.name: kind for kind in fault_catalogue("wheel_loader")}
    >>> faults["work.pump_worn"].title()
    'pump of work worn: its flow is 5 % low'
    >>> faults["work.pump_worn"].sizes
    (0.05, 0.1, 0.2)
    """
    found = as_machine(machine)
    circuits = (kind for c in found.circuits for kind in _of_circuit(c))
    functions = (kind for f in found.functions for kind in _of_function(f, found))
    readings = (kind for column, span in reading_spans(found).items() for kind in _of_reading(column, span))
    return (*circuits, *functions, _of_tip(found), *readings)


def timed_faults(
    machine: LayoutMachine, faults: Iterable[str | Fault | ScheduledFault | TimedFault]
) -> tuple[TimedFault, ...]:
    """Faults of a machine as they are scheduled.

    Parameters
    ----------
    machine : LayoutMachine
    faults : iterable of str, Fault, ScheduledFault or TimedFault
        Texts as for `scheduled`; one that is timed stays as it is.

    Raises
    ------
    InputError
        A fault that the machine cannot have, with those that are near it; a size that it cannot have.
    """
    wanted = [one if isinstance(one, TimedFault) else scheduled(one) for one in faults]
    if not wanted:
        return ()
    known = {kind.name: kind for kind in fault_catalogue(machine)}
    found = []
    for one in wanted:
        if isinstance(one.fault, Fault):
            fault = one.fault
        elif one.fault in known:
            fault = known[one.fault].fault(one.size, one.growth)
        else:
            raise InputError(_unknown(one.fault, machine, list(known)))
        found.append(TimedFault(fault, one.begin, one.end))
    return tuple(found)


def as_list(
    faults: Iterable[str | Fault | ScheduledFault | TimedFault],
) -> list[str | Fault | ScheduledFault | TimedFault]:
    """Faults as a list; a single one, whose letters would be read as names, is refused."""
    if isinstance(faults, str | Fault | ScheduledFault | TimedFault):
        raise InputError(f"faults = {str(faults)!r}: must be a list, for example [{str(faults)!r}]")
    return list(faults)


def cockpit_faults(machine: LayoutMachine) -> tuple[FaultKind, ...]:
    """Those that show where nobody reads a log: of numbers, and of the positions that coordinated control reads."""
    joints = set(position_columns(machine))
    return tuple(
        kind
        for kind in fault_catalogue(machine)
        if kind.numbers or all(change.of in joints for change in kind.readings)
    )


def reading_spans(machine: LayoutMachine) -> dict[str, float]:
    """Columns that sensors read, and the range of such a sensor in SI.

    Joints go from stop to stop, spools and levers from end to end, pressures from zero to the relief setting, flows from zero to the pump's.
    """
    found: dict[str, float] = {}
    for f in machine.functions:
        travel, pump = f.valve.knots[-1], _pump_of(f, machine)
        found |= {
            position_column(machine, f): f.stops.high - f.stops.low,
            f"{f.name}.spool": 2.0 * travel,
            f"{f.name}.p_a": f.line.relief,
            f"{f.name}.p_b": f.line.relief,
            f"{f.name}.q_in": pump.flow,
            f"{f.name}.q_out": pump.flow,
            f"{f.name}.voltage": 2.0 * travel / f.pilot.gain,
        }
    return found | {f"{c.name}.p_pump": c.pump.relief for c in machine.circuits}


def _of_circuit(c: SupplyCircuit) -> Iterator[FaultKind]:
    name, pump = c.name, c.pump_path
    yield FaultKind(
        f"{name}.pump_worn", f"pump of {name} worn: its flow is {{}} low", (0.05, 0.1, 0.2), _LESS,
        (Change(f"{pump}.flow", "times", 1.0, -1.0),),
    )  # fmt: skip
    yield FaultKind(
        f"{name}.pump_relief_low", f"relief valve of the pump of {name} {{}} low", (0.1, 0.2, 0.3), _LESS,
        (Change(f"{pump}.relief", "times", 1.0, -1.0),),
    )  # fmt: skip
    if c.pump.torque_limit_enabled:
        yield FaultKind(
            f"{name}.torque_limit_off", f"torque limit of the pump of {name} does not act", (), _MORE,
            (Change(f"{pump}.torque_limit_start", "is", _NEVER, 0.0),),
        )  # fmt: skip


def _of_function(f: MachineFunction, machine: LayoutMachine) -> Iterator[FaultKind]:
    name, where, flow = f.name, f"functions.{f.name}", _pump_of(f, machine).flow
    yield FaultKind(
        f"{name}.leak_across", f"{name} leaks from line to line: {{}} of the pump's flow at 200 bar", (0.02, 0.05, 0.1), _LESS,
        (Change(f"{where}.line.leakage", "plus", 0.0, flow / _AT),),
    )  # fmt: skip
    yield FaultKind(
        f"{name}.leak_out", f"lines of {name} leak to the tank: {{}} of the pump's flow at 200 bar", (0.02, 0.05, 0.1), _LESS,
        (Change(f"{where}.line.external_leakage", "plus", 0.0, flow / _AT),),
    )  # fmt: skip
    yield FaultKind(
        f"{name}.line_relief_low", f"relief valves of {name}'s lines {{}} low", (0.1, 0.2, 0.3), _LESS,
        (Change(f"{where}.line.relief", "times", 1.0, -1.0),),
    )  # fmt: skip
    yield FaultKind(
        f"{name}.air_in_lines", f"air in {name}'s lines: they yield {{}} more", (1.0, 2.0, 5.0), _MORE,
        tuple(Change(f"{where}.line.compliance_{side}", "times", 1.0, 1.0) for side in "ab"),
    )  # fmt: skip
    yield FaultKind(
        f"{name}.spool_slow", f"spool of {name} slow: its time constant is {{}} longer", (1.0, 2.0, 4.0), _MORE,
        (Change(f"{where}.pilot.time_constant", "times", 1.0, 1.0),),
    )  # fmt: skip
    yield FaultKind(
        f"{name}.spool_weak", f"spool of {name} moves {{}} less", (0.2, 0.1, 0.4), _LESS,
        (Change(f"{where}.pilot.gain", "times", 1.0, -1.0),),
    )  # fmt: skip
    if f.effects.hysteresis is not None:
        yield FaultKind(
            f"{name}.spool_sticks", f"spool of {name} sticks: it follows {{}} of its travel late", (0.05, 0.1, 0.2), _LESS,
            (Change(f"{where}.valve.hysteresis", "plus", 0.0, f.valve.knots[-1]),),
        )  # fmt: skip
    edges = [
        f"{where}.valve.{key}[{k}]"
        for key in ("inlet", "outlet_positive", "outlet_negative")
        for k in range(len(f.valve.knots))
    ]
    yield FaultKind(
        f"{name}.orifices_worn", f"edges of {name}'s valve worn: inlet and outlet {{}} wider", (0.2, 0.5, 1.0), _MORE,
        tuple(Change(edge, "times", 1.0, 1.0) for edge in edges),
    )  # fmt: skip
    yield FaultKind(
        f"{name}.friction_high", f"friction of {name} {{}} higher", (0.5, 1.0, 2.0), _MORE,
        tuple(Change(f"{where}.friction.{part}", "times", 1.0, 1.0) for part in ("coulomb", "static", "viscous")),
    )  # fmt: skip


def _of_tip(machine: LayoutMachine) -> FaultKind:
    mass = float(f"{_USUAL_PAYLOAD * sum(link.mass for link in machine.links):.2g}") or 1.0
    return FaultKind(
        UNKNOWN_PAYLOAD, "{} at the tip that nobody knows of", (mass, 2.0 * mass, 4.0 * mass), _MASS,
        (Change(PAYLOAD, "plus", 0.0, 1.0),),
    )  # fmt: skip


def _of_reading(column: str, span: float) -> Iterator[FaultKind]:
    bias = FaultKind(
        f"{column}.bias", f"sensor of {column} reads {{}} of its range too much", (0.02, 0.05, -0.02), _SPAN,
        readings=(Change(column, "plus", 0.0, span),),
    )  # fmt: skip
    yield bias
    yield replace(
        bias, name=f"{column}.drift", words=f"sensor of {column} drifts to {{}} of its range too much", growth=_DRIFT
    )
    yield FaultKind(
        f"{column}.freeze", f"sensor of {column} stays at what it reads", (), _MORE,
        readings=(Change(column, "holds", 0.0, 0.0),),
    )  # fmt: skip


def _pump_of(f: MachineFunction, machine: LayoutMachine) -> PumpParameters:
    return next(c.pump for c in machine.circuits if f.name in c.functions)


def _unknown(name: str, machine: LayoutMachine, known: Sequence[str]) -> str:
    """Why a machine does not have a fault of that name."""
    owner, _, what = name.rpartition(".")
    if what == "torque_limit_off" and owner in [c.name for c in machine.circuits]:
        return f"fault {name!r}: the machine's pump of {owner} has no torque limit ({machine.circuit(owner).pump_path}.torque_limit_enabled = false)"
    if what == "spool_sticks" and owner in machine.names:
        return f"fault {name!r}: the machine has no number functions.{owner}.valve.hysteresis; declare it in its file, of 0 mm if the healthy spool does not stick"
    near = get_close_matches(name, known, n=3) or [k for k in known if k.startswith(f"{name.split('.')[0]}.")][:6]
    more = f"; near it: {', '.join(near)}" if near else ""
    return f"the machine has no fault {name!r}{more}; `polydraulic faults` lists all of them"
