"""What a log says of each function of a machine: which sensors it has, signals in SI, how noisy they are, and what is missing for what."""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.parabolas import ROWS as SMOOTHED
from polydraulic.identification.equations.parabolas import local_parabolas
from polydraulic.identification.equations.pilot_fit import Jets, PilotFit, fit_pilot, moves_against, smooth_spool
from polydraulic.identification.noise import noise_level
from polydraulic.identification.plausible import position_column
from polydraulic.machine.volumes import levers, side_volumes
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table, segments_of


class Signals(NamedTuple):
    """What sensors read of a function; None where there is no sensor, NaN in rows in which it is silent.

    Attributes
    ----------
    spool : (n_row,) array, m
        From the sensor, and from the pilot where its voltage is known.
    p_a, p_b : (n_row,) array, Pa
    rate_a, rate_b : (n_row,) array, Pa/s
        How fast these change.
    q_in, q_out : (n_row,) array, m3/s
    volume_a, volume_b : (n_row,) array, m3
        That the joint's position gives the two sides of the actuator.
    volume_rate_a, volume_rate_b : (n_row,) array, m3/s
        How fast these change.
    noise : dict
        Standard deviation of each of these, in SI; of `spool` of what is left of it.
    pilot : PilotFit or None
    scale : float
        Standard error of the scale of `spool`, relative: what the pilot drives is as wrong as its gain.
    """

    spool: np.ndarray | None
    p_a: np.ndarray | None
    p_b: np.ndarray | None
    rate_a: np.ndarray | None
    rate_b: np.ndarray | None
    q_in: np.ndarray | None
    q_out: np.ndarray | None
    volume_a: np.ndarray | None
    volume_b: np.ndarray | None
    volume_rate_a: np.ndarray | None
    volume_rate_b: np.ndarray | None
    noise: dict[str, float]
    pilot: PilotFit | None
    scale: float = 0.0

    def at(self, rows: np.ndarray) -> "Signals":
        """Those rows, an array of bool."""
        found = self._asdict()
        return self._replace(**{name: v[rows] for name, v in found.items() if isinstance(v, np.ndarray)})


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
    of = f.name
    found = {what: table.columns.get(f"{of}.{what}") for what in ("spool", "p_a", "p_b", "q_in", "q_out", "voltage")}
    noise = {what: noise_level(values, segment) for what, values in found.items() if values is not None}
    place = position_column(machine, f)
    volume_a = volume_b = None
    if place in table.names:
        known = table.known([place])
        measured, pieces = table.columns[place][known], segments_of(segment, known)
        position = local_parabolas(measured, pieces)[0]
        noise["position"] = noise_level(position, pieces)
        volume_a, volume_b = (at_rows(known, side) for side in side_volumes(machine, f, position))
        middle = levers(machine, f, position)
        noise["volume_a"], noise["volume_b"] = (
            noise_level(measured, pieces) / np.sqrt(0.5 * SMOOTHED) * float(np.mean(side)) for side in middle
        )
    p_a, p_b = (None if p is None else np.maximum(p, 0.0) for p in (found["p_a"], found["p_b"]))
    rate_a, rate_b, volume_rate_a, volume_rate_b = (
        None if v is None else _rate(v, segment, raster) for v in (p_a, p_b, volume_a, volume_b)
    )
    signals = Signals(
        found["spool"], p_a, p_b, rate_a, rate_b, found["q_in"], found["q_out"], volume_a, volume_b, volume_rate_a, volume_rate_b, noise,
        None,
    )  # fmt: skip
    if found["spool"] is None or found["voltage"] is None:
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
    return s._replace(spool=at_rows(rows, spool), noise=s.noise | {"spool": left}, pilot=fit, scale=scale)


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


def missing_for_circuit(machine: LayoutMachine, functions: tuple[str, ...], signals: dict[str, Signals]) -> str:
    """Why a circuit cannot be fitted, in words; empty if it can."""
    lacks = [
        f"{name}.{what}"
        for name in functions
        for what in ("spool", "p_a", "p_b")
        if getattr(signals[name], what) is None
    ]
    for name in functions:
        if signals[name].q_in is None and signals[name].volume_a is None:
            lacks.append(f"{name}.q_in or {position_column(machine, machine.function(name))}")
    return f"the log has no {', '.join(lacks)}" if lacks else ""
