"""Rows of a run that went beyond what the log of an identified machine had."""

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import Columns


def beyond_seen(machine: LayoutMachine, columns: Columns, rows: np.ndarray) -> np.ndarray | None:
    """Whether a spool, or the pressure at the port that an open valve feeds, went further than any of the log.

    Parameters
    ----------
    machine : LayoutMachine
    columns : Columns
        Of the rows.
    rows : (n_row, n_column) array

    Returns
    -------
    (n_row,) array of bool, or None for a machine that was not identified
    """
    if all(f.seen is None for f in machine.functions):
        return None
    found = np.zeros(len(rows), dtype=bool)
    for f in machine.functions:
        if f.seen is not None:
            spool, p_a, p_b = (rows[:, columns.place[f"{f.name}.{key}"]] for key in ("spool", "p_a", "p_b"))
            opens = next((k for k, wide in zip(f.valve.knots, f.valve.inlet[1:], strict=False) if wide > 0.0), 0.0)
            fed = (np.abs(spool) > opens) & (np.where(spool > 0.0, p_a, p_b) > f.seen.pressure)
            found |= (np.abs(spool) > f.seen.travel) | fed
    return found
