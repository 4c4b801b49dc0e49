"""How good the networks of a machine are: each judged by blocks of time that an earlier one has not seen; what a log must hold for that."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.arguments import parts_of
from polydraulic.identification.judging import HeldOut, OutputFit, judged
from polydraulic.identification.machine.machine_learning import CELL
from polydraulic.identification.machine.machine_log import Known, judging_rows, some_rows
from polydraulic.identification.plausible import check_pressures, contradictions
from polydraulic.networks.hold_out import BLOCKS, held_rows
from polydraulic.networks.model.model import Model
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table

_BLOCK = 30.0  # s, of a longer log: what a pump does comes and goes with the work, and few long blocks hold few kinds of work
_WORSE = 1.1  # times the error of the earlier network on rows that it has not seen, above which one that has seen them is not released
_LEARNT, _HELD = 200, 50  # rows with an open valve that it takes to learn a network, and to judge it
_BEYOND = 1.5  # times what a machine can do, above which a number has the wrong unit
# on rows held out, and rms as a share of the pump's flow: a network beyond them is weak
_LEAST_R2, _MOST_ERROR = 0.9, 0.05
_NO_PRESSURE = 1e4  # Pa; a machine whose pressures all stay below it does not work, or they are no Pa


def held_out(log: Table, min_blocks: int = BLOCKS) -> np.ndarray:
    """Every fifth block of time, (n_row,) array of bool: blocks of half a minute, or `min_blocks`; pauses of the log do not count."""
    n = len(log)
    seconds = n * float(np.median(np.diff(log["time"]))) if n > 1 else 0.0
    return held_rows(n, max(min_blocks, round(seconds / _BLOCK)), parts_of(log))


def judged_network(known: Known, log: Table, held: np.ndarray, model: Model, earlier: Model) -> OutputFit:
    """The network of all rows, with the errors of the earlier one on the rows held out; the earlier one where it is better there."""
    output = model.output.name
    function = output.split(".")[0]
    judging = judging_rows(output, log, known)
    rows = some_rows(log, held & judging)
    X, y = rows.matrix([variable.name for variable in model.inputs]), rows[output]
    # growth that ends badly must not be released with the errors of one that did not
    worse = _rms(model.predict(X) - y) > _WORSE * _rms(earlier.predict(X) - y)
    fit = judged(
        earlier if worse else model, HeldOut(X, y, earlier.predict(X), True), int(np.sum(~held)) if worse else len(log)
    )
    error = fit.held.predicted - y
    flow = error * rows[f"{function}.root_p_out"] if output.endswith("k_out") else error
    fit.model.training.update(
        learnt_from="rows not held out" if worse else "all rows",
        held_out_flow_rms=_rms(flow),
        held_out_flow_largest=float(np.abs(flow).max()),
        pump_flow=known.circuit(function).flow,
        log=known.to_data(),
    )
    return fit


def _rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(error * error)))


def one_sided(log: Table, known: Known) -> list[str]:
    """Sentences on spools that hardly open to one of their sides: the outlet there is not learnt."""
    found = []
    for function in known.functions:
        for sign, side in ((1.0, "positive"), (-1.0, "negative")):
            count = int(np.sum(sign * log[f"{function}.spool"] > known.deadband[function]))
            if count < CELL:
                found.append(
                    f"{function}.spool opens its valve to the {side} side in {count} of {len(log)} rows: nothing is known of it there"
                )
    return found


def contradicted(outputs: Sequence[OutputFit], known: Known) -> list[str]:
    """Sentences on valves whose sensors contradict each other, by the larger error of their networks."""
    left: dict[str, float] = {}
    for output in outputs:
        function = output.model.output.name.split(".")[0]
        rms: Any = output.model.training["held_out_flow_rms"]
        left[function] = max(left.get(function, 0.0), rms)
    return [text for name, flow in left.items() for text in contradictions(name, flow, known.circuit(name).flow)]


def weak(outputs: Sequence[OutputFit]) -> list[str]:
    """One sentence on the networks that say little of the rows held out, if there are any."""
    found = []
    for output in outputs:
        training: Any = output.model.training
        share = training["held_out_flow_rms"] / training["pump_flow"]
        if output.r2 < _LEAST_R2 or share > _MOST_ERROR:
            found.append(f"{output.model.output.name} (R2 {output.r2:.3f}, rms {share:.1%} of the pump's flow)")
    return [f"weak on the rows held out: {', '.join(found)}; a longer log, or full strokes, help"] if found else []


def check_numbers(machine: LayoutMachine, known: Known, log: Table) -> None:
    """Refuse a log whose numbers cannot be SI."""
    for function, circuit in ((name, c) for c in known.circuits.values() for name in c.functions):
        travel, relief = machine.function(function).valve.knots[-1], circuit.relief
        for name, most, unit in ((f"{function}.spool", travel, "m"), (f"{function}.q_in", circuit.flow, "m3/s")):
            # one row may be anything, a hundredth of them not
            reached = float(np.quantile(np.abs(log[name]), 0.99))
            if reached > _BEYOND * most:
                raise InputError(
                    f"{name} goes to {reached:.4g} {unit}; the machine's goes to {most:.4g} {unit}: "
                    "give the channel map the unit of the log, or the parameter set of this machine"
                )
        highest = max(float(np.quantile(log[f"{function}.{port}"], 0.99)) for port in ("p_a", "p_b"))
        if highest < _NO_PRESSURE or highest > 10.0 * relief:
            raise InputError(
                f"{function}.p_a and {function}.p_b go to {highest:.4g} Pa; the relief valve opens at {relief:.4g} Pa: "
                "give the channel map the unit of the log"
            )
    check_pressures(log, known.functions)


def check_rows(log: Table, held: np.ndarray, known: Known) -> None:
    """Refuse a log that says too little of one of the valves."""
    for function, opens in known.deadband.items():
        reached = float(log[f"{function}.travel"].max()) if len(log) else 0.0
        if reached <= opens:
            raise InputError(
                f"{function}.spool goes to {reached:.4g} m in {len(log)} rows and its valve opens at {opens:.4g} m: nothing "
                f"can be learnt of it; record a log in which the {function} moves"
            )
        for what in ("q_in", "k_out"):
            rows = judging_rows(f"{function}.{what}", log, known)
            learnt, left = int(np.sum(rows & ~held)), int(np.sum(rows & held))
            if learnt < _LEARNT or left < _HELD:
                raise InputError(
                    f"{function}.{what}: {learnt} rows are of use to it, and {left} in the blocks of time held out; it takes {_LEARNT} and "
                    f"{_HELD}: record longer, or move the {function} more often"
                )
