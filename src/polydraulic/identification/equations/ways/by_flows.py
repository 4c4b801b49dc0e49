"""Circuits from spools, pressures and flows."""

from collections.abc import Callable

import numpy as np

from polydraulic.display import amount
from polydraulic.identification.equations.circuits import PUMP_KEYS, CircuitFound, identify_circuit
from polydraulic.identification.equations.finished import Finished
from polydraulic.identification.equations.free_numbers import CURVES, SPREADS, Freedom
from polydraulic.identification.equations.identified_file import Identified
from polydraulic.identification.equations.sensors import Signals, known_at_valves, missing_for_circuit
from polydraulic.identification.equations.ways.so_far import SoFar
from polydraulic.identification.plausible import contradictions
from polydraulic.parameters.layout.parts import Seen, SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import segments_of

LEAST_ROWS = 500
_KNOWN = 0.1  # of a conductance: one whose standard error is larger is told


def find_circuits(
    so_far: SoFar,
    signals: dict[str, Signals],
    time: np.ndarray,
    segment: np.ndarray,
    raster: float,
    finished: Finished,
    tell: Callable[[int, float, str], object],
    turn: int = 0,
) -> dict[str, CircuitFound]:
    """Circuits whose sensors the log has; finished ones as they were.

    Parameters
    ----------
    so_far : SoFar
    signals : dict from function to Signals
    time, segment : (n_row,) array
    raster : float, s
    finished : Finished
    tell : callable
        Told the place of a circuit among those that are not refused, about which share of it is done, and what is being done.
    turn : int
        How often circuits have been fitted before, to spools of which less was known.
    """
    machine, may, found = so_far.machine, so_far.may, {}
    refused = refused_circuits(machine, signals, may, len(time))
    so_far.lacks |= {f"circuits.{name}": why for name, why in refused.items()}
    for place, circuit in enumerate(c for c in machine.circuits if c.name not in refused):
        rows = known_at_valves(circuit.functions, signals, len(time))
        own = {name: signals[name].at(rows) for name in circuit.functions}
        kept_as = f"{circuit.name}-{turn}" if turn else circuit.name
        known = finished.circuit(kept_as)
        if known is None:
            fitted = identify_circuit(
                machine, circuit, own, time[rows], segments_of(segment, rows), raster, _free_pump(circuit, may),
                lambda share, what, name=circuit.name, place=place: tell(place, share, f"{name}: {what}"),  # type: ignore[misc]
            )  # fmt: skip
            if isinstance(fitted, str):
                so_far.lacks[f"circuits.{circuit.name}"] = fitted
                continue
            finished.keep(kept_as, fitted)
            known = fitted
        found[circuit.name] = known
        so_far.take(_circuit_changes(machine, circuit, known, may, so_far.from_log, so_far.kept))
        so_far.seen |= {name: Seen(v.seen[1], v.pressure[1]) for name, v in known.valves.items()}
    return found


def refused_circuits(machine: LayoutMachine, signals: dict[str, Signals], may: Freedom, n_row: int) -> dict[str, str]:
    """Why circuits are not identified from flows, by name; those that are have no entry."""
    found = {}
    for circuit in machine.circuits:
        rows = known_at_valves(circuit.functions, signals, n_row)
        why = _refused(machine, circuit, {name: signals[name].at(rows) for name in circuit.functions}, may)
        if why:
            found[circuit.name] = why
    return found


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
    n_row = len(signals[circuit.functions[0]].values["spool"])
    if n_row < LEAST_ROWS:
        return f"spools and pressures of all its functions have a value together in {n_row} rows; {LEAST_ROWS} at least"
    for name in circuit.functions:
        spool, opens = signals[name].values["spool"], machine.function(name).valve
        if np.count_nonzero(np.abs(spool) > 0.1 * opens.knots[-1]) < LEAST_ROWS:
            return f"the spool of {name} hardly ever leaves its centre"
    return ""


def _free_pump(circuit: SupplyCircuit, may: Freedom) -> dict[str, float]:
    found = {}
    for name, key in PUMP_KEYS.items():
        path = f"{circuit.pump_path}.{key}"
        if may.has(path):
            found[name] = may.spread(path, SPREADS[key] * float(getattr(circuit.pump, key)))
    return found


def _circuit_changes(
    machine: LayoutMachine, circuit: SupplyCircuit, found: CircuitFound, may: Freedom, from_log: str, notes: list[str]
) -> dict[str, Identified]:
    changes = {}
    for name, v in found.valves.items():
        seen = f"travel {amount(v.seen[0], 'm')} to {amount(v.seen[1], 'm')} and pressure {amount(v.pressure[0], 'Pa')} to {amount(v.pressure[1], 'Pa')} seen"
        source = f"{from_log}: {v.rows} rows with an open valve, {seen}; beyond, the old curve's shape, bypasses by their slope"
        for key in ("knots", *CURVES):
            values = getattr(v.curves, key)
            errors = v.errors.get(key)
            sure = _told(errors) if errors is not None else (0.0,) * len(values)
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


def take_curves(so_far: SoFar, circuits: dict[str, CircuitFound]) -> None:
    """Take curves of circuits that were found, as spools may have moved them since, and say what is determined within what error, and what is not."""
    for c in circuits.values():
        for name, v in c.valves.items():
            for key in CURVES:
                path = f"functions.{name}.valve.{key}"
                new = so_far.changes[path]._replace(value=getattr(v.curves, key), uncertainty=_told(v.errors[key]))
                so_far.take({path: new})
    so_far.remarks += _remarks(so_far.machine, circuits)


def _told(errors: np.ndarray) -> tuple[float, ...]:
    """Standard errors, infinite where there is none."""
    return tuple(np.where(np.isnan(errors), np.inf, errors).tolist())


def _remarks(machine: LayoutMachine, circuits: dict[str, CircuitFound]) -> list[str]:
    """What is determined within what error, and what is not, in words."""
    found = []
    for circuit, c in circuits.items():
        for name, v in c.valves.items():
            left = float(np.nan_to_num([v.q_in_left, v.q_out_left]).max())
            found += contradictions(name, left, machine.circuit(circuit).pump.flow)
            knots = np.array(v.curves.knots)
            for key in CURVES:
                values, errors = np.array(getattr(v.curves, key)), v.errors[key]
                open_ = values > 0.02 * values.max()
                unsure = open_ & ~(errors < _KNOWN * np.maximum(values, 1e-300)) & (knots <= v.seen[1] + 1e-9)
                if unsure.any():
                    at = ", ".join(amount(k, "m") for k in knots[unsure])
                    found.append(
                        f"functions.{name}.valve.{key} is not known within {100.0 * _KNOWN:.0f} % at {at}: there the log hardly depends on it"
                    )
            if v.seen[1] < machine.function(name).valve.knots[-1] - 1e-4:
                found.append(
                    f"functions.{name}.valve beyond {amount(v.seen[1], 'm')} was never seen, to {amount(knots[-1], 'm')}: the old curves' shape"
                )
        found += c.trades
    return found
