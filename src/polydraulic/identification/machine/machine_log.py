"""The log of a whole machine: what sensors read -> what circuits see, and which rows say something of a network.

What must be known is each pump's flow and relief setting, the return pressure and the travel at which each valve opens; neither orifice
areas nor pump pressures.
"""

from collections.abc import Sequence
from math import inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.flow.layout.database import chosen_circuits
from polydraulic.flow.layout.slots import passed_name
from polydraulic.identification.log_rows import MACHINE_UNITS
from polydraulic.machine.valve import spool_edges
from polydraulic.networks.model.model import Model
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table

MEASURED = ("spool", "p_a", "p_b", "q_in", "q_out")  # of each function
_READ = {name: MACHINE_UNITS[name] for name in ("time", "segment", *MEASURED)}
_DERIVED = {"travel": "m", "p_in": "Pa", "root_p_out": "Pa^0.5", "k_out": "m3/s/Pa^0.5"}
ROOT_LEAST = float(np.sqrt(units.to_si(75.0, "psi")))  # below it a pressure drop says little of a conductance
BELOW_RELIEF = 0.98  # above this share of the relief setting the flow falls to nothing within what a sensor can tell


class KnownCircuit(NamedTuple):
    """What must be known of a pump: its flow in m3/s, its relief setting in Pa, and the functions that it feeds, from the pump on.

    `closes`, in m, are the travels beyond which the valves of these functions pass nothing on; infinite where one always does.
    """

    flow: float
    relief: float
    functions: tuple[str, ...]
    closes: tuple[float, ...]


class Known(NamedTuple):
    """What must be known of a machine to read its log.

    Attributes
    ----------
    return_pressure : float, Pa
    deadband : dict from function to float, m
        Spool travel at which its valve opens.
    circuits : dict from name to KnownCircuit
    """

    return_pressure: float
    deadband: dict[str, float]
    circuits: dict[str, KnownCircuit]

    @classmethod
    def of(cls, machine: LayoutMachine, circuits: Sequence[str] | None = None) -> "Known":
        """From circuits of a machine, all if none are named, whose valves are in series.

        Raises
        ------
        InputError
            If there is no such circuit, or one of another kind.
        """
        found = chosen_circuits(machine, circuits)
        fed = [name for c in found for name in c.functions]
        return cls(
            machine.tank.return_pressure,
            {f.name: spool_edges(f.valve)[0] for f in machine.functions if f.name in fed},
            {
                c.name: KnownCircuit(
                    c.pump.flow,
                    c.pump.relief,
                    c.functions,
                    tuple(spool_edges(machine.function(name).valve)[1] for name in c.functions),
                )
                for c in found
            },
        )

    @property
    def functions(self) -> tuple[str, ...]:
        """All functions of these circuits, in the machine's order."""
        return tuple(self.deadband)

    def circuit(self, function: str) -> KnownCircuit:
        """The circuit of a function."""
        return next(c for c in self.circuits.values() if function in c.functions)

    def to_data(self) -> dict[str, Any]:
        """For a model file, whose numbers are finite: a bypass that never closes is None there; `from_data` reads it."""
        circuits = {
            name: {
                **c._asdict(),
                "functions": list(c.functions),
                "closes": [x if isfinite(x) else None for x in c.closes],
            }
            for name, c in self.circuits.items()
        }
        return {**self._asdict(), "circuits": circuits}

    @classmethod
    def from_data(cls, data: dict[str, Any]) -> "Known":
        """From what `to_data` gave; an AttributeError, KeyError, TypeError or ValueError of anything else."""
        circuits = {
            name: KnownCircuit(
                float(c["flow"]),
                float(c["relief"]),
                tuple(c["functions"]),
                tuple(inf if x is None else float(x) for x in c["closes"]),
            )
            for name, c in data["circuits"].items()
        }
        deadband = {name: float(travel) for name, travel in data["deadband"].items()}
        return cls(float(data["return_pressure"]), deadband, circuits)

    def measured(self) -> list[str]:
        """Columns of a log that are read, besides the time."""
        return [f"{function}.{what}" for function in self.functions for what in MEASURED]


def by_port(known: Known, log: Table) -> Table:
    """What circuits see, from what sensors read: pressures by what the spool connects, travels, conductances, the passed flow.

    Parameters
    ----------
    known : Known
    log : Table
        ``NAME.spool``, ``NAME.p_a``, ``NAME.p_b``, ``NAME.q_in`` and ``NAME.q_out`` of all functions, in SI; ``time`` and ``segment``
        are kept.

    Raises
    ------
    InputError
        If one of them is missing or in another unit.
    """
    names = [name for name in log.names if name in ("time", "segment")]
    columns = {name: log[name] for name in (*names, *known.measured())}
    for name in columns:
        si = _READ.get(name.split(".")[-1], "")
        if log.unit(name) not in ("", si):
            raise InputError(f"column {name!r} is in {log.unit(name)!r}; a machine is learnt in SI, this in {si!r}")
    # a shut valve passes nothing: what a sensor says of it is noise, or a joint that coasts
    for function in known.functions:
        shut = np.abs(columns[f"{function}.spool"]) <= known.deadband[function]
        for port in ("q_in", "q_out"):
            columns[f"{function}.{port}"] = np.where(shut, 0.0, columns[f"{function}.{port}"])
        columns |= _ports(known, function, columns)
    of_columns = _READ | _DERIVED
    shown = {name: of_columns.get(name.split(".")[-1], "") for name in columns}
    for circuit, c in known.circuits.items():
        left: Any = c.flow
        for place, (function, closes) in enumerate(zip(c.functions[:-1], c.closes, strict=False), 1):
            left = np.clip(left - columns[f"{function}.q_in"], 0.0, c.flow)
            # as the flow model has it: what an actuator at its stop leaves of the pump's flow goes over the relief valve
            left = np.where(columns[f"{function}.travel"] <= closes, left, 0.0)
            name = passed_name(circuit, len(c.functions), place)
            columns[name], shown[name] = left, "m3/s"
    return Table(columns, shown, dict(log.info))


def _ports(known: Known, function: str, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Pressures by what the spool connects, spool travel, conductance of the outlet (Eq. 7)."""
    forward = columns[f"{function}.spool"] > 0.0
    p_a, p_b = (np.maximum(columns[f"{function}.{port}"], 0.0) for port in ("p_a", "p_b"))
    p_out = np.where(forward, p_b, p_a)
    root = np.sqrt(np.maximum(p_out - known.return_pressure, 0.0))
    return {
        f"{function}.travel": np.abs(columns[f"{function}.spool"]),
        f"{function}.p_in": np.where(forward, p_a, p_b),
        f"{function}.root_p_out": root,
        f"{function}.k_out": columns[f"{function}.q_out"] / np.maximum(root, ROOT_LEAST),
    }


def judging_rows(output: str, log: Table, known: Known) -> np.ndarray:
    """Rows that say something of a network, (n_row,) array of bool.

    The valve is open. At an outlet the pressure drops; at an inlet it stays below the relief setting by two hundredths, since no
    network learns from what is above.

    Parameters
    ----------
    output : str
        ``NAME.q_in`` or ``NAME.k_out``.
    log : Table
        From `by_port`.
    known : Known
    """
    function, what = output.split(".")
    says = (
        log[f"{function}.root_p_out"] > ROOT_LEAST
        if what == "k_out"
        else log[f"{function}.p_in"] < BELOW_RELIEF * known.circuit(function).relief
    )
    return np.asarray((log[f"{function}.travel"] > known.deadband[function]) & says)


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
    known = _known_by(model)
    return [variable.name for variable in (*model.inputs, model.output)] if known is None else known.measured()


def _known_by(model: Model) -> Known | None:
    """What a network of a machine says that must be known to read a log; None for any other model."""
    how: Any = model.training.get("log")
    if not isinstance(how, dict):
        return None
    try:
        if set(how) == set(Known._fields) and all(
            set(c) == set(KnownCircuit._fields) for c in how["circuits"].values()
        ):
            return Known.from_data(how)
    except (AttributeError, KeyError, TypeError, ValueError):  # a file that somebody changed
        pass
    raise InputError(
        f"the model of {model.output.name!r} does not say how to read a log: it was learnt by an earlier version, which wrote less of it, or its file "
        "was changed; learn it again (polydraulic fit-machine)"
    )


def some_rows(table: Table, keep: np.ndarray) -> Table:
    """Rows of a table, by an array of bool."""
    return Table({name: values[keep] for name, values in table.columns.items()}, table.units)
