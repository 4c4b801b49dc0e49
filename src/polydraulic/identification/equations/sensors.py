"""What a log says of each function of a machine: which sensors it has, signals in SI, how noisy they are, and what is missing for what."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.parabolas import ROWS as SMOOTHED
from polydraulic.identification.equations.parabolas import local_parabolas
from polydraulic.identification.equations.pilot_fit import Jets, PilotFit, fit_pilot, moves_against
from polydraulic.identification.equations.spool_motion import smooth_spool
from polydraulic.identification.noise import noise_level
from polydraulic.machine.volumes import levers, side_volumes
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
from polydraulic.tables import Table, segments_of

AT_VALVE = ("spool", "p_a", "p_b")


class Signals(NamedTuple):
    """What sensors read of a function, by what it is: spool, p_a, p_b, q_in, q_out; volume_a and volume_b where its joint has a sensor.

    Attributes
    ----------
    values : dict from quantity to (n_row,) array, SI
        No entry where there is no sensor, NaN in rows in which it is silent. The spool's is that of the sensor, smoothed by the pilot where the voltage is
        known; volumes are those that the joint's position gives the two sides of the actuator, m3.
    rates : dict from quantity to (n_row,) array, SI per s
        How fast pressures and volumes change.
    noise : dict from quantity to float, SI
        Standard deviation of its noise; of the spool, of what is left of it.
    pilot : PilotFit or None
    scale : float
        Standard error of the scale of the spool, relative: what the pilot drives is as wrong as its gain.
    """

    values: dict[str, np.ndarray]
    rates: dict[str, np.ndarray]
    noise: dict[str, float]
    pilot: PilotFit | None = None
    scale: float = 0.0

    def at(self, rows: np.ndarray) -> "Signals":
        """Those rows, an array of bool."""
        values, rates = ({what: v[rows] for what, v in of.items()} for of in (self.values, self.rates))
        return self._replace(values=values, rates=rates)


def read_function(
    machine: LayoutMachine, f: MachineFunction, table: Table, segment: np.ndarray, raster: float, fits_pilot: bool
) -> Signals:
    """Signals of a function.

    Parameters
    ----------
    machine : LayoutMachine
    f : MachineFunction
    table : Table
        The log, in SI; it may declare missing values. What goes over several rows is made of each channel's own pieces.
    segment : (n_row,) array
    raster : float, s
    fits_pilot : bool
        Whether the pilot is to be found from the log; otherwise it is that of the machine.
    """
    read = {what: table.columns.get(f"{f.name}.{what}") for what in (*AT_VALVE, "q_in", "q_out")}
    values = {what: column for what, column in read.items() if column is not None}
    noise = {what: noise_level(column, segment) for what, column in values.items()}
    values |= {what: np.maximum(values[what], 0.0) for what in ("p_a", "p_b") if what in values}
    place = position_column(machine, f)
    if place in table.names:
        known = table.known([place])
        measured, pieces = table.columns[place][known], segments_of(segment, known)
        position = local_parabolas(measured, pieces)[0]
        level = noise_level(measured, pieces) / np.sqrt(0.5 * SMOOTHED)
        sides = zip(
            ("volume_a", "volume_b"), side_volumes(machine, f, position), levers(machine, f, position), strict=True
        )
        for what, volume, arm in sides:
            values[what], noise[what] = at_rows(known, volume), level * float(np.mean(arm))
    moving = [what for what in ("p_a", "p_b", "volume_a", "volume_b") if what in values]
    signals = Signals(values, {what: _rate(values[what], segment, raster) for what in moving}, noise)
    if not {f"{f.name}.voltage", f"{f.name}.spool"} <= set(table.names):
        return signals
    log = spool_log(f, table, segment)
    pilot = None if log is None else fit_pilot(*log[1:], f.valve.knots[-1], f.pilot)
    return signals if pilot is None else smoothed_by(signals, f, pilot, table, segment, fits_pilot)


def spool_log(
    f: MachineFunction, table: Table, segment: np.ndarray, jets: Jets | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """Rows with voltage, spool and, if they are given, jets, (n_row,) array of bool; their time, segment, voltage and spool.

    None where no row follows another one.
    """
    names = [f"{f.name}.voltage", f"{f.name}.spool"]
    rows = table.known(names)
    if jets is not None:
        rows &= np.isfinite(jets.strength)
    pieces = segments_of(segment, rows)
    voltage, spool = (table.columns[name][rows] for name in names)
    follow = (np.diff(pieces) == 0).any()
    return (rows, table["time"][rows], pieces, voltage, spool) if follow else None


def smoothed_by(
    s: Signals,
    f: MachineFunction,
    fit: PilotFit,
    table: Table,
    segment: np.ndarray,
    fits_pilot: bool,
    jets: Jets | None = None,
) -> Signals:
    """Signals whose spool is that of the sensor, smoothed by a pilot and the effects that were found with it.

    Parameters
    ----------
    s : Signals
    f : MachineFunction
    fit : PilotFit
    table, segment, fits_pilot
        As for `read_function`.
    jets : Jets, optional
        Where they are known.
    """
    log = spool_log(f, table, segment, jets)
    assert log is not None
    rows, time, pieces, voltage, measured = log
    own, sensor = fit.pilot if fits_pilot else f.pilot, noise_level(measured, pieces)
    strength = None if jets is None else jets.strength[rows]
    spool, left = smooth_spool(own, f.valve.knots[-1], time, pieces, voltage, measured, sensor, fit.effects, strength)
    scale = fit.errors.gain / own.gain if fits_pilot else 0.0
    return Signals(s.values | {"spool": at_rows(rows, spool)}, s.rates, s.noise | {"spool": left}, fit, scale)


def _rate(values: np.ndarray, segment: np.ndarray, raster: float) -> np.ndarray:
    """How fast a signal changes, from its own pieces."""
    known = ~np.isnan(values)
    return at_rows(known, local_parabolas(values[known], segments_of(segment, known))[1] / raster)


def at_rows(rows: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (..., n_kept) at those rows, (n_row,) of bool, and NaN at others; (..., n_row)."""
    found = np.full((*values.shape[:-1], len(rows)), np.nan)
    found[..., rows] = values
    return found


def against_spools(machine: LayoutMachine, table: Table, segment: np.ndarray) -> list[str]:
    """Functions whose spool follows the voltage of the other sign: what such a voltage drives goes the wrong way."""
    found = []
    for f in machine.functions:
        voltage, spool = f"{f.name}.voltage", f"{f.name}.spool"
        if {voltage, spool} <= set(table.names):
            log = spool_log(f, table, segment)
            if log is not None and moves_against(*log[1:], f.valve.knots[-1], f.pilot):
                found.append(f.name)
    return found


def known_at_valves(functions: Sequence[str], signals: Mapping[str, Signals], n_row: int) -> np.ndarray:
    """Rows in which spools and pressures of functions have a value, as far as they have sensors, (n_row,) of bool."""
    known = np.ones(n_row, dtype=bool)
    for name in functions:
        for what in AT_VALVE:
            if what in signals[name].values:
                known &= ~np.isnan(signals[name].values[what])
    return known


def missing_at_valves(functions: Sequence[str], signals: Mapping[str, Signals]) -> list[str]:
    """Columns of spools and pressures that a log lacks."""
    return [f"{name}.{what}" for name in functions for what in AT_VALVE if what not in signals[name].values]


def missing_for_circuit(machine: LayoutMachine, functions: Sequence[str], signals: Mapping[str, Signals]) -> str:
    """Why a circuit cannot be fitted, in words; empty if it can."""
    lacks = missing_at_valves(functions, signals)
    for name in functions:
        if not {"q_in", "volume_a"} & signals[name].values.keys():
            lacks.append(f"{name}.q_in or {position_column(machine, machine.function(name))}")
    return f"the log has no {', '.join(lacks)}" if lacks else ""
