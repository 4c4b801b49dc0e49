"""A machine identified from a log of its work: curves of valves, pumps and pilots inside the equations that are known.

What the sensors determine is fitted, circuit by circuit; all else keeps its value and is named, with the reason.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT, amount
from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.identification.arguments import table_of
from polydraulic.identification.equations.circuits import PUMP_KEYS, CircuitFound, identify_circuit
from polydraulic.identification.equations.finished import Finished
from polydraulic.identification.equations.free_numbers import CURVES, SPREADS, Freedom, fitted_here, freedom
from polydraulic.identification.equations.identified_file import Identified, file_text, machine_data
from polydraulic.identification.equations.log_pieces import raster_within
from polydraulic.identification.equations.pilot_fit import PilotFit
from polydraulic.identification.equations.sensors import (
    Signals,
    check_units,
    missing_for_circuit,
    read_function,
    wanted_columns,
)
from polydraulic.identification.equations.words import lines_of
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.layout.parts import MachineFunction, SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import load_machine, machine_path
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

_STEP_LAG = 2.5e-3  # s: half of the step of 5 ms that `simulate` holds a voltage for, and so adds to every dead time
_KNOWN = 0.5  # of its spread, or of itself: a number whose standard error is larger is not determined
_LEAST_ROWS = 500


@dataclass(frozen=True, eq=False)
class Identification:
    """A machine identified from a log; ``str()`` says what was found.

    Attributes
    ----------
    machine, before : LayoutMachine
        With what was found, and as it was given.
    changes : dict from path to Identified
        New values of entries of the machine file, with standard errors, in SI.
    circuits : dict from name to CircuitFound
        Those that were fitted.
    pilots : dict from function to PilotFit
    kept : list of str
        What kept its value, and why.
    remarks : list of str
        What is determined, and what is not.
    freedom : Freedom
        What was allowed to change.
    table : Table
        The log.
    source : str
        What the log is called.
    """

    machine: LayoutMachine
    before: LayoutMachine
    changes: dict[str, Identified]
    circuits: dict[str, CircuitFound]
    pilots: dict[str, PilotFit]
    kept: list[str]
    remarks: list[str]
    freedom: Freedom
    table: Table = field(repr=False)
    source: str
    data: dict[str, Any] = field(repr=False)

    def text(self, units: str = DEFAULT) -> str:
        """What was found, in lines."""
        return "\n".join(lines_of(self, units))

    def __str__(self) -> str:
        return self.text()

    def write(self, path: str | Path) -> None:
        """Write the machine as a TOML file, whole or not at all.

        Parameters
        ----------
        path : str or Path
            ``.toml``.
        """
        toml_ending(path)
        head = [f"{self.before.title}, identified from {self.source} by `polydraulic identify`.", *self.kept]
        write_text(path, file_text(self.data, self.changes, head))


def toml_ending(path: str | Path) -> None:
    """Refuse another ending than that of machine files."""
    if Path(path).suffix.lower() != ".toml":
        raise InputError(f"{path}: a machine file ends in .toml")


def identify(
    log: Table | str | Path | Sequence[Table | str | Path],
    machine: LayoutMachine | str | Path,
    *,
    free: Sequence[str] = (),
    parts: str | Path | None = None,
    progress: Progress = quiet,
) -> Identification:
    """Identify curves and numbers of a machine from a log of its work, inside its known equations.

    For each circuit of valves in series: inlet, bypass and outlet conductances over spool travel, monotone, on knots that are added where blocks of
    time held out ask for them; flow of the pump, and its relief setting and torque limit where rows show them. For each function with voltage and
    spool: gain, time constant and dead time of its pilot. Numbers that the sensors do not
    determine keep their value. Beyond the travel that the log has, curves go on in the shape they had, scaled to meet.

    Parameters
    ----------
    log : Table, str, Path or sequence of them
        Or its file, an imported log in SI: ``time``, and of each function what there is of ``NAME.spool``, ``NAME.p_a``, ``NAME.p_b``,
        ``NAME.q_in``, ``NAME.q_out``, ``NAME.voltage``, ``NAME.angle`` (``NAME.position`` of a joint that slides). A circuit needs spool and both
        pressures of all its functions, and flows or joints; without flow sensors, flows are balanced over windows by what joints
        displace and pressures compress.
    machine : LayoutMachine, str or Path
        To begin from, or its name or file.
    free : sequence of str
        Patterns of paths that may change, such as ``functions.*.valve.*``, besides what the file marks with ``free = true``. If nothing is
        marked either, all that can be fitted may.
    parts : str or Path, optional
        Folder in which finished circuits are kept while the others are fitted, and found again by the next call with the same log and machine.
    progress : Progress, optional

    Returns
    -------
    Identification

    Raises
    ------
    InputError
        A log that determines nothing, and why; columns in other units; times that do not rise; a pattern that fits nothing.
    """
    before = machine if isinstance(machine, LayoutMachine) else load_machine(machine)
    data = machine_data(before) if isinstance(machine, LayoutMachine) else read_toml(machine_path(machine))
    may = freedom(before, data, free)
    table, source = table_of(log, ["time"], ["segment", *wanted_columns(before)])
    check_units(table)
    segment = _segments(table, source)
    raster = raster_within(table["time"], segment)
    steps = len(before.functions) + 2 * len(before.circuits)
    signals: dict[str, Signals] = {}
    for number, f in enumerate(before.functions):
        progress(f"{f.name}: sensors and pilot", number, steps)
        signals[f.name] = read_function(before, f, table, segment, may.has(f"functions.{f.name}.pilot.time_constant"))
    notes: list[str] = []
    changes: dict[str, Identified] = {}
    from_log = f"identified from {source}"
    pilots: dict[str, PilotFit] = {}
    for f in before.functions:
        pilot = signals[f.name].pilot
        if not any(may.has(f"functions.{f.name}.pilot.{key}") for key in f.pilot._fields):
            continue
        if pilot is None:
            notes.append(f"functions.{f.name}.pilot: kept; the log has no voltage with a spool that follows it")
        else:
            pilots[f.name] = pilot
            changes |= _pilot_changes(f, pilot, may, from_log)
    circuits: dict[str, CircuitFound] = {}
    finished = Finished(parts, _digest(table, data, may))
    for number, circuit in enumerate(before.circuits):
        at = len(before.functions) + 2 * number
        why = _refused(before, circuit, signals, may)
        if why:
            notes.append(f"circuits.{circuit.name}: kept; {why}")
            continue
        known = finished.circuit(circuit.name)
        if known is None:
            fitted = identify_circuit(
                before, circuit, signals, table["time"], segment, raster, _free_pump(circuit, may),
                lambda what, name=circuit.name, at=at: progress(f"{name}: {what}", at, steps),  # type: ignore[misc]
            )  # fmt: skip
            if isinstance(fitted, str):
                notes.append(f"circuits.{circuit.name}: kept; {fitted}")
                continue
            finished.keep(circuit.name, fitted)
            known = fitted
        circuits[circuit.name] = known
        changes |= _circuit_changes(before, circuit, known, may, from_log, notes)
    if not changes:
        raise InputError("; ".join([f"{source} determines nothing of this machine", *notes]))
    others = [path for path in may.spreads if may.marked and not fitted_here(path)]
    if others:
        notes.append(
            f"{', '.join(others)}: kept; only a fit through simulation can change {'it' if len(others) == 1 else 'them'}"
        )
    found = before.with_values({path: new.value for path, new in changes.items()})
    finished.forget()
    progress("identified", steps, steps)
    return Identification(
        found, before, changes, circuits, pilots, notes, _remarks(before, circuits), may, table, source, data
    )


def _segments(table: Table, source: str) -> np.ndarray:
    time = table["time"]
    if len(time) < _LEAST_ROWS:
        raise InputError(
            f"{source} determines nothing of this machine: it has {len(time)} rows; {_LEAST_ROWS} at least"
        )
    if np.any(np.diff(time) <= 0.0):
        raise InputError(
            "column 'time' does not rise from row to row; a machine is identified from a log as it was recorded"
        )
    own = table["segment"] if "segment" in table.names else np.zeros(len(time))
    step = float(np.median(np.diff(time)))
    jumps = np.concatenate([[0.0], (np.abs(np.diff(time) - step) > 0.05 * step) | (np.diff(own) != 0.0)])
    return np.cumsum(jumps).astype(np.int64)


def _refused(machine: LayoutMachine, circuit: SupplyCircuit, signals: dict[str, Signals], may: Freedom) -> str:
    if circuit.kind != "series":
        return f"it is of the kind {circuit.kind!r}; only circuits of valves in series are identified"
    paths = [f"functions.{f}.valve.{key}" for f in circuit.functions for key in CURVES] + [
        f"{circuit.pump_path}.{key}" for key in PUMP_KEYS.values()
    ]
    if not any(may.has(path) for path in paths):
        return "none of its numbers is free"
    missing = missing_for_circuit(machine, circuit.functions, signals)
    if missing:
        return missing
    for name in circuit.functions:
        spool, opens = signals[name].spool, machine.function(name).valve
        assert spool is not None
        if np.count_nonzero(np.abs(spool) > 0.1 * opens.knots[-1]) < _LEAST_ROWS:
            return f"the spool of {name} hardly ever leaves its centre"
    return ""


def _free_pump(circuit: SupplyCircuit, may: Freedom) -> dict[str, float]:
    found = {}
    for name, key in PUMP_KEYS.items():
        path = f"{circuit.pump_path}.{key}"
        if may.has(path):
            found[name] = may.spread(path, SPREADS[key] * float(getattr(circuit.pump, key)))
    return found


def _pilot_changes(f: MachineFunction, found: PilotFit, may: Freedom, from_log: str) -> dict[str, Identified]:
    source = f"{from_log}: spool after voltage, {found.rows} rows, {amount(found.rms, 'm')} rms left"
    values = found.pilot._replace(dead_time=max(found.pilot.dead_time - _STEP_LAG, 0.0))
    return {
        f"functions.{f.name}.pilot.{key}": Identified(value, error, source)
        for key, value, error in zip(values._fields, values, found.errors, strict=True)
        if may.has(f"functions.{f.name}.pilot.{key}")
    }


def _circuit_changes(
    machine: LayoutMachine, circuit: SupplyCircuit, found: CircuitFound, may: Freedom, from_log: str, notes: list[str]
) -> dict[str, Identified]:
    changes = {}
    for name, v in found.valves.items():
        seen = f"travel {amount(v.seen[0], 'm')} to {amount(v.seen[1], 'm')} and pressure {amount(v.pressure[0], 'Pa')} to {amount(v.pressure[1], 'Pa')} seen"
        source = f"{from_log}: {v.rows} rows with an open valve, {seen}; beyond, the old curve's shape"
        for key in ("knots", *CURVES):
            values = getattr(v.curves, key)
            errors = v.errors.get(key)
            sure = (
                tuple(float("inf") if e != e else float(e) for e in errors)
                if errors is not None
                else (0.0,) * len(values)
            )
            changes[f"functions.{name}.valve.{key}"] = Identified(values, sure, source)
        notes += [
            f"functions.{name}.valve.{key}: kept; the log has too few rows with a spool on that side and a flow out"
            for key, fitted in zip(("outlet_positive", "outlet_negative"), v.outlets, strict=True)
            if not fitted
        ]
    for name, (value, error) in found.pump.items():
        key = PUMP_KEYS[name]
        changes[f"{circuit.pump_path}.{key}"] = Identified(value, error, f"{from_log}: {found.rows} rows")
    for name, key in PUMP_KEYS.items():
        if (
            name not in found.pump
            and may.has(f"{circuit.pump_path}.{key}")
            and (name != "limit_start" or circuit.pump.torque_limit_enabled)
        ):
            notes.append(f"{circuit.pump_path}.{key}: kept; the log does not show it")
    return changes


def _remarks(machine: LayoutMachine, circuits: dict[str, CircuitFound]) -> list[str]:
    """What is determined within what error, and what is not, in words."""
    found = []
    for c in circuits.values():
        for name, v in c.valves.items():
            knots = np.array(v.curves.knots)
            for key in CURVES:
                values, errors = np.array(getattr(v.curves, key)), v.errors[key]
                open_ = values > 0.02 * values.max()
                unsure = open_ & ~(errors < _KNOWN * 0.2 * np.maximum(values, 1e-300)) & (knots <= v.seen[1] + 1e-9)
                if unsure.any():
                    at = ", ".join(amount(k, "m") for k in knots[unsure])
                    found.append(
                        f"functions.{name}.valve.{key} is not known within 10 % at {at}: there the log hardly depends on it"
                    )
            if v.seen[1] < machine.function(name).valve.knots[-1] - 1e-4:
                found.append(
                    f"functions.{name}.valve beyond {amount(v.seen[1], 'm')} was never seen, to {amount(knots[-1], 'm')}: the old curves' shape"
                )
        found += c.trades
    return found


def _digest(table: Table, data: dict[str, Any], may: Freedom) -> str:
    digest = hashlib.sha256(repr((sorted(may.spreads.items()), data)).encode())
    for name in table.names:
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(table[name]).tobytes())
    return digest.hexdigest()
