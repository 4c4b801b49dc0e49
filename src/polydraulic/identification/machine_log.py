"""The log of a whole machine: what sensors read -> what circuits see, and which rows say something of a network.

What must be known is the pumps' flow and relief setting, the return pressure and the borders of spool travel; neither orifice areas
nor pump pressures.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.networks.model.model import Model
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.tables import Table

MEASURED = ("spool", "p_a", "p_b", "q_in", "q_out")  # of each link
UNITS = {"time": "s", "segment": "1", "spool": "m", "p_a": "Pa", "p_b": "Pa", "q_in": "m3/s", "q_out": "m3/s"}
_DERIVED = {"travel": "m", "p_in": "Pa", "root_p_out": "Pa^0.5", "k_out": "m3/s/Pa^0.5", "q_passed": "m3/s"}
ROOT_LEAST = float(np.sqrt(units.to_si(75.0, "psi")))  # below it a pressure drop says little of a conductance
BELOW_RELIEF = 0.98  # above this share of the relief setting the flow falls to nothing within what a sensor can tell


class Known(NamedTuple):
    """What must be known of a machine to read its log.

    Attributes
    ----------
    deadband : float, m
        Spool travel at which valves open.
    return_pressure, relief : float, Pa
    series_flow : float, m3/s
        Of the pump of swing and stick.
    """

    deadband: float
    return_pressure: float
    relief: float
    series_flow: float

    @classmethod
    def of(cls, machine: Machine) -> "Known":
        """From a parameter set."""
        pumps = machine.pumps
        return cls(machine.spool.deadband, machine.tank.return_pressure, pumps.relief, pumps.series_flow)


def by_port(known: Known, log: Table) -> Table:
    """What circuits see, from what sensors read: pressures by what the spool connects, travels, conductances, the passed flow.

    Parameters
    ----------
    known : Known
    log : Table
        ``LINK.spool``, ``LINK.p_a``, ``LINK.p_b``, ``LINK.q_in`` and ``LINK.q_out`` of all three links, in SI; ``time`` and ``segment``
        are kept.

    Raises
    ------
    InputError
        If one of them is missing or in another unit.
    """
    names = [name for name in log.names if name in ("time", "segment")]
    columns = {name: log[name] for name in (*names, *(f"{link}.{what}" for link in LINKS for what in MEASURED))}
    for name in columns:
        si = UNITS.get(name.split(".")[-1], "")
        if log.unit(name) not in ("", si):
            raise InputError(f"column {name!r} is in {log.unit(name)!r}; a machine is learnt in SI, this in {si!r}")
    for link in LINKS:  # a shut valve passes nothing: what a sensor says of it is noise, or a joint that coasts
        shut = np.abs(columns[f"{link}.spool"]) <= known.deadband
        for port in ("q_in", "q_out"):
            columns[f"{link}.{port}"] = np.where(shut, 0.0, columns[f"{link}.{port}"])
        columns |= _ports(known, link, columns)
    columns["series.q_passed"] = np.clip(known.series_flow - columns["swing.q_in"], 0.0, known.series_flow)
    of_columns = UNITS | _DERIVED
    return Table(columns, {name: of_columns.get(name.split(".")[-1], "") for name in columns}, dict(log.info))


def _ports(known: Known, link: str, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Pressures by what the spool connects, spool travel, conductance of the outlet (Eq. 7)."""
    forward = columns[f"{link}.spool"] > 0.0
    p_a, p_b = (np.maximum(columns[f"{link}.{port}"], 0.0) for port in ("p_a", "p_b"))
    p_out = np.where(forward, p_b, p_a)
    root = np.sqrt(np.maximum(p_out - known.return_pressure, 0.0))
    return {
        f"{link}.travel": np.abs(columns[f"{link}.spool"]),
        f"{link}.p_in": np.where(forward, p_a, p_b),
        f"{link}.root_p_out": root,
        f"{link}.k_out": columns[f"{link}.q_out"] / np.maximum(root, ROOT_LEAST),
    }


def judging_rows(output: str, log: Table, known: Known) -> np.ndarray:
    """Rows that say something of a network, (n_row,) array of bool.

    The valve is open. At an outlet the pressure drops; at an inlet it stays below the relief setting by two hundredths, since no
    network learns from what is above.

    Parameters
    ----------
    output : str
        ``LINK.q_in`` or ``LINK.k_out``.
    log : Table
        From `by_port`.
    known : Known
    """
    link, what = output.split(".")
    says = (
        log[f"{link}.root_p_out"] > ROOT_LEAST if what == "k_out" else log[f"{link}.p_in"] < BELOW_RELIEF * known.relief
    )
    return np.asarray((log[f"{link}.travel"] > known.deadband) & says)


def as_judged(model: Model, table: Table) -> Table:
    """What a network of a machine is judged by, from an imported log; the table of any other model as it is.

    Parameters
    ----------
    model : Model
        From `fit_machine`, or its file: ``log`` in its training says how to read a log.
    table : Table
        With the columns that `by_port` needs.

    Raises
    ------
    InputError
        A column is missing or in another unit, or the valve never opens.
    """
    known = _known_by(model)
    if known is None:
        return table
    log = by_port(known, table)
    rows = judging_rows(model.output.name, log, known)
    if not rows.any():
        raise InputError(f"no row of {len(log)} says anything about {model.output.name!r}: its valve never opens")
    return some_rows(log, rows)


def judged_by(model: Model) -> list[str]:
    """Columns that `as_judged` and a judgement of the model need: of a machine's network those of an imported log."""
    if _known_by(model) is None:
        return [variable.name for variable in (*model.inputs, model.output)]
    return [f"{link}.{what}" for link in LINKS for what in MEASURED]


def _known_by(model: Model) -> Known | None:
    """What a network of a machine says that must be known to read a log; None for any other model."""
    how: Any = model.training.get("log")
    return Known(**how) if isinstance(how, dict) and set(how) == set(Known._fields) else None


def some_rows(table: Table, keep: np.ndarray) -> Table:
    """Rows of a table, by an array of bool."""
    return Table({name: values[keep] for name, values in table.columns.items()}, table.units)
