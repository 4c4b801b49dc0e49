"""What a machine learnt from a log is worth: a table in the field's units, where the log has been, and the model card of it all."""

import base64
from collections.abc import Sequence
from html import escape
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from polydraulic import units
from polydraulic.identification.log_replay import Drift
from polydraulic.identification.machine_fit import Known
from polydraulic.identification.machine_judging import LearntMachine, judging_rows
from polydraulic.identification.model_card import write_card
from polydraulic.identification.table_fit import TableFit
from polydraulic.measure.checks.coverage import Coverage, coverage
from polydraulic.measure.checks.quality_plots import coverage_svg
from polydraulic.networks.model.model import Model
from polydraulic.pages.html import table as html_table
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.tables import Table
from polydraulic.units import Conversion

HEADS = (
    "network",
    "regions",
    "rms [l/min]",
    "of the pump",
    "largest [l/min]",
    "R2",
    "in 90% intervals",
)
DRIFT_HEADS = ("joint", "median", "largest", "moved")
_FIELD = {"m": "mm", "Pa": "bar", "Pa^0.5": "bar^0.5", "m3/s": "l/min"}  # of maps: what logs are written in
_HOLES = 3  # of a map that are named


class Covered(NamedTuple):
    """How much of its operating box the log has shown a network: the rows that say something of it, and their coverage."""

    output: str
    rows: int
    found: Coverage

    @property
    def share(self) -> float:
        """Of the cells of all maps of pairs that hold a row."""
        return sum(pair.share for pair in self.found.pairs) / len(self.found.pairs)


def summary(fits: Sequence[TableFit]) -> list[list[str]]:
    """Texts under `HEADS`: errors of all networks on the blocks held out, as flows in l/min; of an outlet at the measured pressure."""
    rows = []
    for fit in fits:
        training: Any = fit.model.training
        rms, largest = (units.from_si(training[f"held_out_flow_{what}"], "l/min") for what in ("rms", "largest"))
        share = training["held_out_flow_rms"] / training["pump_flow"]
        texts = [f"{rms:.2f}", f"{share:.2%}", f"{largest:.1f}", f"{fit.r2:.4f}", f"{fit.covered:.0%}"]
        rows.append([fit.model.output.name, str(len(fit.model.networks)), *texts])
    return rows


def kept(fits: Sequence[TableFit]) -> str:
    """Sentence on networks that are those learnt without the rows held out; empty if there are none."""
    names = [fit.model.output.name for fit in fits if fit.model.training["learnt_from"] != "all rows"]
    return (
        f"learnt without the rows held out, since learning from all rows ended worse: {', '.join(names)}"
        if names
        else ""
    )


def drift_rows(found: Sequence[Drift]) -> list[list[str]]:
    """Texts under `DRIFT_HEADS`."""
    digits = {"deg": 2, "mm": 0}
    return [
        [d.name, *(f"{value:.{digits[d.unit]}f} {d.unit}" for value in (d.median, d.largest, d.moved))] for d in found
    ]


def operating_box(machine: Machine, link: str) -> dict[str, tuple[float, float]]:
    """Where a link's valve works: from where it opens to its end, up to the relief setting and all of the pump's flow, in SI."""
    opens, end, relief = machine.spool.deadband, machine.spool.knots[-1], machine.pumps.relief
    return {
        f"{link}.travel": (opens, end),
        f"{link}.spool": (-end, end),
        f"{link}.p_in": (0.0, relief),
        f"{link}.root_p_out": (0.0, relief**0.5),
        "series.q_passed": (0.0, machine.pumps.series_flow),
    }


def machine_coverage(machine: Machine, models: Sequence[Model], log: Table) -> list[Covered]:
    """Where a log has been, network by network, in the operating box of the machine.

    Parameters
    ----------
    machine : Machine
    models : sequence of Model
        From `learn_and_judge`.
    log : Table
        From `by_port`.
    """
    known, found = Known.of(machine), []
    box: dict[str, tuple[float, float]] = {}
    for link in LINKS:
        box |= operating_box(machine, link)
    for model in models:
        output = model.output.name
        names = [variable.name for variable in model.inputs]
        if output.endswith("k_out"):  # the pressure behind it says how well a conductance was seen
            names.append(f"{output.split('.')[0]}.root_p_out")
        keep = judging_rows(output, log, known)
        rows = Table({name: log[name][keep] for name in names}, log.units)
        found.append(Covered(output, int(keep.sum()), coverage(rows, names, {name: box[name] for name in names})))
    return found


def write_machine_card(
    machine: Machine,
    learnt: LearntMachine,
    log: Table,
    source: str,
    path: str | Path,
    drift: Sequence[Drift],
    windows: str,
) -> dict[str, Any]:
    """Write the model card of all six networks; see `write_card`.

    Parameters
    ----------
    machine : Machine
    learnt : LearntMachine
        From `learn_and_judge`.
    log : Table
        From `by_port`, what they were learnt from.
    source : str
        Where the log came from.
    path : str or Path
        ``.html``.
    drift : sequence of Drift
        Of the machine run against its log; may be empty.
    windows : str
        In words what it was run over, or why it was not.
    """
    covered = machine_coverage(machine, learnt.models, log)
    facts = {
        "coverage": [
            {"output": c.output, "rows": c.rows, "share": c.share, "holes": c.found.statements(_conversions(log))}
            for c in covered
        ],
        "windows": windows,
        "drift": [
            # JSON knows no infinity: a run that left all reason
            {name: None if value == inf else value for name, value in d._asdict().items()}
            for d in drift
        ],
    }
    maps = "\n".join(_map(c, _conversions(log)) for c in covered)
    page = f"""{html_table("Errors on the blocks of time held out, as flows", HEADS, summary(learnt.fits))}
<p>Rows with an open valve; of an outlet, k_out, the error as a flow at the measured pressure. At the relief setting an inlet's flow falls from
all of the pump's to nothing within what a pressure sensor can tell: these rows do not count. The models themselves are in SI. {escape(kept(learnt.fits)).capitalize()}</p>
<h3>The machine run against its log</h3>
<p>{escape(windows).capitalize()}.</p>
{html_table("Largest distance in a window", DRIFT_HEADS, drift_rows(drift)) if drift else ""}
<h3>Where the log has been</h3>
<p>In the operating box: a spool from where its valve opens to its end, pressures up to the relief setting, all of the pump's flow. White is
where nothing was seen; the largest holes are framed.</p>
{maps}"""
    return write_card(learnt.fits, log, source, path, (facts, page))


def coverage_picture(covered: Covered, log: Table) -> str:
    """Maps of one network's inputs as SVG, in mm, bar and l/min."""
    return coverage_svg(covered.found, _conversions(log))


def _map(covered: Covered, conversions: dict[str, Conversion]) -> str:
    holes = covered.found.statements(conversions)
    named = f": {escape('; '.join(holes[:_HOLES]))}" if holes else ""
    picture = base64.b64encode(coverage_svg(covered.found, conversions).encode()).decode()
    return f"""<p><b>{escape(covered.output)}</b>, {covered.rows} rows, {covered.share:.0%} of the cells{named}.</p>
<figure><img src="data:image/svg+xml;base64,{picture}" alt=""></figure>"""


def _conversions(log: Table) -> dict[str, Conversion]:
    found = {}
    for name in log.names:
        if log.unit(name) in _FIELD:
            field = _FIELD[log.unit(name)]
            found[name] = Conversion(units.to_si(1.0, field), 0.0, log.unit(name), field)
    return found
