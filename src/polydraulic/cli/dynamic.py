"""Command of dynamic models: run."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import METRIC, UnitsOption, app
from polydraulic.terminal import progress_bar


@app.command()
def run(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit --dynamic.")],
    log: Annotated[
        list[str],
        typer.Argument(
            help="Table with the model's signals, at its raster, with a column time; several tables, or a pattern in quotes."
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(help="Table to write, .parquet or .csv: measured, free run, one step ahead.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture to write, .svg, .png or .pdf.")] = None,
    every: Annotated[
        float | None,
        typer.Option(help="Restart from measured outputs after so many seconds; never within a segment if not given."),
    ] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Run a dynamic model on a log: from measured inputs and its own predictions, next to what was measured.

    At the start of each segment it reads as many rows of the outputs as its longest lag; then it goes on by itself.

    Example: `polydraulic run pressure.json log.parquet --plot run.svg`

    - As a predictor one second ahead: `polydraulic run pressure.json log.parquet --every 1 --out second.parquet`

    What comes next: `polydraulic check pressure.json --data log.parquet` says whether the model still holds;
    `polydraulic export` writes it as C code or FMU.
    """
    from polydraulic.identification.run_plot import plot_runs
    from polydraulic.identification.runs import run_models
    from polydraulic.plotting.run_figure import picture_ending, save_figure
    from polydraulic.tables import table_ending, write_table

    if out is not None:
        table_ending(out)
    if plot is not None:
        picture_ending(plot)
    with progress_bar("run") as progress:
        progress("free runs, compiled once after an installation", 0, 2)
        found = run_models(model, log, every=every)
        progress("write", 1, 2)
        if out is not None:
            write_table(found.to_table(), out)
        if plot is not None:
            save_figure(plot_runs(found, units=units), plot)
    print(found.text(units))
