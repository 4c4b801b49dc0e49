"""Which rows of a table follow each other in time, and how far apart they are: what dynamic models need to know of a log."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.arguments import names_of_parts, parts_of
from polydraulic.networks.model.model import Model
from polydraulic.tables import Table

# of what a machine's log is read for, by the last part of a column's name
MACHINE_UNITS = {
    "time": "s", "segment": "1", "spool": "m", "p_a": "Pa", "p_b": "Pa", "q_in": "m3/s", "q_out": "m3/s",
    "voltage": "V", "angle": "rad", "position": "m",
}  # fmt: skip
_JUMP = 0.5  # a step in time that differs from the raster by more than this share of it begins a new segment
_JUMPS = 0.1  # share of such steps above which there is no raster
_SAME = 0.01  # relative difference within which two rasters are the same


class LogRows(NamedTuple):
    """How the rows of a log follow each other.

    Attributes
    ----------
    segments : (n_row,) array of int
        Rows of one number follow each other at the raster.
    raster : float or None
        Time between them in s, to six digits; None if the table has no times.
    """

    segments: np.ndarray
    raster: float | None

    @property
    def n_segment(self) -> int:
        """Number of segments."""
        return int(self.segments[-1]) + 1


def log_rows(table: Table) -> LogRows:
    """Raster from the column ``time``; a new segment where ``segment`` changes, or ``time`` jumps.

    Parameters
    ----------
    table : Table
        With a column ``time`` in s that rises by the raster within a segment; ``segment`` may be missing.

    Raises
    ------
    InputError
        No column ``time``, times that stand still, no raster in them, or tables of different rasters.
    """
    if "time" not in table.names:
        raise InputError(
            "the table has no column 'time': a dynamic model needs the raster of its rows; import the log first "
            "(polydraulic import)"
        )
    if len(table) < 2:
        raise InputError(f"the table has {len(table)} row(s): nothing follows anything")
    step = np.diff(table["time"])
    check_one_raster(table)
    same = _same_segment(table)
    if not same.any():
        raise InputError(f"each of the {len(table)} rows is a segment of its own: nothing follows anything")
    usual = float(np.median(step[same]))
    if usual <= 0.0:
        raise InputError(f"the usual step of the column 'time' is {usual:g} s; rows must be in order of time")
    near = np.abs(step / usual - 1.0) <= _JUMP
    jumps = same & ~near
    if jumps.sum() > _JUMPS * same.sum():
        raise InputError(
            f"the column 'time' has no raster: {jumps.sum()} of {same.sum()} steps are not the usual {usual:g} s; "
            "bring the log onto one (polydraulic import)"
        )
    follows = same & near
    # times may be rounded, so that their mean step says more than any one
    raster = float(f"{step[follows].mean():.6g}")
    return LogRows(np.concatenate([[0], np.cumsum(~follows)]), raster)


def _same_segment(table: Table) -> np.ndarray:
    """Which rows follow another one in its segment, (n_row - 1,) of bool."""
    return np.diff(table["segment"]) == 0.0 if "segment" in table.names else np.ones(len(table) - 1, dtype=bool)


def check_one_raster(table: Table) -> None:
    """Refuse tables that have been put together and have rasters of their own.

    Raises
    ------
    InputError
        Two that differ by a hundredth.
    """
    ends = np.cumsum([0, *parts_of(table)])
    step, same = np.diff(table["time"]), _same_segment(table)
    usual = {}
    for name, low, high in zip(names_of_parts(table), ends[:-1], ends[1:], strict=True) if len(ends) > 2 else ():
        own = step[low : high - 1][same[low : high - 1]]
        if own.size:
            usual[name] = float(np.median(own))
    for name, raster in usual.items():
        first = next(iter(usual))
        if abs(raster - usual[first]) > _SAME * abs(usual[first]):
            raise InputError(
                f"{name}: rows are {raster:g} s apart, those of {first} {usual[first]:g} s; import both logs with the same raster"
            )


def rows_for(models: Sequence[Model], table: Table) -> LogRows:
    """The same for a log that dynamic models are to be run on.

    Parameters
    ----------
    models : sequence of Model
        Dynamic ones. If they do not state their raster, a table without a column ``time`` is one segment.
    table : Table

    Raises
    ------
    InputError
        As `log_rows`; another raster than that of the models.
    """
    stated = models[0].dynamics.raster if models[0].dynamics else None
    if stated is None and "time" not in table.names:
        return LogRows(np.zeros(len(table), dtype=int), None)
    rows = log_rows(table)
    if stated is not None and rows.raster is not None and abs(rows.raster / stated - 1.0) > _SAME:
        raise InputError(
            f"the rows of the table are {rows.raster:g} s apart, those of the model {stated:g} s: "
            f'import the log with raster = "{1e3 * stated:g} ms"'
        )
    return rows
