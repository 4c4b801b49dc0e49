"""Commands of dynamic models: fit-joints, run."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import METRIC, UnitsOption, app, check_endings, keep_fit, say_written
from polydraulic.terminal import progress_bar


@app.command()
def fit_joints(
    table: Annotated[
        list[str],
        typer.Argument(help="Imported log with columns time and segment; several tables, or a pattern in quotes."),
    ],
    commands: Annotated[
        list[str],
        typer.Option(
            help="Columns of the commands (levers, valve currents), separated by commas, in the order of --joints."
        ),
    ],
    joints: Annotated[
        list[str],
        typer.Option(help="Columns of angles or strokes, separated by commas; the first command moves the first one."),
    ],
    out: Annotated[Path, typer.Option(help="Model file to write, .json.")],
    more_inputs: Annotated[
        list[str] | None,
        typer.Option(help="What else speeds may depend on, such as engine speed, separated by commas."),
    ] = None,
    continuous: Annotated[
        list[str] | None,
        typer.Option(
            help="Those of --joints that turn without end, such as a swing, separated by commas: no stops, and nothing depends on the angle, "
            "which must go on past a full turn and not jump back."
        ),
    ] = None,
    longest: Annotated[
        float | None,
        typer.Option(
            help="Time in s after which the response of a speed to its command is over, at most 120 rows; 0.8 if not given, or 120 rows where "
            "these are shorter."
        ),
    ] = None,
    horizon: Annotated[
        float, typer.Option(help="Length in s of the free runs by which is chosen what rates depend on.")
    ] = 10.0,
    card: Annotated[
        Path | None, typer.Option(help="Model card to write, .html: errors of free runs, intervals, proofs, equations.")
    ] = None,
    boxes: Annotated[int, typer.Option(help="With --card: sub-boxes per joint that its proofs may take.", min=1)] = 200,
    units: UnitsOption = METRIC,
) -> None:
    """Learn how the joints of a machine follow its commands, from angles or strokes alone; nothing need be known of its hydraulics.

    Finds dead time, lag and dead zone of each command, then the speed of each joint as the fewest terms that run well by themselves; joints
    may see each other (shared pump, gravity). A joint stands still within its dead zone, and stops where the log shows a stop. One that turns
    without end (--continuous, and each angle that went through more than a full turn) has no stops, and nothing depends on its angle.

    Bring the log onto a raster of 20 to 50 ms first (`polydraulic import`). Every fifth block of time is held out to state the errors.

    Example: `polydraulic fit-joints log.parquet --commands boom.lever,stick.lever --joints boom.angle,stick.angle --out joints.json --card joints.html`

    What comes next: `polydraulic run joints.json later.parquet --every 10 --plot run.svg` shows it running, `polydraulic check joints.json
    --data later.parquet` whether it holds, `polydraulic export joints.json --to fmi3 --out joints.fmu` takes it elsewhere.
    """
    from polydraulic.cli.networks import names_in
    from polydraulic.identification.joint_fit import fit_joints as fit

    check_endings(out, card)
    read, moved = names_in(commands, "--commands"), names_in(joints, "--joints")
    more = names_in(more_inputs, "--more-inputs") if more_inputs else []
    endless = names_in(continuous, "--continuous") if continuous else []
    with progress_bar("fit-joints") as progress:
        found = fit(
            table,
            read,
            moved,
            more_inputs=more,
            continuous=endless,
            longest=longest,
            horizon=horizon,
            progress=progress,
        )
        keep_fit(found, out, card, boxes=boxes, units=units, progress=progress)
    print(found.text(units))
    say_written(out, card)


@app.command()
def run(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit --dynamic or fit-joints.")],
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

    At the start of each segment it reads as many rows of the outputs as its longest lag; then it goes on by itself. With --every, joints
    of fit-joints are as strong as the rows before a restart show them to be; without it, as strong as in the mean.

    Example: `polydraulic run pressure.json log.parquet --plot run.svg`

    - As a predictor one second ahead: `polydraulic run pressure.json log.parquet --every 1 --out second.parquet`

    What comes next: `polydraulic check pressure.json --data log.parquet` says whether the model still holds;
    `polydraulic export` writes it as C code or FMU.
    """
    from polydraulic.files import check_apart
    from polydraulic.identification.run_plot import plot_runs
    from polydraulic.identification.runs import run_models
    from polydraulic.measure.formats.campaign import expand
    from polydraulic.plotting.run_figure import picture_ending, save_figure
    from polydraulic.tables import table_ending, write_table

    if out is not None:
        table_ending(out)
        check_apart(out, expand(log))
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
