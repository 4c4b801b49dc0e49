"""How good a machine learnt from a log is: networks learnt without blocks of time of it, judged by these blocks."""

from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.machine_fit import BELOW_RELIEF, CELL, ROOT_LEAST, Known, by_port, learn
from polydraulic.identification.table_fit import HeldOut, TableFit, judged
from polydraulic.networks.model.model import Model
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

_FOLD, _BLOCKS = 5, 20  # one of so many blocks of time is held out, and so many there are at least
_BLOCK = 30.0  # s, of a longer log: what a pump does comes and goes with the work, and few long blocks hold few kinds of work
_WORSE = 1.1  # times the error of the earlier network on rows that it has not seen, above which one that has seen them is not released
_LEARNT, _HELD = 200, 50  # rows with an open valve that it takes to learn a network, and to judge it
_BEYOND = 1.5  # times what a machine can do, above which a number has the wrong unit
_NO_PRESSURE = 1e4  # Pa; a machine whose pressures all stay below it does not work, or they are no Pa


class LearntMachine(NamedTuple):
    """A machine learnt from a log.

    Attributes
    ----------
    fits : list of TableFit
        Of all six networks; their models are learnt from all rows and state in `training` how those `without` did on the rows
        held out. A model that errs more there, on rows it has seen, gives way to the one without: ``learnt_from`` says so.
    without : list of Model
        Learnt without the rows held out.
    held : (n_row,) array of bool
        Rows held out.
    """

    fits: list[TableFit]
    without: list[Model]
    held: np.ndarray

    @property
    def models(self) -> list[Model]:
        """The networks to be used."""
        return [fit.model for fit in self.fits]


def learn_and_judge(machine: Machine, log: Table, progress: Progress = quiet) -> LearntMachine:
    """Networks of all circuits from a log, and how good they are on blocks of time that were held out.

    Every fifth block of time is held out: blocks of half a minute, or twenty of a log under ten minutes. Networks are judged by
    `judging_rows` of them.

    Parameters
    ----------
    machine : Machine
    log : Table
        From `by_port`, with the column ``time``.
    progress : Progress, optional
        Called twelve times: told each output as it begins without the rows held out, and as it begins with all.

    Returns
    -------
    Learnt
        The `training` of a model holds, besides what `fit_table` writes: ``held_out_flow_rms`` and ``held_out_flow_largest`` in m3/s,
        the errors as flows (of an outlet: conductance times the root of the measured pressure drop), ``pump_flow`` in m3/s, ``learnt_from``, and
        ``log``, by which `as_judged` reads another log.

    Raises
    ------
    InputError
        A valve that never opens, too few rows with an open valve in the blocks held out or in the others, numbers in other units.
    """
    _check_numbers(machine, log)
    known = Known.of(machine)
    held = _held_out(log)
    _check_rows(log, held, known)
    without = learn(machine, _rows(log, ~held), lambda output, done, n: progress(f"{output}: hold out", done, 2 * n))
    models = learn(machine, log, lambda output, done, n: progress(f"{output}: all rows", n + done, 2 * n))
    return LearntMachine([_fit(machine, log, held, *pair) for pair in zip(models, without, strict=True)], without, held)


def _fit(machine: Machine, log: Table, held: np.ndarray, model: Model, earlier: Model) -> TableFit:
    """The network of all rows, with the errors of the earlier one on the rows held out; the earlier one where it is better there."""
    known, output = Known.of(machine), model.output.name
    link = output.split(".")[0]
    judging = judging_rows(output, log, known)
    rows = _rows(log, held & judging)
    X, y = rows.matrix([variable.name for variable in model.inputs]), rows[output]
    # regions are found anew each time: a search that ends badly must not be released with the errors of one that did not
    worse = _rms(model.predict(X) - y) > _WORSE * _rms(earlier.predict(X) - y)
    fit = judged(
        earlier if worse else model, HeldOut(X, y, earlier.predict(X), True), int(np.sum(~held)) if worse else len(log)
    )
    error = fit.held.predicted - y
    flow = error * rows[f"{link}.root_p_out"] if output.endswith("k_out") else error
    fit.model.training.update(
        learnt_from="rows not held out" if worse else "all rows",
        held_out_flow_rms=_rms(flow),
        held_out_flow_largest=float(np.abs(flow).max()),
        pump_flow=machine.pumps.boom_flow if link == "boom" else machine.pumps.series_flow,
        log=known._asdict(),
    )
    return fit


def _rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(error * error)))


def as_judged(model: Model, table: Table) -> Table:
    """What a network of a machine is judged by, from an imported log; the table of any other model as it is.

    Parameters
    ----------
    model : Model
        From `learn_and_judge`, or its file: ``log`` in its training says how to read a log.
    table : Table
        With the columns that `by_port` needs.

    Raises
    ------
    InputError
        A column is missing or in another unit, or the valve never opens.
    """
    how: Any = model.training.get("log")
    if not isinstance(how, dict) or set(how) != set(Known._fields):
        return table
    known = Known(**how)
    log = by_port(known, table)
    rows = judging_rows(model.output.name, log, known)
    if not rows.any():
        raise InputError(f"no row of {len(log)} says anything of {model.output.name!r}: its valve never opens")
    return _rows(log, rows)


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


def one_sided(log: Table, known: Known) -> list[str]:
    """Sentences on spools that hardly open to one of their sides: the outlet there is not learnt."""
    found = []
    for link in LINKS:
        for sign, side in ((1.0, "positive"), (-1.0, "negative")):
            count = int(np.sum(sign * log[f"{link}.spool"] > known.deadband))
            if count < CELL:
                found.append(
                    f"{link}.spool opens its valve to the {side} side in {count} of {len(log)} rows: nothing is known of it there"
                )
    return found


def _held_out(log: Table) -> np.ndarray:
    """Every fifth block of time, (n_row,) array of bool; pauses of the log do not count."""
    n = len(log)
    blocks = max(_BLOCKS, round(n * float(np.median(np.diff(log["time"]))) / _BLOCK)) if n > 1 else _BLOCKS
    return np.asarray(np.arange(n) * blocks // n % _FOLD == _FOLD - 1) if n else np.zeros(0, dtype=bool)


def _check_numbers(machine: Machine, log: Table) -> None:
    """Refuse a log whose numbers cannot be SI."""
    relief, travel = machine.pumps.relief, machine.spool.knots[-1]
    for link in LINKS:
        pump = machine.pumps.boom_flow if link == "boom" else machine.pumps.series_flow
        for name, most, unit in ((f"{link}.spool", travel, "m"), (f"{link}.q_in", pump, "m3/s")):
            # one row may be anything, a hundredth of them not
            reached = float(np.quantile(np.abs(log[name]), 0.99))
            if reached > _BEYOND * most:
                raise InputError(
                    f"{name} goes to {reached:.4g} {unit}; the machine's goes to {most:.4g} {unit}: "
                    "give the channel map the unit of the log, or the parameter set of this machine"
                )
        highest = max(float(np.quantile(log[f"{link}.{port}"], 0.99)) for port in ("p_a", "p_b"))
        if highest < _NO_PRESSURE or highest > 10.0 * relief:
            raise InputError(
                f"{link}.p_a and {link}.p_b go to {highest:.4g} Pa; the relief valve opens at {relief:.4g} Pa: "
                "give the channel map the unit of the log"
            )


def _check_rows(log: Table, held: np.ndarray, known: Known) -> None:
    """Refuse a log that says too little of one of the valves."""
    for link in LINKS:
        reached = float(log[f"{link}.travel"].max()) if len(log) else 0.0
        if reached <= known.deadband:
            raise InputError(
                f"{link}.spool goes to {reached:.4g} m in {len(log)} rows and its valve opens at {known.deadband:.4g} m: nothing "
                f"can be learnt of it; record a log in which the {link} moves"
            )
        for what in ("q_in", "k_out"):
            rows = judging_rows(f"{link}.{what}", log, known)
            learnt, left = int(np.sum(rows & ~held)), int(np.sum(rows & held))
            if learnt < _LEARNT or left < _HELD:
                raise InputError(
                    f"{link}.{what}: {learnt} rows say something of it, and {left} in the blocks of time held out; it takes {_LEARNT} and "
                    f"{_HELD}: record longer, or move the {link} more often"
                )


def _rows(table: Table, keep: np.ndarray) -> Table:
    return Table({name: values[keep] for name, values in table.columns.items()}, table.units)
