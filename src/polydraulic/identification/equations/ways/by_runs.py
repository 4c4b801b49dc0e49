"""What is left, through simulation: voltages and positions of all functions are enough, and whatever else was measured is compared, too.

All numbers are found together, around the values so far.
"""

from collections.abc import Callable

import numpy as np

from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.identification.equations.finished import Finished
from polydraulic.identification.equations.free_numbers import CURVES, PUMP_NUMBERS, PUMPS
from polydraulic.identification.equations.numbers.spreads import spreads_of
from polydraulic.identification.equations.pilot_fit import told_dead_time
from polydraulic.identification.equations.shooting.fit import ShootingFit, fit_by_shooting
from polydraulic.identification.equations.ways.so_far import SoFar, is_mechanical
from polydraulic.parameters.layout.parts import Seen
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
from polydraulic.tables import Table

WAY = "through simulation"
SECONDS, MOST_WINDOWS = 2.0, 64
_SHOWN = {
    "valve": CURVES,
    **dict.fromkeys(PUMPS, PUMP_NUMBERS),
    "pilot": ("gain", "time_constant", "dead_time"),
    "friction": ("coulomb", "static", "viscous"),
    "line": ("compliance_a", "compliance_b", "leakage"),
    "tank": ("return_pressure",),
}


def lacking_for_runs(machine: LayoutMachine, table: Table) -> str:
    """Why a log cannot be simulated, in words; empty if it can."""
    wanted = [name for f in machine.functions for name in (f"{f.name}.voltage", position_column(machine, f))]
    lacks = [name for name in wanted if name not in table.names]
    if lacks:
        return f"the log has no {', '.join(lacks)}"
    levers = [table.whole([name])[name] for name in wanted if name.endswith(".voltage") and table.known([name]).any()]
    return "" if any(np.ptp(lever) > 0.0 for lever in levers) else "no lever moves in the log"


def find_left(
    so_far: SoFar, table: Table, taken: tuple[str, ...], finished: Finished, tell: Callable[[int, int], object]
) -> ShootingFit | None:
    """Numbers that are free and were not found, None where there are none or the log lacks what it takes.

    Parameters
    ----------
    so_far : SoFar
    table : Table
        The log, in SI.
    taken : tuple of str
        Beginnings of paths that were found, or that the log was asked for and does not show.
    finished : Finished
        Where what was interrupted is found, and kept.
    tell : callable
        Told how many pieces of the work are done, and of how many.
    """
    left = entries_left(so_far, taken)
    if not left:
        return None
    lacking = lacking_for_runs(so_far.machine, table)
    try:
        if lacking:
            raise InputError(lacking)
        found = fit_by_shooting(
            table, so_far.machine, spreads_of(so_far.machine, left), seconds=SECONDS, most=MOST_WINDOWS,
            begun=finished.runs(), keep=finished.keep_runs, progress=lambda _, done, total: tell(done, total),
        )  # fmt: skip
    except InputError as error:
        so_far.lacks[WAY] = str(error).removeprefix("table: ")
        return None
    seen = ", ".join(f"{name} to {amount(travel, 'm')}" for name, travel in found.travel.items())
    told = tuple(
        e._replace(value=told_dead_time(e.value, e.sd)) if e.path.endswith(".dead_time") else e
        for e in found.estimates.numbers
    )
    so_far.take_estimates(
        found.estimates._replace(numbers=told),
        f"{so_far.from_log}: simulation of {found.windows} windows of {found.seconds:g} s, travel of {seen} seen",
    )
    if not found.settled:
        so_far.remarks.append(
            "simulation made as many steps as it may, and its runs still came nearer to the log: numbers may be off by more than their standard "
            "errors; begin from the machine that was written, or free fewer numbers"
        )
    for f in so_far.machine.functions:
        if any(f"functions.{f.name}.valve.{key}" in so_far.changes for key in CURVES) and f.name not in so_far.seen:
            ports = [f"{f.name}.{port}" for port in ("p_a", "p_b")]
            measured = [float(table.whole([port])[port].max()) for port in ports if port in table.names]
            so_far.seen[f.name] = Seen(found.travel[f.name], max(measured) if len(measured) == len(ports) else np.inf)
    return found


def entries_left(so_far: SoFar, taken: tuple[str, ...]) -> dict[str, float]:
    """Entries that are left to simulation with their spreads, nan where nothing is said; others that are free are named as kept."""
    machine, largest = so_far.machine, dict[str, float]()
    for number in machine.numbers:
        path = number.path.partition("[")[0]
        largest[path] = max(largest.get(path, 0.0), abs(number.value))
    unlimited = tuple(f"{c.pump_path}.torque" for c in machine.circuits if not c.pump.torque_limit_enabled)
    left = {}
    for path, spread in so_far.may.spreads.items():
        if path.startswith((*taken, *unlimited)):
            continue
        if path not in largest:
            so_far.kept.append(
                f"{path}: kept; the machine does not declare it, and it shows between a pilot and its measured spool alone"
            )
            continue
        above, _, last = path.rpartition(".")
        shown = is_mechanical(path) if path.startswith("links.") else last in _SHOWN.get(above.split(".")[-1], ())
        if np.isfinite(spread) or (shown and (largest[path] > 0.0 or last == "dead_time")):
            left[path] = spread
        elif last != "knots":
            why = "it is 0" if shown else "sizes, places and settings are better measured"
            so_far.kept.append(f"{path}: kept; {why}, and the file says no spread, how far it may be off")
    return left
