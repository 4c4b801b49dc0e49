"""Fit a whole machine: pump and valves from a log of its work, judged by blocks of time held out and by running the machine on them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT, as_shown, readable, shown_unit, with_unit
from polydraulic.errors import InputError
from polydraulic.flow.dispatch import build_flow
from polydraulic.identification.arguments import table_of, unused_in_words
from polydraulic.identification.doubts.channels import channel_doubts
from polydraulic.identification.judging import OutputFit
from polydraulic.identification.log_replay import DRIFT_HEADS, Drift, against_log, drift_rows, driven
from polydraulic.identification.machine.machine_judging import (
    check_numbers,
    check_rows,
    contradicted,
    held_out,
    judged_network,
    one_sided,
    weak,
)
from polydraulic.identification.machine.machine_learning import REGIONS, ROWS, learn, tasks_of
from polydraulic.identification.machine.machine_log import Known, by_port, some_rows
from polydraulic.identification.plausible import check_plausible
from polydraulic.networks.hold_out import BLOCKS
from polydraulic.networks.model.model import Model
from polydraulic.pages.text import text_table
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table


@dataclass(frozen=True, eq=False)
class MachineFit:
    """A machine learnt from a log; ``str()`` says how good it is.

    Attributes
    ----------
    outputs : list of OutputFit
        Of all networks; their models are learnt from all rows and state in `training` how those `without` did on the rows
        held out. A model that errs more there, on rows it has seen, gives way to the one without: ``learnt_from`` says so. Besides
        what `fit_table` writes, `training` holds ``held_out_flow_rms`` and ``held_out_flow_largest`` in m3/s, the errors as flows
        (of an outlet: conductance times the root of the measured pressure drop), ``pump_flow`` in m3/s, and ``log``, by which
        `check_models` reads another log.
    without : list of Model
        Learnt without the rows held out.
    held : (n_row,) array of bool
        Rows held out.
    windows : str
        What the machine was run over, in words, or why it was not run against the log.
    drifts : list of Drift
        How far joints and tip drift there; empty if it was not run.
    warnings : list of str
        What the log does not show, and which networks are weak.
    machine : LayoutMachine
    known : Known
        What was known of its circuits that were learnt.
    table : Table
        What circuits see, by rows of the log.
    source : str
        Where the log came from.
    """

    outputs: list[OutputFit]
    without: list[Model] = field(repr=False)
    held: np.ndarray = field(repr=False)
    windows: str
    drifts: list[Drift]
    warnings: list[str]
    machine: LayoutMachine = field(repr=False)
    known: Known = field(repr=False)
    table: Table = field(repr=False)
    source: str

    @property
    def models(self) -> list[Model]:
        """The networks to be used."""
        return [found.model for found in self.outputs]

    def text(self, units: str = DEFAULT) -> str:
        """How good it is, in tables."""
        remark = kept(self.outputs)
        return "\n".join(
            [
                f"{self.held.sum()} of {len(self.table)} rows held out, every fifth block of time; "
                "errors as flows, where a valve is open:",
                *text_table(heads(units), summary(self.outputs, units)),
                *([remark] if remark else []),
                self.windows + (":" if self.drifts else ""),
                *(text_table(DRIFT_HEADS, drift_rows(self.drifts, units)) if self.drifts else []),
                *(f"warning: {warning}" for warning in self.warnings),
            ]
        )

    def __str__(self) -> str:
        return self.text()


def fit_machine(
    table: Table | str | Path | Sequence[Table | str | Path],
    machine: LayoutMachine | str | Path = "cat215b",
    *,
    circuits: Sequence[str] | None = None,
    max_regions: int = REGIONS,
    max_rows: int = ROWS,
    min_blocks: int = BLOCKS,
    progress: Progress = quiet,
) -> MachineFit:
    """Learn the pump and valves of a whole machine from a log of its work; orifice areas are not needed.

    Every fifth block of time is held out to state the errors: blocks of half a minute, or `min_blocks` of a short log. The networks are
    then learnt from all rows, in the regions that the others gave. With the columns ``NAME.voltage`` and ``NAME.angle`` the machine is also run against the blocks held
    out, on networks learnt without them.

    Parameters
    ----------
    table : Table, str, Path or sequence of them
        Or its file (several, or a pattern such as ``day*.parquet``, are learnt from together), an imported log: ``time`` and ``NAME.spool``, ``NAME.p_a``, ``NAME.p_b``, ``NAME.q_in``, ``NAME.q_out`` of all
        functions, in SI.
    machine : LayoutMachine, str or Path
        Or a parameter set by its name or file, whose circuits are 1 to 6 valves in series. Of it pump flows, relief settings, return pressure and the
        borders of spool travel are used; to run the machine, all of it.
    circuits : sequence of str, optional
        Which of its circuits; all if not given. Of others the log needs no sensors, and functions that they feed get no flow.
    max_regions : int
        That the network of an inlet may find.
    max_rows : int
        That a network learns from.
    min_blocks : int
        Of time, of which every fifth is held out.
    progress : Progress, optional
        Called as each network and the run against the log begin.

    Returns
    -------
    MachineFit

    Raises
    ------
    InputError
        A circuit of another kind, a column that is missing or in another unit, numbers that cannot be SI, a valve that never opens, too few rows with an open
        valve in the blocks held out or in the others.
    """
    plant = as_machine(machine)
    known = _known(plant, circuits)
    read, source = table_of(table, ["time", *known.measured()], ["segment", *driven(plant)])
    log = by_port(known, read)
    check_numbers(plant, known, log)
    check_plausible(plant, read)
    held = held_out(log, min_blocks)
    check_rows(log, held, known)
    total = len(known.functions) * 2 + 1
    tasks = list(
        zip(
            *(
                tasks_of(plant, known, rows, max_regions=max_regions, max_rows=max_rows)
                for rows in (some_rows(log, ~held), log)
            ),
            strict=True,
        )
    )

    def tell(done: int) -> None:
        if done < len(tasks):
            progress(tasks[done][0].output.name, done, total)

    learnt = learn(tasks, tell)
    without = [earlier for earlier, _ in learnt]
    outputs = [judged_network(known, log, held, model, earlier) for earlier, model in learnt]
    progress("run against the log", len(tasks), total)
    if idle := [name for name in plant.names if name not in known.functions]:
        windows, drifts = f"not run against the log: nothing is learnt of {', '.join(idle)}", list[Drift]()
    else:
        windows, drifts = against_log(plant, build_flow("polynomial", plant, models=without), read, held)
    unused = unused_in_words(read)
    doubts = [*([unused] if unused else []), *(doubt.text for doubt in channel_doubts(plant, read))]
    warnings = doubts + one_sided(log, known) + contradicted(outputs, known) + weak(outputs)
    return MachineFit(outputs, without, held, windows, drifts, warnings, plant, known, log, source)


def _known(machine: LayoutMachine, circuits: Sequence[str] | None) -> Known:
    try:
        return Known.of(machine, circuits)
    except InputError as error:
        raise InputError(
            f"{error}; flow 'exact' runs circuits of any kind, and `polydraulic fit-joints` learns how joints move"
        ) from error


def heads(units: str = DEFAULT) -> tuple[str, ...]:
    """Heads of the columns of `summary`."""
    rms, largest = (with_unit(name, shown_unit("m3/s", units)) for name in ("rms", "largest"))
    return ("network", "regions", rms, "of the pump", largest, "R2", "in 90% intervals")


def summary(outputs: Sequence[OutputFit], units: str = DEFAULT) -> list[list[str]]:
    """Texts under `heads`: errors of all networks on the blocks held out, as flows; of an outlet at the measured pressure."""
    rows = []
    for found in outputs:
        training: Any = found.model.training
        rms, largest = (as_shown(training[f"held_out_flow_{what}"], "m3/s", units) for what in ("rms", "largest"))
        share = training["held_out_flow_rms"] / training["pump_flow"]
        texts = [readable(rms, 3), f"{share:.2%}", readable(largest, 3), f"{found.r2:.4f}", f"{found.covered:.0%}"]
        rows.append([found.model.output.name, str(len(found.model.networks)), *texts])
    return rows


def kept(outputs: Sequence[OutputFit]) -> str:
    """Sentence on networks that are those learnt without the rows held out; empty if there are none."""
    names = [found.model.output.name for found in outputs if found.model.training["learnt_from"] != "all rows"]
    return (
        f"learnt without the rows held out, since learning from all rows gave a worse result: {', '.join(names)}"
        if names
        else ""
    )
