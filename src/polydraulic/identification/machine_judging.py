"""How good the networks of a machine are: each judged by blocks of time that an earlier one has not seen; what a log must hold for that."""

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.arguments import parts_of
from polydraulic.identification.judging import HeldOut, OutputFit, judged
from polydraulic.identification.machine_learning import CELL
from polydraulic.identification.machine_log import Known, judging_rows, some_rows
from polydraulic.networks.hold_out import BLOCKS, held_rows
from polydraulic.networks.model.model import Model
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.tables import Table

_BLOCK = 30.0  # s, of a longer log: what a pump does comes and goes with the work, and few long blocks hold few kinds of work
_WORSE = 1.1  # times the error of the earlier network on rows that it has not seen, above which one that has seen them is not released
_LEARNT, _HELD = 200, 50  # rows with an open valve that it takes to learn a network, and to judge it
_BEYOND = 1.5  # times what a machine can do, above which a number has the wrong unit
_NO_PRESSURE = 1e4  # Pa; a machine whose pressures all stay below it does not work, or they are no Pa


def held_out(log: Table, min_blocks: int = BLOCKS) -> np.ndarray:
    """Every fifth block of time, (n_row,) array of bool: blocks of half a minute, or `min_blocks`; pauses of the log do not count."""
    n = len(log)
    seconds = n * float(np.median(np.diff(log["time"]))) if n > 1 else 0.0
    return held_rows(n, max(min_blocks, round(seconds / _BLOCK)), parts_of(log))


def judged_network(machine: Machine, log: Table, held: np.ndarray, model: Model, earlier: Model) -> OutputFit:
    """The network of all rows, with the errors of the earlier one on the rows held out; the earlier one where it is better there."""
    known, output = Known.of(machine), model.output.name
    link = output.split(".")[0]
    judging = judging_rows(output, log, known)
    rows = some_rows(log, held & judging)
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


def check_numbers(machine: Machine, log: Table) -> None:
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


def check_rows(log: Table, held: np.ndarray, known: Known) -> None:
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
                    f"{link}.{what}: {learnt} rows are of use to it, and {left} in the blocks of time held out; it takes {_LEARNT} and "
                    f"{_HELD}: record longer, or move the {link} more often"
                )
