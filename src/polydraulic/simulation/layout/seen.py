"""What went beyond the log that a machine was identified from: a spool, or the pressure at the port that an open valve feeds."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import Columns


class SeenLimits(NamedTuple):
    """How far the log went, by function; inf where a function was not identified.

    Attributes
    ----------
    opens, travel : (n_function,) array, m
        Travel at which a valve opens, and the largest that was seen.
    pressure : (n_function,) array, Pa
        The largest at the port that an open valve feeds.
    """

    opens: np.ndarray
    travel: np.ndarray
    pressure: np.ndarray


def seen_limits(machine: LayoutMachine) -> SeenLimits:
    """How far the log of a machine went."""
    opens = [
        next((k for k, wide in zip(f.valve.knots, f.valve.inlet[1:], strict=False) if wide > 0.0), 0.0)
        for f in machine.functions
    ]
    seen = [(np.inf, np.inf) if f.seen is None else (f.seen.travel, f.seen.pressure) for f in machine.functions]
    return SeenLimits(np.array(opens), *np.array(seen).T.copy())


@kernel
def goes_beyond(spool: float, p_a: float, p_b: float, opens: float, most: float, highest: float) -> bool:
    """Whether a valve's travel, or the pressure at the port that it feeds when it is open, is beyond the log; see `SeenLimits`."""
    travel, pressure = abs(spool), p_a if spool > 0.0 else p_b
    return travel > most or (travel > opens and pressure > highest)


def is_identified(machine: LayoutMachine) -> bool:
    """Whether a log was seen of any function."""
    return any(f.seen is not None for f in machine.functions)


def lane_limits(machines: Sequence[LayoutMachine]) -> np.ndarray:
    """Limits of machines side by side, (3, n_function, n_machine) in the order of `SeenLimits`; (0, n_function, n_machine) if none was identified."""
    if not any(is_identified(machine) for machine in machines):
        return np.zeros((0, len(machines[0].names), len(machines)))
    return np.stack([np.array(seen_limits(machine)) for machine in machines], axis=-1)


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
    if not is_identified(machine):
        return None
    limits = seen_limits(machine)
    spool, p_a, p_b = (
        rows[:, [columns.place[f"{name}.{key}"] for name in machine.names]] for key in ("spool", "p_a", "p_b")
    )
    travel = np.abs(spool)
    fed = (travel > limits.opens) & (np.where(spool > 0.0, p_a, p_b) > limits.pressure)
    return np.asarray(((travel > limits.travel) | fed).any(axis=1))
