"""A log as pieces on an even raster, without gaps, in SI."""

from collections.abc import Mapping, Sequence

import numpy as np

from polydraulic.errors import InputError
from polydraulic.tables import Table

_GAP = 1.5  # rasters
_UNEVEN = 0.05  # of a raster, by which a row may come early or late
_ROUNDING = 1e-6  # of a raster: what lies on a row needs no other


def in_si(table: Table, units: Mapping[str, str]) -> None:
    """Refuse a log with a column in another unit than a machine's runs have it in."""
    for name, unit in units.items():
        if name in table.names and table.unit(name) not in ("", unit):
            raise InputError(
                f"column {name!r} is in {table.unit(name)!r}; a machine is identified in SI, this in {unit!r}"
            )


def segment_column(table: Table) -> np.ndarray:
    """Numbers of the segments that rows lie in, (n_row,); of a log without that column, one."""
    return table["segment"] if "segment" in table.names else np.zeros(len(table))


def raster_segments(table: Table) -> np.ndarray:
    """Numbers of the stretches whose rows follow each other on the raster, (n_row,) of int; times must rise."""
    step = np.diff(table["time"])
    usual = float(np.median(step))
    cut = (np.abs(step - usual) > _UNEVEN * usual) | (np.diff(segment_column(table)) != 0.0)
    return np.concatenate([[0], np.cumsum(cut)])


def raster_of(table: Table) -> float:
    """Time between rows, s.

    Raises
    ------
    InputError
        No two rows of one segment, or times that do not rise.
    """
    time, segment = table["time"], segment_column(table)
    check_rises(time)
    if np.all(np.diff(segment) != 0):
        raise InputError("no two rows of the log follow each other; an identification needs a log as it was recorded")
    return raster_within(time, segment)


def check_rises(time: np.ndarray) -> None:
    """Refuse times that do not rise from row to row, and name the first that does not."""
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if back.size:
        k = int(back[0])
        raise InputError(
            f"column 'time' does not rise from row to row: {time[k]:.10g} s is followed by {time[k + 1]:.10g} s in row {k + 2}, and so in "
            f"{back.size} of {len(time)} rows; give a log as it was recorded, or import it again (polydraulic import)"
        )


def raster_within(time: np.ndarray, segment: np.ndarray) -> float:
    """Time between rows of one segment, s."""
    return float(np.median(np.diff(time)[np.diff(segment) == 0]))


def even_pieces(
    table: Table, columns: Sequence[str], sometimes: Sequence[str] = ()
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Times and columns, (n_row,) and (n_row, n_column), by straight lines between rows; gaps and segments end a piece.

    Of a table that declares missing values, rows in which one of `columns` lacks a value are a gap; those of `sometimes`, which
    follow them, are NaN where they lack one.
    """
    keep, raster = np.flatnonzero(table.known(columns)), raster_of(table)
    if not keep.size:
        raise InputError(f"no row of the log has a value of all of {', '.join(columns)}")
    time, values = table["time"][keep], [table.columns[name][keep] for name in (*columns, *sometimes)]
    cuts = (np.diff(time) > _GAP * raster) | (np.diff(segment_column(table)[keep]) != 0)
    found = []
    for rows in np.split(np.arange(len(time)), np.flatnonzero(cuts) + 1):
        at = time[rows[0]] + raster * np.arange(int((time[rows[-1]] - time[rows[0]]) / raster + 1e-6) + 1)
        found.append((at, np.column_stack([_between(at, time[rows], column[rows]) for column in values])))
    return found


def weighted_sums(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weighted sums along the rows of a piece, of stretches that are whole: (n_row - n_weight + 1, ...) of (n_row, ...)."""
    return np.asarray(np.lib.stride_tricks.sliding_window_view(values, len(weights), axis=0) @ weights)


def _between(at: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values on straight lines between rows, NaN where one of the two has none."""
    lacks = np.isnan(values)
    if not lacks.any():
        return np.interp(at, time, values)
    if lacks.all():
        return np.full(len(at), np.nan)
    share = np.interp(at, time, lacks.astype(float))
    return np.where(share > _ROUNDING, np.nan, np.interp(at, time[~lacks], values[~lacks]))
