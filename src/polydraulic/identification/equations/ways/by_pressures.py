"""Masses and friction from pressures and positions of all functions, by regression.

They change only where somebody marks them, or where a log tells nothing else: a data sheet often knows them better.
"""

import numpy as np

from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.fit import MechanicsFit, fit_mechanics, mechanical_spreads
from polydraulic.identification.equations.ways.so_far import SoFar, is_mechanical
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table

# times the noise, and of the torque itself: with perfect sensors any remainder is beyond noise
_BEYOND, _MATTERS = 3.0, 0.02
WAY = "masses and friction from pressures"


def find_mechanics(so_far: SoFar, table: Table, *, unasked: bool) -> MechanicsFit | None:
    """Masses and friction, None where none is free or the log lacks what it takes.

    Parameters
    ----------
    so_far : SoFar
    table : Table
        The log, in SI.
    unasked : bool
        Whether they are free where nothing is marked.
    """
    machine, may = so_far.machine, so_far.may
    usual = mechanical_spreads(machine)
    if unasked and not may.marked:
        spreads = usual
    else:
        spreads = {path: may.spread(path, usual.get(path, np.nan)) for path in may.spreads if is_mechanical(path)}
        spreads = {path: spread for path, spread in spreads.items() if np.isfinite(spread)}
    if not spreads:
        return None
    try:
        found = fit_mechanics(table, machine, spreads)
    except InputError as error:
        so_far.lacks[WAY] = str(error).removeprefix("table: ")
        return None
    ports = [f"{f}.{p}" for f in machine.names for p in ("p_a", "p_b")]
    pressures = [table.whole([port])[port] for port in ports]
    low, high = min(float(p.min()) for p in pressures), max(float(p.max()) for p in pressures)
    so_far.take_estimates(
        found.estimates,
        f"{so_far.from_log}: torques of the oil, pressure {amount(low, 'Pa')} to {amount(high, 'Pa')} seen",
    )
    so_far.remarks += beyond_noise(machine, found)
    return found


def beyond_noise(machine: LayoutMachine, found: MechanicsFit) -> list[str]:
    """Sentences on torques of which more is left than sensors' noise makes."""
    said = []
    for f, left, noise, torque in zip(machine.functions, found.residual, found.noise, found.torque, strict=True):
        if left > _BEYOND * noise and left > _MATTERS * torque:
            unit = "N" if machine.link(f.moves).joint == "prismatic" else "N m"
            said.append(
                f"torques at {f.name}: what the equations leave, {amount(left, unit)}, is {left / noise:.0f} times what noise of the sensors makes; the "
                "log has something that they do not, such as a load during a part of it, so that masses and friction may be off by more than their "
                "standard errors"
            )
    return said
