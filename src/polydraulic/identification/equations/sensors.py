"""What a log says of each function of a machine: which sensors it has, signals in SI, how noisy they are, and what is missing for what."""

from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.identification.equations.noise import noise_level
from polydraulic.identification.equations.parabolas import ROWS as SMOOTHED
from polydraulic.identification.equations.parabolas import local_parabolas
from polydraulic.identification.equations.pilot_fit import PilotFit, fit_pilot, smooth_spool
from polydraulic.machine.volumes import levers, side_volumes
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table

UNITS = {
    "spool": "m",
    "p_a": "Pa",
    "p_b": "Pa",
    "q_in": "m3/s",
    "q_out": "m3/s",
    "voltage": "V",
    "angle": "rad",
    "position": "m",
}
_BEYOND = 0.1  # rad or m, that a sensor may be off
_LEAST_PRESSURE = 1e5  # Pa
_LEAST_OF_ONE = 1e4  # Pa, which even the port of a returning line passes; 10,000 psi and more nobody has
_TRAVELS, _FLOWS = 5.0, 100.0  # times the valve's travel and the largest pump's flow, beyond which a unit is wrong
_LEVERS = 10.0  # times the voltage of full travel
_MANY = 0.05  # share of rows that are no outliers


class Signals(NamedTuple):
    """What sensors read of a function; None where there is no sensor.

    Attributes
    ----------
    spool : (n_row,) array, m
        From the sensor, and from the pilot where its voltage is known.
    p_a, p_b : (n_row,) array, Pa
    q_in, q_out : (n_row,) array, m3/s
    volume_a, volume_b : (n_row,) array, m3
        That the joint's position gives the two sides of the actuator.
    noise : dict
        Standard deviation of each of these, in SI; of `spool` of what is left of it.
    pilot : PilotFit or None
    """

    spool: np.ndarray | None
    p_a: np.ndarray | None
    p_b: np.ndarray | None
    q_in: np.ndarray | None
    q_out: np.ndarray | None
    volume_a: np.ndarray | None
    volume_b: np.ndarray | None
    noise: dict[str, float]
    pilot: PilotFit | None


def position_column(machine: LayoutMachine, f: MachineFunction) -> str:
    """Name of the column of a function's joint."""
    return f"{f.name}.{'position' if machine.link(f.moves).joint == 'prismatic' else 'angle'}"


def check_units(table: Table) -> None:
    """Refuse columns that are not in SI."""
    for name in table.names:
        si = UNITS.get(name.split(".")[-1])
        if si is not None and table.unit(name) not in ("", si):
            raise InputError(
                f"column {name!r} is in {table.unit(name)!r}; a machine is identified in SI, this in {si!r}"
            )


def check_plausible(machine: LayoutMachine, table: Table) -> None:
    """Refuse columns that no sensor of this machine reads in SI, whatever the table says of units.

    Raises
    ------
    InputError
        Where most rows of a position lie far beyond the joint's stops, many of a spool or a flow beyond all that the machine has, no pressure
        of the log comes to one bar, or a single one that varies not to a tenth of it; or levers go many times beyond the voltage of full travel.
    """
    most_flow = _FLOWS * max(circuit.pump.flow for circuit in machine.circuits)
    for f in machine.functions:
        name = position_column(machine, f)
        if name in table.names:
            far = np.maximum(table[name] - f.stops.high, f.stops.low - table[name]) > _BEYOND
            if far.mean() > 0.5:
                unit = "m" if name.endswith(".position") else "rad"
                stops = f"its joint's stops at {f.stops.low:.4g} and {f.stops.high:.4g} {unit}"
                raise _not_si(table, name, f"{stops}: it must be in {unit}, with the zero of the machine file")
        for what, unit, most in (
            ("spool", "m", _TRAVELS * f.valve.knots[-1]),
            ("q_in", "m3/s", most_flow),
            ("q_out", "m3/s", most_flow),
        ):
            name = f"{f.name}.{what}"
            if name in table.names and (np.abs(table[name]) > most).mean() > _MANY:
                raise _not_si(table, name, f"no more than {most:.4g} {unit} can be: it must be in {unit}")
        name, full = f"{f.name}.voltage", f.valve.knots[-1] / f.pilot.gain
        if name in table.names and (np.abs(table[name]) > _LEVERS * full).mean() > _MANY:
            raise _not_si(
                table,
                name,
                f"and by the file's pilot {amount(full, 'V')} gives full travel: it must be in V, not in per cent of a lever's way",
            )
    highest = {name: float(table[name].max()) for name in table.names if name.split(".")[-1] in ("p_a", "p_b")}
    most = max(highest.values(), default=0.0)
    if 0.0 < most < _LEAST_PRESSURE:
        raise InputError(
            f"the largest pressure at a port of the log is {most:.4g} Pa, and oil that works has more than 1 bar, {_LEAST_PRESSURE:g} Pa: pressures "
            "must be in Pa; import the log with the sensors' unit"
        )
    for name, largest in highest.items():
        if 0.0 < largest < _LEAST_OF_ONE and np.ptp(table[name]) > 0.0:
            raise InputError(
                f"column {name!r} comes to {largest:.4g} Pa at most, others to {amount(most, 'Pa')}: it must be in Pa; import the log with that "
                "sensor's unit, or leave the column out if the sensor is dead"
            )


def _not_si(table: Table, name: str, why: str) -> InputError:
    values = table[name]
    return InputError(
        f"column {name!r} lies between {values.min():.4g} and {values.max():.4g}, {why}; import the log with the sensor's unit"
    )


def read_function(
    machine: LayoutMachine, f: MachineFunction, table: Table, segment: np.ndarray, fits_pilot: bool
) -> Signals:
    """Signals of a function.

    Parameters
    ----------
    machine : LayoutMachine
    f : MachineFunction
    table : Table
        The log, in SI.
    segment : (n_row,) array
    fits_pilot : bool
        Whether the pilot is to be found from the log; otherwise it is that of the machine.
    """

    def column(what: str) -> np.ndarray | None:
        name = f"{f.name}.{what}"
        return table[name] if name in table.names else None

    found = {what: column(what) for what in ("spool", "p_a", "p_b", "q_in", "q_out", "voltage")}
    noise = {what: noise_level(values, segment) for what, values in found.items() if values is not None}
    spool, voltage, pilot = found["spool"], found["voltage"], None
    travel = f.valve.knots[-1]
    if spool is not None and voltage is not None:
        pilot = fit_pilot(table["time"], segment, voltage, spool, travel, f.pilot)
        if pilot is not None:
            own = pilot.pilot if fits_pilot else f.pilot
            spool, noise["spool"] = smooth_spool(own, travel, table["time"], segment, voltage, spool, noise["spool"])
    place = position_column(machine, f)
    volume_a = volume_b = None
    if place in table.names:
        position = local_parabolas(table[place], segment)[0]
        noise["position"] = noise_level(position, segment)
        volume_a, volume_b = side_volumes(machine, f, position)
        middle = levers(machine, f, position)
        noise["volume_a"], noise["volume_b"] = (
            noise_level(table[place], segment) / np.sqrt(0.5 * SMOOTHED) * float(np.mean(side)) for side in middle
        )
    p_a, p_b = found["p_a"], found["p_b"]
    return Signals(
        spool,
        None if p_a is None else np.maximum(p_a, 0.0),
        None if p_b is None else np.maximum(p_b, 0.0),
        found["q_in"],
        found["q_out"],
        volume_a,
        volume_b,
        noise,
        pilot,
    )


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
