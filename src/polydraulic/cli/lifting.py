"""Commands about loads: what a machine can lift where."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import METRIC, MachineOption, UnitsOption, app, joined, values_by_name
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar

_SURE = 3.0  # standard errors


@app.command()
def loadchart(
    machine: MachineOption = "excavator_22t",
    out: Annotated[
        Path | None,
        typer.Option(help="Chart to write: .html, a picture (.svg, .png or .pdf), or a table (.csv or .parquet, SI)."),
    ] = None,
    step: Annotated[
        float | None, typer.Option(help="Between reaches and heights in m; about nine reaches if not given.")
    ] = None,
    move: Annotated[
        list[str] | None,
        typer.Option(
            help="Two functions that bring the tip to its places, boom,stick; the first two that can if not given."
        ),
    ] = None,
    lift: Annotated[
        str | None,
        typer.Option(
            help="The function that lifts at the pump's pressure while all others hold; the first that moves if not given."
        ),
    ] = None,
    hold: Annotated[
        list[str] | None,
        typer.Option(
            help="Where another function is held, bucket=-90 in deg or reach=500 in mm; repeat for more; initial positions if not given."
        ),
    ] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Say what a machine can lift over reach and height, over its front and its side: the lower of 75 % of tipping and 87 % of hydraulic capacity.

    The rule is that of ISO 10567. The load hangs at the tip; each number comes with what limits it, a direction of tipping or a function.
    The machine's file must say what it stands on, `[chassis]`.

    Example: `polydraulic loadchart --machine excavator_22t --out chart.html`

    - A finer table: `polydraulic loadchart --machine loader_crane --step 0.5 --out crane.csv`

    - With the bucket curled in: `polydraulic loadchart --machine excavator_22t --hold bucket=-110 --out chart.png`

    What comes next: `polydraulic simulate random:1:20 --machine excavator_22t --stability` says how close a run comes to tipping.
    """
    from polydraulic.display import shown_unit
    from polydraulic.files import write_text
    from polydraulic.machine.stability.load_chart import load_chart
    from polydraulic.parameters.load import load_machine
    from polydraulic.plotting.load_chart_figure import draw_load_chart, load_chart_page, load_chart_rows
    from polydraulic.plotting.run_figure import save_figure
    from polydraulic.tables import write_table

    kind = out.suffix.lower() if out is not None else ""
    if kind not in ("", ".html", ".svg", ".png", ".pdf", ".csv", ".parquet"):
        raise InputError(f"--out {out}: ends in .html, .svg, .png, .pdf, .csv or .parquet")
    plant = load_machine(machine)
    moved = _pair(joined(move)) if move else None
    held = {name: _held(name, value, plant) for name, value in values_by_name(hold or (), "--hold").items()}
    with progress_bar("loadchart") as progress:
        progress("poses and limits", 0, 2)
        chart = load_chart(plant, step=step, moved=moved, lifting=lift, held=held)
        progress(f"write {out}" if out is not None else "print", 1, 2)
        if out is None:
            pass
        elif kind == ".html":
            write_text(out, load_chart_page(plant, chart, held=held, units=units))
        elif kind in (".csv", ".parquet"):
            write_table(chart.table, out)
        else:
            save_figure(draw_load_chart(plant, chart, held=held, units=units), out)
        progress("done", 2, 2)
    print(f"{chart.title}: moved by {chart.moved[0]} and {chart.moved[1]}, {chart.lifting} lifts")
    for k, over in enumerate(chart.over):
        rows = load_chart_rows(chart, k, units)
        widths = [max(len(row[c]) for row in rows) for c in range(len(rows[0]))]
        print(
            f"over the {over}, capacity in {shown_unit('kg', units)} and what limits it, by height and reach of the tip:"
        )
        for row in rows:
            print("  " + "  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    if out is not None:
        print(out)


def _pair(text: str) -> tuple[str, str]:
    names = [name.strip() for name in text.split(",")]
    if len(names) != 2:
        raise InputError(f"--move {text!r}: must name two functions, for example boom,stick")
    return names[0], names[1]


def _held(name: str, value: str, machine: object) -> float:
    """Position in SI where `--hold` holds a function."""
    from polydraulic.parameters.layout.schema import LayoutMachine
    from polydraulic.units import read_unit

    assert isinstance(machine, LayoutMachine)
    if name not in machine.names:
        raise InputError(f"--hold {name}: {name!r} is not a function of the machine; there are {list(machine.names)}")
    slides = machine.link(machine.function(name).moves).joint == "prismatic"
    try:
        number = float(value)
    except ValueError:
        raise InputError(f"--hold {name}={value}: must be NAME=NUMBER, in {'mm' if slides else 'deg'}") from None
    return read_unit("mm" if slides else "deg").to_si(number)


@app.command()
def payload(
    log: Annotated[
        str,
        typer.Argument(
            help="Imported table in SI with NAME.angle (.position where it slides), .p_a, .p_b of all functions."
        ),
    ],
    machine: MachineOption = "excavator_22t",
    window: Annotated[float, typer.Option(help="For how many s the load is taken as constant.")] = 2.0,
    force: Annotated[
        bool, typer.Option("--force", help="Estimate the force at the tip instead, along x, y and z of the ground.")
    ] = False,
    known: Annotated[
        float, typer.Option(help="With --force: mass in kg that hangs at the tip, whose weight is not counted.")
    ] = 0.0,
    out: Annotated[Path | None, typer.Option(help="Table of the windows to write, .csv or .parquet (SI).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of the payload to write, .svg, .png or .pdf.")] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Say what hangs at the tip of a machine, from pressures and positions of a log: window by window, with standard errors.

    The machine's masses and friction must be known; `polydraulic identify` finds them from a log without a payload. At rest friction may hold
    as much as its static value, and the error says so: lift and lower the load to know it better.

    Example: `polydraulic payload day.parquet --machine excavator_22t --plot payload.svg`

    - The force at the tip while digging: `polydraulic payload day.parquet --force --out force.csv`

    What comes next: `polydraulic loadchart --machine excavator_22t` says whether that much may be lifted there.
    """
    from polydraulic.display import amount
    from polydraulic.files import check_apart
    from polydraulic.identification.loads.payload_figure import plot_payload
    from polydraulic.identification.loads.tip_loads import estimate_payload, estimate_tip_force, load_table
    from polydraulic.parameters.load import load_machine
    from polydraulic.plotting.run_figure import picture_ending, save_figure
    from polydraulic.tables import read_table, table_ending, write_table

    if out is not None:
        table_ending(out)
        check_apart(out, [log])
    if plot is not None:
        picture_ending(plot)
        if force:
            raise InputError("--plot draws the payload; with --force write a table, --out force.csv")
    if known and not force:
        raise InputError("--known is what hangs there while a force is estimated: give --force, too, or leave it out")
    plant, table = load_machine(machine), read_table(log, partial=True)
    with progress_bar("payload") as progress:
        progress("least squares, compiled once after an installation", 0, 2)
        found = (
            estimate_tip_force(plant, table, payload=known, window=window)
            if force
            else estimate_payload(plant, table, window=window)
        )
        progress("write", 1, 2)
        if out is not None:
            write_table(load_table(found), out)
        if plot is not None and not force:
            save_figure(plot_payload(found, units=units), plot)  # type: ignore[arg-type]
        progress("done", 2, 2)
    windows = load_table(found)
    unit = "N" if force else "kg"
    for k, time in enumerate(windows["time"]):
        values = [(name, windows[name][k], windows[f"{name}_error"][k]) for name in windows.names[1::2]]
        print(
            f"{time:8.2f} s  "
            + ", ".join(f"{name} {amount(v, unit, units)} +- {amount(e, unit, units)}" for name, v, e in values)
        )
    if not force:
        print(f"payload {amount(found.mean, 'kg', units)}, standard error {amount(found.mean_error, 'kg', units)}")  # type: ignore[union-attr]
        if found.mean < -_SURE * found.mean_error:  # type: ignore[union-attr]
            print(
                "warning: less than nothing hangs there: masses or friction of the machine file are wrong, or sensors are off; polydraulic identify finds "
                "masses from a log without a payload"
            )
    for path in (out, plot):
        if path is not None:
            print(path)
