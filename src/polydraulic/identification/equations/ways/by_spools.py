"""Pilots from voltages and spools, and what spools do besides: hysteresis, and flow forces of jets where pressures are known."""

from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.identification.equations.circuits import CircuitFound, ValveFound
from polydraulic.identification.equations.fit.jets import Jets, jets_of
from polydraulic.identification.equations.free_numbers import EFFECTS, Freedom
from polydraulic.identification.equations.identified_file import Identified
from polydraulic.identification.equations.pilot_fit import PilotFit, fit_pilot, told_dead_time
from polydraulic.identification.equations.sensors import Signals, missing_at_valves, smoothed_by, spool_log
from polydraulic.identification.equations.spool_motion import SpoolEffects
from polydraulic.identification.equations.ways.curves_by_jets import jet_shares, moved_by_jets, none_moved
from polydraulic.identification.equations.ways.so_far import SoFar
from polydraulic.machine.play import prepare_shift
from polydraulic.parameters.layout.parts import FlowForce, MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.prepare import flow_force_shift
from polydraulic.tables import Table

_STEP = 5e-3  # s, as `simulate` has it unless told otherwise
STEP_LAG = 0.5 * _STEP  # for which it holds a voltage, and so adds to every dead time
# standard errors and share of the travel, below which an effect counts as none
_SURE, _LEAST = 3.0, 2e-3
# density and angle where a file has none: the force over the spring is what shows
_USUAL = FlowForce(1e5, 870.0, np.radians(69.0))
_PASSES, _SETTLED = 4, 0.1  # over curves that jets move, until they do so by less, in standard errors
_SELDOM = 0.5  # of a time constant between rows, beyond which a pilot moves between them
_NO_PILOT = "the log has no voltage with a spool that follows it"


class SpoolFound(NamedTuple):
    """What a log says of a spool.

    Attributes
    ----------
    fit : PilotFit
        With the effects that are known, or asked for and shown.
    jets : Jets or None
    shown, least : SpoolEffects
        All effects that the log shows, zero where it shows none, and what it would have shown.
    """

    fit: PilotFit
    jets: Jets | None
    shown: SpoolEffects
    least: SpoolEffects


def find_pilots(so_far: SoFar, signals: dict[str, Signals], raster: float) -> dict[str, PilotFit]:
    """Pilots of the functions whose voltage and spool the log has, with rows so many seconds apart."""
    found = {}
    for f in so_far.machine.functions:
        pilot = signals[f.name].pilot
        if not any(so_far.may.has(f"functions.{f.name}.pilot.{key}") for key in f.pilot._fields):
            continue
        if pilot is None:
            so_far.lacks[f"functions.{f.name}.pilot"] = _NO_PILOT
        else:
            found[f.name] = pilot
            so_far.take(_pilot_changes(f, pilot, so_far.may, so_far.from_log))
            if raster > _SELDOM * pilot.pilot.time_constant:
                so_far.remarks.append(
                    f"functions.{f.name}.pilot: rows come every {raster:g} s, and its time constant is {pilot.pilot.time_constant:.3g} s: what the lever "
                    "does between rows is not seen, so that time constant and dead time may be off by more than their standard errors"
                )
    return found


def look_at_spools(
    so_far: SoFar, signals: dict[str, Signals], circuits: dict[str, CircuitFound], table: Table, segment: np.ndarray
) -> tuple[dict[str, SpoolFound], dict[str, CircuitFound]]:
    """What spools do besides following their pilots, and curves as they and flows together tell them.

    Parameters
    ----------
    so_far : SoFar
        With curves as flows tell them.
    signals : dict from function to Signals
    circuits : dict from name to CircuitFound
        Those that were fitted.
    table : Table
        The log, in SI.
    segment : (n_row,) array

    Returns
    -------
    dict from function to SpoolFound
        Of those whose pilots or effects are free, or effects known.
    dict from name to CircuitFound
        Whose curves differ where jets push spools.
    """
    fitted = {name: v for c in circuits.values() for name, v in c.valves.items()}
    shares, moved = ({name: of(v) for name, v in fitted.items()} for of in (jet_shares, none_moved))
    valves = dict(fitted)
    for _ in range(_PASSES):
        jets = _jets(so_far.machine, signals, valves, shares, moved, segment)
        found = _looked(so_far, signals, jets, table, segment)
        pushed = {name: s.fit for name, s in found.items() if s.fit.effects.shift > 0.0 and name in fitted}
        moved |= {name: moved[name] + fit.moved for name, fit in pushed.items()}
        valves |= {name: moved_by_jets(fitted[name], moved[name], fit.moved_errors) for name, fit in pushed.items()}
        if all(np.abs(fit.moved).max(initial=0.0) < _SETTLED for fit in pushed.values()):
            break
    return found, {name: c._replace(valves={own: valves[own] for own in c.valves}) for name, c in circuits.items()}


def _jets(
    machine: LayoutMachine, signals: dict[str, Signals], valves: dict[str, ValveFound], shares: dict[str, np.ndarray],
    moved: dict[str, np.ndarray], segment: np.ndarray,
) -> dict[str, Jets]:  # fmt: skip
    """Jets of all functions whose circuits have the sensors for it, with curves as they are known by now."""
    now = (f._replace(valve=valves[f.name].curves) if f.name in valves else f for f in machine.functions)
    machine, found = machine._replace(functions=tuple(now)), dict[str, Jets]()
    for circuit in machine.circuits:
        if not lacking_for_jets(machine, circuit.functions[0], signals):
            found |= jets_of(machine, circuit, signals, segment, shares, moved)
    return found


def _looked(
    so_far: SoFar, signals: dict[str, Signals], jets: dict[str, Jets], table: Table, segment: np.ndarray
) -> dict[str, SpoolFound]:
    """What spools do besides following their pilots, at given jets."""
    machine, may, found = so_far.machine, so_far.may, dict[str, SpoolFound]()
    for f in machine.functions:
        pilot, own, travel = signals[f.name].pilot, jets.get(f.name), f.valve.knots[-1]
        free = [key for key, path in EFFECTS.items() if may.has(f"functions.{f.name}.{path}")]
        known = declared_effects(f)
        if pilot is None or not (
            free or any(known) or any(may.has(f"functions.{f.name}.pilot.{key}") for key in f.pilot._fields)
        ):
            continue
        log = spool_log(f, table, segment, own)
        if log is None:
            continue
        own = None if own is None else own.at(log[0])
        given = *log[1:], travel, pilot.pilot
        every = tuple(EFFECTS) if own is not None else ("hysteresis",)
        fit = fit_pilot(*given, jets=own, free=every)
        if fit is None:
            continue
        strong = 0.0 if own is None else float(np.quantile(own.strength, 0.99))
        least = SpoolEffects(
            max(_SURE * fit.effect_errors.hysteresis, _LEAST * travel),
            max(_SURE * fit.effect_errors.shift, _LEAST * travel / max(strong, 1e-300)),
        )
        shown = SpoolEffects(*(v if v > low else 0.0 for v, low in zip(fit.effects, least, strict=True)))
        take = [key for key in every if key in free and getattr(shown, key) > 0.0]
        fixed = SpoolEffects(**{key: 0.0 if key in free else getattr(known, key) for key in EFFECTS})
        if set(take) != set(every):
            fit = fit_pilot(*given, fixed, own, take) if take or any(fixed) else pilot
        found[f.name] = SpoolFound(fit or pilot, jets.get(f.name), shown, least)
    return found


def smoothed_again(
    machine: LayoutMachine,
    may: Freedom,
    signals: dict[str, Signals],
    spools: dict[str, SpoolFound],
    table: Table,
    segment: np.ndarray,
) -> dict[str, Signals]:
    """Signals of functions whose spools do something besides following their pilots, smoothed by what they do."""
    found = {}
    for f in machine.functions:
        s = spools.get(f.name)
        if s is not None and any(s.fit.effects):
            fits = may.has(f"functions.{f.name}.pilot.time_constant")
            found[f.name] = smoothed_by(signals[f.name], f, s.fit, table, segment, fits, s.jets)
    return found


def take_effects(so_far: SoFar, signals: dict[str, Signals], spools: dict[str, SpoolFound]) -> None:
    """Take effects that are free, and name what is not asked for and shows, or is asked for and does not show."""
    for f in so_far.machine.functions:
        for key in EFFECTS:
            path, s = f"functions.{f.name}.{EFFECTS[key]}", spools.get(f.name)
            if s is None or (key == "shift" and s.jets is None):
                if so_far.may.has(path):
                    pressures = lacking_for_jets(so_far.machine, f.name, signals) if s is not None else ""
                    so_far.lacks[path] = pressures or _NO_PILOT
            elif so_far.may.has(path):
                _take(so_far, f, key, s)
            elif getattr(s.shown, key) > 0.0 and not getattr(declared_effects(f), key):
                so_far.remarks.append(f"{_shown(f, key, s)}, of which the machine knows nothing: free {path}")


def lacking_for_jets(machine: LayoutMachine, function: str, signals: dict[str, Signals]) -> str:
    """Why the jets of a function's circuit are not known, in words; empty if they are."""
    circuit = next(c for c in machine.circuits if function in c.functions)
    if circuit.kind != "series":
        return (
            f"circuits.{circuit.name} is of the kind {circuit.kind!r}; jets are known in circuits of valves in series"
        )
    lacks = missing_at_valves(circuit.functions, signals)
    return f"the log has no {', '.join(lacks)}" if lacks else ""


def declared_effects(f: MachineFunction) -> SpoolEffects:
    """What the machine's file says that a spool does besides following its pilot."""
    force = f.effects.flow_force
    return SpoolEffects(f.effects.hysteresis or 0.0, 0.0 if force is None else prepare_shift(force))


def _spring(f: MachineFunction, shift: float) -> float:
    """Rate in N/m of the spring that a shift tells, of the oil that the file says."""
    of = f.effects.flow_force or _USUAL
    return of.spring_rate * prepare_shift(of) / shift


def _shown(f: MachineFunction, key: str, s: SpoolFound) -> str:
    if key == "hysteresis":
        return f"the spool of {f.name} lags behind its pilot by about {amount(s.shown.hysteresis, 'm', digits=2)}"
    rate = amount(_spring(f, s.shown.shift), "N/m", digits=2)
    return f"jets push the spool of {f.name} back, against a spring of about {rate}"


def _take(so_far: SoFar, f: MachineFunction, key: str, s: SpoolFound) -> None:
    path = f"functions.{f.name}.{EFFECTS[key]}"
    value, error = (getattr(of, key) for of in (s.fit.effects, s.fit.effect_errors))
    source = f"{so_far.from_log}: spool after voltage, {s.fit.rows} rows, {amount(s.fit.rms, 'm')} rms left"
    if value > 0.0:
        force = f.effects.flow_force or _USUAL
        given = {"hysteresis": f.effects.hysteresis or 0.0} if key == "hysteresis" else {"flow_force": force}
        so_far.declare(f.name, **given)
        if key == "shift":
            spring = _spring(f, value)
            value, error = spring, spring * error / value
        so_far.take({path: Identified(value, error, source)})
        so_far.remarks += _unlike_a_run(so_far, f.name, key, s)
    elif key == "hysteresis":
        least = amount(s.least.hysteresis, "m", digits=2)
        so_far.kept.append(f"{path}: none; the log would show {least}")
        if f.effects.hysteresis is not None:
            so_far.take({path: Identified(0.0, s.fit.effect_errors.hysteresis, source)})
    else:
        least = amount(_spring(f, s.least.shift), "N/m", digits=2)
        so_far.kept.append(f"{path.rpartition('.')[0]}: none; the log would show that of a spring of {least}")
        so_far.declare(f.name, flow_force=None)


def _unlike_a_run(so_far: SoFar, name: str, key: str, s: SpoolFound) -> list[str]:
    """What keeps a run from having the effect as it was found."""
    if key == "hysteresis":
        doubt = f"functions.{name}.{EFFECTS[key]}: the log has not the pressures of its circuit, so that flow forces, if there are any, are in it"
        return [doubt] if s.jets is None else []
    try:
        flow_force_shift(so_far.machine.function(name), so_far.machine, _STEP)
    except InputError as error:
        return [str(error)]
    return []


def _pilot_changes(f: MachineFunction, found: PilotFit, may: Freedom, from_log: str) -> dict[str, Identified]:
    source = f"{from_log}: spool after voltage, {found.rows} rows, {amount(found.rms, 'm')} rms left"
    late = max(found.pilot.dead_time - STEP_LAG, 0.0)
    dead = told_dead_time(late, found.errors.dead_time)
    # what is not told from no dead time is a little more of the lag, which trades against it
    values = found.pilot._replace(dead_time=dead, time_constant=found.pilot.time_constant + late - dead)
    return {
        f"functions.{f.name}.pilot.{key}": Identified(value, error, source)
        for key, value, error in zip(values._fields, values, found.errors, strict=True)
        if may.has(f"functions.{f.name}.pilot.{key}")
    }
