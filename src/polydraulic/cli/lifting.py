"""Commands about loads: what a machine can lift where."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import METRIC, MachineOption, UnitsOption, app
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar


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
        str | None,
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
    moved = _pair(move) if move is not None else None
    held = dict(_held(text, plant) for text in hold or ())
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
        print(f"over the {over}, capacity and what limits it:")
        for row in rows:
            print("  " + "  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    if out is not None:
        print(out)


def _pair(text: str) -> tuple[str, str]:
    names = [name.strip() for name in text.split(",")]
    if len(names) != 2:
        raise InputError(f"--move {text!r}: must name two functions, for example boom,stick")
    return names[0], names[1]


def _held(text: str, machine: object) -> tuple[str, float]:
    """Name and position in SI of what `--hold` says."""
    from polydraulic.parameters.layout.schema import LayoutMachine
    from polydraulic.units import read_unit

    assert isinstance(machine, LayoutMachine)
    name, _, value = (part.strip() for part in text.partition("="))
    if name not in machine.names:
        raise InputError(f"--hold {text!r}: {name!r} is not a function of the machine; there are {list(machine.names)}")
    slides = machine.link(machine.function(name).moves).joint == "prismatic"
    try:
        number = float(value)
    except ValueError:
        raise InputError(f"--hold {text!r}: must be NAME=NUMBER, in {'mm' if slides else 'deg'}") from None
    return name, read_unit("mm" if slides else "deg").to_si(number)
