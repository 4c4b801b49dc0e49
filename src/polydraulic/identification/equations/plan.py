"""Which further sensor or motion would narrow which number most: the information that each would add to a log's, before it is recorded."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.arguments import table_of
from polydraulic.identification.equations.free_numbers import freedom
from polydraulic.identification.equations.numbers.estimates import KNOWN
from polydraulic.identification.equations.numbers.spreads import spreads_of
from polydraulic.identification.equations.shooting.information import (
    ChannelInformation,
    channel_information,
    information_of,
    left_unsure,
    state_spreads,
)
from polydraulic.identification.equations.shooting.runs import first_states, shoot, window_slopes
from polydraulic.identification.equations.shooting.windows import (
    LEAD,
    ComparedColumn,
    Windows,
    cut_windows,
    run_sensors,
    sensors_of,
)
from polydraulic.identification.equations.ways.by_runs import entries_left
from polydraulic.identification.equations.ways.so_far import SoFar
from polydraulic.pages.text import text_table
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.layout.adapt import full_stroke
from polydraulic.parameters.layout.schema import LayoutMachine, position_columns
from polydraulic.parameters.load import load_machine, machine_path
from polydraulic.parameters.scenario import Scenario, random_operator
from polydraulic.progress import Progress, quiet
from polydraulic.simulation.runs import simulate
from polydraulic.tables import Table

SECONDS, MOST_WINDOWS = 2.0, 24  # of windows, of the log and of each motion
# as `record --example` has it
NOISE = {
    "spool": 4e-5,
    "p_a": 1e5,
    "p_b": 1e5,
    "q_in": 8e-6,
    "q_out": 8e-6,
    "p_pump": 1e5,
}
_MOTION = LEAD + SECONDS * MOST_WINDOWS + 2.0  # s
_SEED = 1
_GAINS = 0.7  # a number counts as narrowed if less than this share of what was unsure is left

UNSURE_HEADS = ("number", "unsure now", "best further sensor", "then", "best further motion", "then")
CANDIDATE_HEADS = ("further", "determined", "narrows most")


class Candidate(NamedTuple):
    """What could be added to a log.

    Attributes
    ----------
    name : str
    is_motion : bool
    unsure : (n,) array
        What would be left, as shares of what was unsure before any log.
    """

    name: str
    is_motion: bool
    unsure: np.ndarray


class IdentificationPlan(NamedTuple):
    """What further sensors and motions promise; ``str()`` is two tables.

    Attributes
    ----------
    paths : tuple of str
        Numbers that are free.
    unsure : (n,) array
        What the log leaves unsure of each, as a share of what was unsure before.
    candidates : tuple of Candidate
    source : str
        What the log is called.
    """

    paths: tuple[str, ...]
    unsure: np.ndarray
    candidates: tuple[Candidate, ...]
    source: str

    def __str__(self) -> str:
        head = [
            f"what {self.source} leaves unsure of each number, as a share of how far it may be off, and what would be left with one thing more;",
            "linearised at the numbers of the machine file, for sensors with white noise alone and equations that are true: trust the order more than the sizes",
        ]
        return "\n".join(
            [
                *head,
                *text_table(UNSURE_HEADS, unsure_rows(self)),
                "",
                *text_table(CANDIDATE_HEADS, candidate_rows(self)),
            ]
        )


def unsure_rows(plan: IdentificationPlan) -> list[list[str]]:
    """Texts under `UNSURE_HEADS`: numbers that are least known first."""
    rows = []
    for k in np.argsort(-plan.unsure, kind="stable").tolist():
        row = [plan.paths[k], f"{plan.unsure[k]:.2g}"]
        for motions in (False, True):
            best = min(
                (c for c in plan.candidates if c.is_motion == motions), key=lambda c: float(c.unsure[k]), default=None
            )
            helps = best is not None and best.unsure[k] < _GAINS * plan.unsure[k]
            row += [best.name, f"{best.unsure[k]:.2g}"] if helps and best is not None else ["-", "-"]
        rows.append(row)
    return rows


def candidate_rows(plan: IdentificationPlan) -> list[list[str]]:
    """Texts under `CANDIDATE_HEADS`: those that determine most first."""

    def row(name: str, unsure: np.ndarray) -> list[str]:
        k = int(np.argmin(unsure / plan.unsure))
        narrows = (
            f"{plan.paths[k]}, {plan.unsure[k]:.2g} to {unsure[k]:.2g}" if unsure[k] < _GAINS * plan.unsure[k] else "-"
        )
        return [name, f"{np.count_nonzero(unsure < KNOWN)} of {len(unsure)}", narrows]

    def order(c: Candidate) -> tuple[int, float]:
        return -int(np.count_nonzero(c.unsure < KNOWN)), float(np.log(c.unsure).sum())

    return [row("nothing", plan.unsure), *(row(c.name, c.unsure) for c in sorted(plan.candidates, key=order))]


def plan_identification(
    log: Table | str | Path | Sequence[Table | str | Path],
    machine: LayoutMachine | str | Path,
    *,
    free: Sequence[str] = (),
    progress: Progress = quiet,
) -> IdentificationPlan:
    """Say which further sensor or motion would narrow which number most, by Fisher information at the machine's numbers.

    Windows of the log are simulated with their slopes over all free numbers. A further sensor adds its readings of the same windows; a further motion adds
    windows of a simulated operator, read by the sensors that the log has. States at the start of windows are unknown
    as they are in a fit, and numbers have their spreads as priors.

    Parameters
    ----------
    log : Table, str, Path or sequence of them
        With ``NAME.voltage`` and positions of all functions, in SI.
    machine : LayoutMachine, str or Path
        As given, or better as it was identified.
    free : sequence of str
        As for `identify`.
    progress : Progress, optional

    Returns
    -------
    IdentificationPlan

    Raises
    ------
    InputError
        Missing columns, no number that is free, runs that diverge at the machine's numbers.
    """
    own = machine if isinstance(machine, LayoutMachine) else load_machine(machine)
    data: dict[str, Any] = {} if isinstance(machine, LayoutMachine) else read_toml(machine_path(machine))
    so_far = SoFar(own, freedom(own, data, free), "")
    spreads = spreads_of(own, entries_left(so_far, ()))
    if not spreads:
        raise InputError("; ".join(["no number is free that runs could show", *so_far.kept]))
    table, source = table_of(log, ["time"], ["segment", *(f"{name}.voltage" for name in own.names), *run_sensors(own)])
    read = sensors_of(own, table)
    further = [name for name in run_sensors(own) if name not in read and name.rpartition(".")[2] in NOISE]
    motions = _motions(own)
    progress("what the log says", 0, 1 + len(motions))
    windows = cut_windows(own, table, read, seconds=SECONDS, most=MOST_WINDOWS)
    noise = {c.column: c.noise for c in windows.channels} | {name: NOISE[name.rpartition(".")[2]] for name in further}
    known = _information(own, windows, noise, spreads)
    spread = np.array(list(spreads.values()))
    here = list(range(len(read)))
    base = information_of(known, here)
    candidates = [
        Candidate(name, False, left_unsure(information_of(known, [*here, len(here) + k]), spread))
        for k, name in enumerate(further)
    ]
    candidates.append(Candidate("the same again", True, left_unsure(2.0 * base, spread)))
    for number, (name, scenario) in enumerate(motions.items()):
        progress(name, 1 + number, 1 + len(motions))
        driven = _driven_windows(own, scenario, windows, read)
        added = information_of(_information(own, driven, {c: noise[c] for c in read}, spreads), here)
        scale = len(windows.first) / max(len(driven.first), 1)
        candidates.append(Candidate(name, True, left_unsure(base + scale * added, spread)))
    progress("planned", 1 + len(motions), 1 + len(motions))
    return IdentificationPlan(tuple(spreads), left_unsure(base, spread), tuple(candidates), source)


def _motions(machine: LayoutMachine) -> dict[str, Scenario]:
    """Operators who could be asked to work; levers that one leaves alone are at rest, which locks no joint and leaves all sensors their readings."""
    limit, names = full_stroke(machine), machine.names
    whole = random_operator(_SEED, _MOTION, limit=limit, functions=names)
    alone = {
        f"{name} alone, full stroke": replace(
            random_operator(_SEED, _MOTION, links=[name], limit=limit, functions=names), locked=()
        )
        for name in names
    }
    return {"all functions, full stroke": whole, **(alone if len(names) > 1 else {})}


def _driven_windows(machine: LayoutMachine, scenario: Scenario, like: Windows, read: Sequence[str]) -> Windows:
    """Windows of a simulated operator, as sure of their starts as those of the log."""
    step, every = like.dt, like.every
    run = simulate(machine, "exact", scenario, dt=step, every=every)
    voltage = scenario.voltages(run["time"], machine.names)
    columns = {name: run[name] for name in ("time", *position_columns(machine), *read)}
    columns |= {f"{name}.voltage": voltage[:, k] for k, name in enumerate(machine.names)}
    found = cut_windows(machine, Table(columns, {}), read, seconds=SECONDS, most=MOST_WINDOWS)
    return found._replace(position_sd=like.position_sd, rate_sd=like.rate_sd)


def _information(
    machine: LayoutMachine, windows: Windows, noise: dict[str, float], spreads: dict[str, float]
) -> ChannelInformation:
    """Information of every channel in windows, those of sensors that are not there included."""
    wider = windows._replace(channels=tuple(ComparedColumn(name, value) for name, value in noise.items()))
    states = first_states(machine, windows)
    here = shoot(machine, wider, states)
    paths, spread = list(spreads), np.array(list(spreads.values()))
    slopes = None if here is None else window_slopes(machine, wider, states, here, paths, spread)
    if slopes is None:
        raise InputError("runs diverge at the numbers of the machine; bring them nearer to the log")
    return channel_information(slopes, np.array(list(noise.values())), state_spreads(windows))
