"""Where the log of a machine has been, and what a model card says of the machine as a whole."""

from collections.abc import Sequence
from html import escape
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from polydraulic.display import DEFAULT
from polydraulic.flow.layout.slots import passed
from polydraulic.identification.arguments import models_of, table_of
from polydraulic.identification.log_replay import DRIFT_HEADS, drift_rows
from polydraulic.identification.machine.machine_fit import MachineFit, heads, kept, summary
from polydraulic.identification.machine.machine_log import Known, by_port, judging_rows
from polydraulic.machine.valve import spool_edges
from polydraulic.measure.checks.coverage import Coverage, coverage
from polydraulic.measure.log_units import conversion_shown
from polydraulic.measure.quality_plots import coverage_svg
from polydraulic.networks.model.model import Model
from polydraulic.pages.html import svg_image
from polydraulic.pages.html import table as html_table
from polydraulic.parameters.layout.parts import SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.tables import Table
from polydraulic.units import Conversion

_HOLES = 3  # of a map that are named


class Covered(NamedTuple):
    """How much of its operating box the log has shown a network: the rows that say something of it, and their coverage.

    Attributes
    ----------
    output : str
    rows : int
    found : Coverage
        In SI.
    read : dict from input to unit
        SI units of the inputs.
    """

    output: str
    rows: int
    found: Coverage
    read: dict[str, str]

    @property
    def share(self) -> float:
        """Of the cells of all maps of pairs that hold a row."""
        return sum(pair.share for pair in self.found.pairs) / len(self.found.pairs)

    def holes(self, units: str = DEFAULT) -> list[str]:
        """Where the log has not been, in words, the largest hole first."""
        return self.found.statements(self._conversions(units))

    def to_svg(self, units: str = DEFAULT) -> str:
        """Maps of all pairs of inputs, holes framed."""
        return coverage_svg(self.found, self._conversions(units))

    def _conversions(self, units: str) -> dict[str, Conversion]:
        return {name: conversion_shown(unit, units) for name, unit in self.read.items()}


def operating_box(machine: LayoutMachine, circuit: SupplyCircuit, function: str) -> dict[str, tuple[float, float]]:
    """Where a function's valve works: from where it opens to its end, up to the relief setting and all of the pump's flow, in SI."""
    valve, relief = machine.function(function).valve, circuit.pump.relief
    opens, end = spool_edges(valve)[0], valve.knots[-1]
    reaching = [passed(circuit, place).name for place in range(1, len(circuit.functions))]
    return {
        f"{function}.travel": (opens, end),
        f"{function}.spool": (-end, end),
        f"{function}.p_in": (0.0, relief),
        f"{function}.root_p_out": (0.0, relief**0.5),
    } | dict.fromkeys(reaching, (0.0, circuit.pump.flow))


def machine_coverage(
    table: Table | str | Path, models: Sequence[Model] | str | Path, machine: LayoutMachine | str | Path = "cat215b"
) -> list[Covered]:
    """Where a log has been, network by network, in the operating box of the machine.

    Parameters
    ----------
    table : Table, str or Path
        Or its file, an imported log, as for `fit_machine`.
    models : sequence of Model, str or Path
        Of `fit_machine`, or their file.
    machine : LayoutMachine, str or Path
        Or a parameter set by its name or file.
    """
    plant = as_machine(machine)
    given = models_of(models)
    learnt = {model.output.name.split(".")[0] for model in given}
    known = Known.of(plant, [c.name for c in plant.circuits if learnt.intersection(c.functions)])
    log, _ = table_of(table, known.measured())
    return _covered(plant, known, given, by_port(known, log))


def _covered(machine: LayoutMachine, known: Known, models: Sequence[Model], log: Table) -> list[Covered]:
    """The same of what circuits see."""
    found = []
    box: dict[str, tuple[float, float]] = {}
    for c in (machine.circuit(name) for name in known.circuits):
        for function in c.functions:
            box |= operating_box(machine, c, function)
    for model in models:
        output = model.output.name
        names = [variable.name for variable in model.inputs]
        if output.endswith("k_out"):  # the pressure behind it says how well a conductance was seen
            names.append(f"{output.split('.')[0]}.root_p_out")
        keep = judging_rows(output, log, known)
        rows = Table({name: log[name][keep] for name in names}, log.units)
        seen = coverage(rows, names, {name: box[name] for name in names})
        found.append(Covered(output, int(keep.sum()), seen, {name: log.unit(name) for name in names}))
    return found


def machine_facts(fit: MachineFit, units: str = DEFAULT) -> tuple[dict[str, Any], str]:
    """What a card says of a machine and its log as a whole: entries of the JSON, in SI but for texts, and HTML."""
    covered = _covered(fit.machine, fit.known, fit.models, fit.table)
    facts = {
        "coverage": [{"output": c.output, "rows": c.rows, "share": c.share, "holes": c.holes(units)} for c in covered],
        "windows": fit.windows,
        "drift": [
            # JSON knows no infinity: a run that diverged
            {name: None if value == inf else value for name, value in d._asdict().items()}
            for d in fit.drifts
        ],
    }
    maps = "\n".join(_map(c, units) for c in covered)
    page = f"""{html_table("Errors on the blocks of time held out, as flows", heads(units), summary(fit.outputs, units))}
<p>Rows with an open valve; of an outlet, k_out, the error as a flow at the measured pressure. At the relief setting an inlet's flow falls from
all of the pump's to nothing within what a pressure sensor can tell: these rows do not count. {escape(kept(fit.outputs)).capitalize()}</p>
<h3>The machine run against its log</h3>
<p>{escape(fit.windows).capitalize()}.</p>
{html_table("Largest distance in a window", DRIFT_HEADS, drift_rows(fit.drifts, units)) if fit.drifts else ""}
<h3>Where the log has been</h3>
<p>In the operating box: a spool from where its valve opens to its end, pressures up to the relief setting, all of the pump's flow. White is
where nothing was seen; the largest holes are framed.</p>
{maps}"""
    return facts, page


def _map(covered: Covered, units: str) -> str:
    holes = covered.holes(units)
    named = f": {escape('; '.join(holes[:_HOLES]))}" if holes else ""
    return f"""<p><b>{escape(covered.output)}</b>, {covered.rows} rows, {covered.share:.0%} of the cells{named}.</p>
{svg_image(covered.to_svg(units))}"""
