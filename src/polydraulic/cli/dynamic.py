"""Dynamic models on the command line: run one on a log; what fit, check and export say of them."""

from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from polydraulic.cli.app import METRIC, UnitsOption, app
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar

if TYPE_CHECKING:
    from polydraulic.networks.model.model import Model


@app.command()
def run(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit --dynamic.")],
    log: Annotated[Path, typer.Argument(help="Table with the model's signals, at its raster, with a column time.")],
    out: Annotated[
        Path | None, typer.Option(help="Table to write, .parquet or .csv: measured, free run, one step ahead.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture to write, .svg, .png or .pdf.")] = None,
    every: Annotated[
        float | None,
        typer.Option(
            help="Begin anew from measured outputs after so many seconds; never within a segment if not given."
        ),
    ] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Run a dynamic model on a log: from measured inputs and its own answers, next to what was measured.

    Of the outputs it reads as many rows as its longest lag at the start of each segment; then it goes on by itself.

    Example: `polydraulic run pressure.json log.parquet --plot run.svg`

    - As a predictor of the next second: `polydraulic run pressure.json log.parquet --every 1 --out second.parquet`

    What comes next: `polydraulic check pressure.json --data log.parquet` says whether the model still holds;
    `polydraulic export` writes it as C code or FMU.
    """
    import numpy as np

    from polydraulic.display import amount, began
    from polydraulic.identification.log_rows import rows_for
    from polydraulic.identification.run_plot import plot_runs
    from polydraulic.identification.runs import run_on, run_table
    from polydraulic.identification.table_fit import errors_of
    from polydraulic.networks.dynamic.spans import spans_of
    from polydraulic.networks.model.model_file import load_models
    from polydraulic.plotting.run_figure import picture_ending, save_figure
    from polydraulic.tables import read_table, table_ending, write_table

    if out is not None:
        table_ending(out)
    if plot is not None:
        picture_ending(plot)
    with progress_bar("run") as progress:
        progress(f"read {log}", 0, 3)
        models, table = load_models(model), read_table(log)
        rows = rows_for(models, table)
        horizon = None if every is None else _rows(every, rows.raster)
        progress("free runs, compiled once after an installation", 1, 3)
        runs = run_on(models, table, spans_of(rows.segments, np.ones(len(table), dtype=bool)), horizon)
        progress("write", 2, 3)
        if out is not None:
            write_table(run_table(models, runs, table), out)
        if plot is not None:
            save_figure(plot_runs(models, runs, units=units, began=began(table)), plot)
    print(
        f"{runs[0].n_run} free run(s) of up to {runs[0].longest} rows, {len(runs[0].row)} of {len(table)} rows answered"
    )
    for found, answered in zip(models, runs, strict=True):
        for name, values in (("free run", answered.free), ("one step", answered.one_step)):
            r2, rms, largest = errors_of(answered.measured, values)
            unit = found.output.unit
            print(
                f"{found.output.name}, {name}: R2 {r2:.4f}, rms {amount(rms, unit, units)}, "
                f"largest {amount(largest, unit, units)}"
            )


def _rows(seconds: float, raster: float | None) -> int:
    """Rows in a time."""
    if raster is None:
        raise InputError("--every is a time; neither model nor log say how far apart rows are")
    if not raster <= seconds < inf:
        raise InputError(f"--every {seconds:g}: must be a time in s, no less than the raster of {raster:g} s")
    return round(seconds / raster)


def say_how_dynamic(models: "Sequence[Model]") -> None:
    """Say of dynamic models what an export, or a proof, is about."""
    from polydraulic.identification.runs import lags_in_words

    steps: dict[str, list[str]] = {}
    for model in models:
        if model.dynamics is None:
            continue
        low, high = model.dynamics.step
        raster = "" if model.dynamics.raster is None else f", rows {model.dynamics.raster:g} s apart"
        change = f"{model.output.name} by {low:.6g} to {high:.6g}"
        steps.setdefault(lags_in_words(model) + raster, []).append(change)
    for lags, changes in steps.items():
        print(
            f"note: dynamic, a function of lagged values: {lags}. Whoever calls it shifts them from row to row, and lets "
            f"the output change from the last one {', '.join(changes)} at most"
        )
