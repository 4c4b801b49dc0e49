"""The command of the thesis' report."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import MachineOption, app
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar


@app.command()
def report(
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("report"),
    chapter: Annotated[list[int] | None, typer.Option(help="Only this chapter; repeat for more.")] = None,
    figure: Annotated[str | None, typer.Option(help="Only this figure, as an SVG with its data.")] = None,
    machine: MachineOption = "cat215b",
) -> None:
    """Reproduce the thesis: every table, figure and printed number with the computed one, and what is possible today.

    Writes index.html and a page for each chapter (readable offline), figures, their data as CSV, and results.json. What has been
    computed stays in the folder's cache: a second run takes seconds, and one that was interrupted goes on.

    Example: `polydraulic report --chapter 4 --out report`

    - One figure alone: `polydraulic report --figure 5-19`

    What comes next: open index.html in a browser; `docs/figures.md` lists the figures. Chapters keep the units that the thesis
    prints.
    """
    from polydraulic.thesis.excavator import as_excavator
    from polydraulic.thesis.report.write import write_figure, write_report

    if chapter and figure:
        raise InputError("--chapter and --figure exclude each other: a figure belongs to one chapter")
    plant = as_excavator(machine)
    with progress_bar("report") as progress:
        if figure:
            path = write_figure(plant, out, figure, progress=progress)
        else:
            rows = write_report(plant, out, chapters=chapter, progress=progress)
            path = out / "index.html"
    print(path if figure else f"{path}: {sum(row['thesis'] is not None for row in rows)} printed numbers recomputed")
