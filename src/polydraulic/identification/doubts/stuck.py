"""Values of a log in which a sensor says nothing: it reads its largest value although there is more, or has stopped.

A sensor with noise hardly reads the same number twice. Where one does for many rows, and nowhere else in the log, it is at the end of its range, or frozen.
Coarse sensors, and logs without noise, repeat numbers everywhere: nothing is said of them.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
from polydraulic.tables import Table

_NOISY = 0.15  # share of rows at which a signal with noise turns round, at least
_HELD = 5  # rows of one number that are no chance
_SHARE = 5e-3  # share of all rows in such runs, at the end of a range, at least
_ELSEWHERE = 0.1  # of these, that as long runs at other numbers come to at most
_FROZEN, _LASTING = 50, 2.0  # rows, and s, of one number that nothing but a sensor that has stopped gives
_FEW, _SELDOM = 3, 0.02  # times in a log at most, and share of rows in shorter runs of one number
_NEAR_STOP = 0.02  # rad or m of a joint's stop, where positions do stay
_MOST = 0.5  # share of rows, beyond which it is the sensor that is left out


class Stuck(NamedTuple):
    """A log without the values of sensors that say nothing.

    Attributes
    ----------
    table : Table
        It declares these as missing; sensors that say nothing most of the time are left out.
    texts : list of str
        Which, where, and at what.
    """

    table: Table
    texts: list[str]


def without_stuck(machine: LayoutMachine, table: Table) -> Stuck:
    """Leave out values of sensors at the end of their range, and of those that have stopped.

    Parameters
    ----------
    machine : LayoutMachine
    table : Table
        The log, in SI, with times that rise; values may be missing.

    Returns
    -------
    Stuck
    """
    columns, dead, texts = dict(table.columns), set[str](), list[str]()
    for f in machine.functions:
        for what in ("p_a", "p_b", "q_in", "q_out", "spool", "voltage", position_column(machine, f).split(".")[1]):
            name = f"{f.name}.{what}"
            if name not in table.names or not table.known([name]).any():
                continue
            values, stops = table.columns[name], tuple(f.stops) if what in ("angle", "position") else ()
            rows, told = _silent(table["time"], values, _ends(what, values), stops, table.unit(name))
            if not told:
                continue
            if rows.mean() > _MOST and what.startswith(("p_", "q_")):
                dead.add(name)
                texts.append(f"{name} {' and '.join(told)}: the sensor is not used")
            else:
                columns[name] = np.where(rows, np.nan, values)
                texts.append(f"{name} {' and '.join(told)}: not used there")
    if not texts:
        return Stuck(table, [])
    left = {name: values for name, values in columns.items() if name not in dead}
    return Stuck(Table(left, table.units, table.info).partial(), texts)


def _silent(
    time: np.ndarray, values: np.ndarray, ends: list[float], stops: tuple[float, ...], unit: str
) -> tuple[np.ndarray, list[str]]:
    """Rows in which a sensor says nothing, (n_row,) of bool, and what it does there, in words."""
    rows, told = np.zeros(len(values), dtype=bool), list[str]()
    begin, end = _runs(values)
    if not _noisy(values, begin, end):
        return rows, told
    for most in ends:
        saturated = _at_end(values, begin, end, most)
        if saturated.any() and _strange(most, stops):
            rows |= saturated
            told.append(f"reads {amount(most, unit)}, the end of its range, in {saturated.mean():.1%} of the rows")
    for b, e in _stopped(time, begin, end):
        if not rows[b] and _strange(values[b], stops):
            rows[b:e] = True
            told.append(f"stays at {amount(float(values[b]), unit)} for {time[e - 1] - time[b]:.3g} s")
    return rows, told


def _ends(what: str, values: np.ndarray) -> list[float]:
    """Ends of a sensor's range that a signal may go beyond: a pressure does not fall below zero, spools and levers have ends of their own."""
    if what in ("voltage", "spool"):
        return []
    most = float(np.nanmax(values))
    return [most] if what.startswith("p_") else [most, float(np.nanmin(values))]


def _strange(value: float, stops: tuple[float, ...]) -> bool:
    """Whether a value is none at which a signal may stay: zero, or near a stop of a joint."""
    return value != 0.0 and all(abs(value - stop) > _NEAR_STOP for stop in stops)


def _noisy(values: np.ndarray, begin: np.ndarray, end: np.ndarray) -> bool:
    """Whether a sensor has noise, so that it hardly reads a number twice."""
    steps = np.diff(values[begin])
    turns, short = int((steps[1:] * steps[:-1] < 0.0).sum()), int((end - begin)[end - begin < _HELD].sum())
    return short > 0 and turns > _NOISY * short


def _runs(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First rows of runs of one number, and the rows behind their last ones."""
    cuts = np.flatnonzero(np.diff(values)) + 1
    return np.concatenate([[0], cuts]), np.concatenate([cuts, [len(values)]])


def _at_end(values: np.ndarray, begin: np.ndarray, end: np.ndarray, most: float) -> np.ndarray:
    """Rows at the end of a sensor's range, (n_row,) of bool; none where runs of one number are usual."""
    found = np.zeros(len(values), dtype=bool)
    held = end - begin >= _HELD
    there = values[begin] == most
    rows, others = (int((end - begin)[held & which].sum()) for which in (there, ~there))
    if rows >= _SHARE * len(values) and others <= _ELSEWHERE * rows:
        found = values == most
    return found


def _stopped(time: np.ndarray, begin: np.ndarray, end: np.ndarray) -> list[tuple[int, int]]:
    """Runs of a sensor that has stopped; none where it often reads one number for long."""
    held = (end - begin >= _FROZEN) & (time[end - 1] - time[begin] >= _LASTING)
    elsewhere = int((end - begin)[(end - begin >= _HELD) & ~held].sum())
    if held.sum() > _FEW or elsewhere > _SELDOM * len(time):  # it is how the sensor reads
        return []
    return list(zip(begin[held].tolist(), end[held].tolist(), strict=True))
