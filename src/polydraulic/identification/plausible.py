"""Whether the numbers of a log can be those of a machine in SI, whatever its table says of units."""

from collections.abc import Collection
from math import pi

import numpy as np

from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
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
    "p_pump": "Pa",
}
_BEYOND = 0.1  # rad or m, that a sensor may be off
_LEAST_PRESSURE = 1e5  # Pa
_SLOWEST = 1.0  # s between rows; a joystick or a valve moves within one
_MOST_PRESSURE = 2e8  # Pa, several times what mobile hydraulics stands
_LEAST_OF_ONE = 1e4  # Pa, which even the port of a returning line passes; 10,000 psi and more nobody has
_TRAVELS, _FLOWS = 5.0, 100.0  # times the valve's travel and the largest pump's flow, beyond which a unit is wrong
_FOLLOWS = 1.5  # times the usual step in time, within which a row follows another one
_LEVERS = 10.0  # times the voltage of full travel
_MANY = 0.05  # share of rows that are no outliers
_CONTRADICTED = 0.2  # of the pump's flow: what equations or networks leave of a flow is a few per cent of it where the log is of the machine


def check_functions(machine: LayoutMachine, table: Table) -> None:
    """Refuse a log that has no column of any function of the machine: it is another machine's, or its channels have other names."""
    if not any(name.partition(".")[0] in machine.names for name in table.names):
        raise InputError(
            f"the log has no column of {', '.join(machine.names)}, the functions of {machine.title!r}: choose the machine that the log is of "
            f"(--machine), or give its channels names such as {machine.names[0]}.voltage where it is imported"
        )


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
        Where an angle jumps by more than half a turn from row to row, most rows of a position lie far beyond the joint's stops, many of a spool or a
        flow beyond all that the machine has, no pressure of the log comes to one bar, or a single one that varies not to a tenth of it; or levers go
        many times beyond the voltage of full travel; where rows come too seldom to show anything.
    """
    if "time" in table.names and len(table) > 1 and (raster := float(np.median(np.diff(table["time"])))) > _SLOWEST:
        raise InputError(
            f"rows come every {raster:g} s, and joints and valves follow their levers within {_SLOWEST:g} s: column 'time' must be in s; import the "
            "log with its unit"
        )
    most_flow = _FLOWS * max(circuit.pump.flow for circuit in machine.circuits)
    for f in machine.functions:
        name = position_column(machine, f)
        if name in table.names:
            _check_goes_on(table, name)
            far = np.maximum(_known(table, name) - f.stops.high, f.stops.low - _known(table, name)) > _BEYOND
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
            if name in table.names and (np.abs(_known(table, name)) > most).mean() > _MANY:
                raise _not_si(table, name, f"no more than {most:.4g} {unit} can be: it must be in {unit}")
        name, full = f"{f.name}.voltage", f.valve.knots[-1] / f.pilot.gain
        if name in table.names and (np.abs(_known(table, name)) > _LEVERS * full).mean() > _MANY:
            raise _not_si(
                table,
                name,
                f"and by the file's pilot {amount(full, 'V')} gives full travel: it must be in V, not in per cent of a lever's way",
            )
    check_pressures(table, machine.names)
    for name in (f"{circuit.name}.p_pump" for circuit in machine.circuits):
        if name in table.names and 0.0 < _known(table, name).max() < _LEAST_PRESSURE:
            raise _not_si(table, name, "and a pump that feeds valves has more than 1 bar: it must be in Pa")


def _check_goes_on(table: Table, name: str) -> None:
    """Refuse an angle that begins anew after a full turn: differences of it are no motion."""
    if not name.endswith(".angle") or "time" not in table.names:
        return
    some = table.whole(["time", name])
    time, angle = some["time"], some[name]
    step = np.diff(time)
    jumps = np.flatnonzero((np.abs(np.diff(angle)) > pi) & (step <= _FOLLOWS * np.median(step)) if step.size else [])
    if jumps.size:
        k = int(jumps[0])
        raise InputError(
            f"column {name!r} goes from {angle[k]:.4g} to {angle[k + 1]:.4g} rad at {time[k + 1]:.10g} s, and so by more than half a turn in "
            f"{jumps.size} row(s): an angle must go on past a full turn; import the log again, which does so, or numpy.unwrap it"
        )


def check_pressures(table: Table, functions: Collection[str]) -> None:
    """Refuse pressures at ports of functions that are not in Pa.

    None of the log comes to one bar, or a single one that varies not to a tenth of it, or many rows are beyond what any hydraulics stands.
    """
    ports = [f"{function}.{port}" for function in functions for port in ("p_a", "p_b")]
    highest = {name: float(_known(table, name).max()) for name in ports if name in table.names}
    most = max(highest.values(), default=0.0)
    if 0.0 < most < _LEAST_PRESSURE:
        raise InputError(
            f"the largest pressure at a port of the log is {most:.4g} Pa, and oil that works has more than 1 bar, {_LEAST_PRESSURE:g} Pa: pressures "
            "must be in Pa; import the log with the sensors' unit"
        )
    for name, largest in highest.items():
        if (_known(table, name) > _MOST_PRESSURE).mean() > _MANY:
            raise _not_si(table, name, f"no more than {amount(_MOST_PRESSURE, 'Pa')} can be: it must be in Pa")
        if 0.0 < largest < _LEAST_OF_ONE and np.ptp(_known(table, name)) > 0.0:
            raise InputError(
                f"column {name!r} comes to {largest:.4g} Pa at most, others to {amount(most, 'Pa')}: it must be in Pa; import the log with that "
                "sensor's unit, or leave the column out if the sensor is dead"
            )


def _known(table: Table, name: str) -> np.ndarray:
    """What values a column has; it may lack some."""
    return table.whole([name])[name]


def _not_si(table: Table, name: str, why: str) -> InputError:
    values = _known(table, name)
    return InputError(
        f"column {name!r} lies between {values.min():.4g} and {values.max():.4g}, {why}; import the log with the sensor's unit"
    )


def contradictions(function: str, left: float, pump_flow: float) -> list[str]:
    """A sentence on a valve of which so much of a flow is left (m3/s, on rows held out) that its sensors contradict each other; or none."""
    if not left > _CONTRADICTED * pump_flow:
        return []
    return [
        f"flows of {function} are {100.0 * left / pump_flow:.0f} % of the pump's off on rows held out: its sensors contradict each other; look "
        f"whether the sign of {function}.spool is turned, {function}.p_a and {function}.p_b are exchanged, or a clock is shifted"
    ]
