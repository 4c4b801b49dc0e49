"""What a machine learnt from a log is worth: a table of errors, where the log has been, and the model card of it all."""

import base64
from collections.abc import Sequence
from html import escape
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from polydraulic.display import DEFAULT, number, shown, shown_unit, with_unit
from polydraulic.identification.log_replay import Drift
from polydraulic.identification.machine_fit import Known
from polydraulic.identification.machine_judging import LearntMachine, judging_rows
from polydraulic.identification.model_card import write_card
from polydraulic.identification.table_fit import TableFit
from polydraulic.measure.checks.coverage import Coverage, coverage
from polydraulic.measure.checks.quality_plots import coverage_svg
from polydraulic.measure.log_units import Conversion
from polydraulic.networks.model.model import Model
from polydraulic.pages.html import table as html_table
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.tables import Table

DRIFT_HEADS = ("joint", "median", "largest", "moved")
_DECIMALS = {"deg": 2, "rad": 4, "mm": 0, "in": 1, "m": 3}
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


def heads(units: str = DEFAULT) -> tuple[str, ...]:
    """Heads of the columns of `summary`."""
    rms, largest = (with_unit(name, shown_unit("m3/s", units)) for name in ("rms", "largest"))
    return ("network", "regions", rms, "of the pump", largest, "R2", "in 90% intervals")


def summary(fits: Sequence[TableFit], units: str = DEFAULT) -> list[list[str]]:
    """Texts under `heads`: errors of all networks on the blocks held out, as flows; of an outlet at the measured pressure."""
    rows = []
    for fit in fits:
        training: Any = fit.model.training
        rms, largest = (shown(training[f"held_out_flow_{what}"], "m3/s", units) for what in ("rms", "largest"))
        share = training["held_out_flow_rms"] / training["pump_flow"]
        texts = [number(rms, 3), f"{share:.2%}", number(largest, 3), f"{fit.r2:.4f}", f"{fit.covered:.0%}"]
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


def drift_rows(found: Sequence[Drift], units: str = DEFAULT) -> list[list[str]]:
    """Texts under `DRIFT_HEADS`."""
    rows = []
    for drift in found:
        unit = shown_unit(drift.unit, units)
        values = (shown(value, drift.unit, units) for value in (drift.median, drift.largest, drift.moved))
        rows.append([drift.name, *("diverged" if v == inf else f"{v:.{_DECIMALS[unit]}f} {unit}" for v in values)])
    return rows


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
    *,
    units: str = DEFAULT,
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
    units : str
        Of the page: ``"metric"``, ``"field"`` or ``"si"``.
    """
    covered = machine_coverage(machine, learnt.models, log)
    facts = {
        "coverage": [
            {
                "output": c.output,
                "rows": c.rows,
                "share": c.share,
                "holes": c.found.statements(_conversions(log, units)),
            }
            for c in covered
        ],
        "windows": windows,
        "drift": [
            # JSON knows no infinity: a run that diverged
            {name: None if value == inf else value for name, value in d._asdict().items()}
            for d in drift
        ],
    }
    maps = "\n".join(_map(c, _conversions(log, units)) for c in covered)
    page = f"""{html_table("Errors on the blocks of time held out, as flows", heads(units), summary(learnt.fits, units))}
<p>Rows with an open valve; of an outlet, k_out, the error as a flow at the measured pressure. At the relief setting an inlet's flow falls from
all of the pump's to nothing within what a pressure sensor can tell: these rows do not count. {escape(kept(learnt.fits)).capitalize()}</p>
<h3>The machine run against its log</h3>
<p>{escape(windows).capitalize()}.</p>
{html_table("Largest distance in a window", DRIFT_HEADS, drift_rows(drift, units)) if drift else ""}
<h3>Where the log has been</h3>
<p>In the operating box: a spool from where its valve opens to its end, pressures up to the relief setting, all of the pump's flow. White is
where nothing was seen; the largest holes are framed.</p>
{maps}"""
    return write_card(learnt.fits, log, source, path, (facts, page), units=units)


def coverage_picture(covered: Covered, log: Table, units: str = DEFAULT) -> str:
    """Maps of one network's inputs as SVG."""
    return coverage_svg(covered.found, _conversions(log, units))


def _map(covered: Covered, conversions: dict[str, Conversion]) -> str:
    holes = covered.found.statements(conversions)
    named = f": {escape('; '.join(holes[:_HOLES]))}" if holes else ""
    picture = base64.b64encode(coverage_svg(covered.found, conversions).encode()).decode()
    return f"""<p><b>{escape(covered.output)}</b>, {covered.rows} rows, {covered.share:.0%} of the cells{named}.</p>
<figure><img src="data:image/svg+xml;base64,{picture}" alt=""></figure>"""


def _conversions(log: Table, units: str) -> dict[str, Conversion]:
    found = {}
    for name in log.names:
        own, read = log.unit(name), shown_unit(log.unit(name), units)
        if own != "":
            found[name] = Conversion(1.0 / shown(1.0, own, units), 0.0, own, read)
    return found
