"""Write a report: pages, figures with their data, and ``results.json``."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.files import replacing, write_text
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import write_table
from polydraulic.thesis.cache import Lab, open_lab
from polydraulic.thesis.report.catalog import Chapter, Computed, Content, Figure, Grid, Paragraph, results
from polydraulic.thesis.report.chapters import (
    chapter_3,
    chapter_4,
    chapter_5,
    chapter_6,
    chapter_7,
    chapter_8,
    chapter_9,
)
from polydraulic.thesis.report.front import front_page
from polydraulic.thesis.report.page import Shown, chapter_page, data_name

CHAPTERS: dict[int, Chapter] = {
    module.CHAPTER.number: module.CHAPTER
    for module in (chapter_3, chapter_4, chapter_5, chapter_6, chapter_7, chapter_8, chapter_9)
}


def write_report(
    machine: LayoutMachine,
    folder: Path,
    *,
    chapters: Sequence[int] | None = None,
    progress: Progress = quiet,
) -> list[dict[str, Any]]:
    """Write ``index.html``, a page for each chapter, ``figures``, ``data`` and ``results.json``.

    What was computed before, by the same code from the same parameters, is taken from ``cache``; a run that was killed
    goes on where it was.

    Parameters
    ----------
    machine : LayoutMachine
    folder : Path
    chapters : sequence of int, optional
        All if not given.
    progress : Progress, optional
        Called as each chapter and figure begins.

    Returns
    -------
    list of dict
        The rows of ``results.json``.

    Raises
    ------
    InputError
        Unknown chapter, or a folder that cannot be written; the latter before anything is computed.
    """
    numbers = sorted(set(CHAPTERS if chapters is None else chapters))
    unknown = [number for number in numbers if number not in CHAPTERS]
    if unknown:
        raise InputError(f"no chapter {unknown[0]} in the report; choose from {sorted(CHAPTERS)}")
    chosen = [CHAPTERS[number] for number in numbers]
    write_text(folder / "data" / "README.txt", "Data of the figures; units in the headers.\n")
    total = sum(1 + len(chapter.figures) for chapter in chosen)
    done, step = 0, ""

    def begin(what: str) -> None:
        nonlocal done, step
        step = what
        progress(step, done, total)
        done += 1

    lab = open_lab(machine, folder / "cache", lambda what: progress(f"{step}: {what}", done - 1, total))
    rows: list[dict[str, Any]] = []
    front: dict[str, Shown] = {}
    for chapter in chosen:
        begin(f"chapter {chapter.number}")
        content = chapter_content(lab, chapter)
        rows += results(content)
        shown = {}
        for number, make in chapter.figures.items():
            begin(f"figure {number}")
            shown[number] = show_figure(lab, number, make, folder)
        front |= shown
        write_text(folder / f"chapter_{chapter.number}.html", chapter_page(chapter, chosen, content, shown))
    write_text(folder / "results.json", json.dumps(rows, indent=1, allow_nan=False) + "\n")
    write_text(folder / "index.html", front_page(chosen, front, rows))
    progress("report", total, total)
    return rows


def write_figure(machine: LayoutMachine, folder: Path, number: str, *, progress: Progress = quiet) -> Path:
    """Make one figure alone, computing no more than it shows; return the path of its picture.

    Parameters
    ----------
    machine : LayoutMachine
    folder : Path
    number : str
        As in `CHAPTERS`, such as ``"5-19"``.
    progress : Progress, optional

    Raises
    ------
    InputError
        If there is no such figure.
    """
    every = {name: make for chapter in CHAPTERS.values() for name, make in chapter.figures.items()}
    if number not in every:
        raise InputError(f"no figure {number!r} in the report; there are {', '.join(every)}")
    lab = open_lab(machine, folder / "cache", lambda what: progress(what, 0, 1))
    show_figure(lab, number, every[number], folder)
    return picture(folder, number)


def picture(folder: Path, number: str) -> Path:
    """Where a figure's picture lies."""
    return folder / "figures" / f"{number}.svg"


def chapter_content(lab: Lab, chapter: Chapter) -> Content:
    """What a chapter says, from the cache if it was made before."""

    def made() -> dict[str, Any]:
        content = chapter.content(lab)
        return {
            "text": [list(paragraph) for paragraph in content.text],
            "computed": {identity: list(found) for identity, found in content.computed.items()},
            "extra": content.extra,
            "tables": [list(table) for table in content.tables],
        }

    kept = lab.shown.data(f"chapter {chapter.number}", made)
    return Content(
        [Paragraph(*paragraph) for paragraph in kept["text"]],
        {identity: Computed(*found) for identity, found in kept["computed"].items()},
        kept["extra"],
        [Grid(*table) for table in kept["tables"]],
    )


def show_figure(lab: Lab, number: str, make: Callable[[Lab], Figure], folder: Path) -> Shown:
    """Draw a figure and write its data, unless both are there from the same code and parameters."""

    def draw() -> dict[str, Any]:
        figure = make(lab)
        for panel, table in figure.data.items():
            write_table(table, folder / "data" / data_name(number, panel))
        width = _save(figure, number, picture(folder, number))
        return {"title": figure.title, "see": figure.see, "panels": list(figure.data), "width": width}

    found = Shown(**lab.shown.data(f"figure {number}", draw))
    files = [picture(folder, number), *(folder / "data" / data_name(number, panel) for panel in found.panels)]
    if not all(path.is_file() for path in files):
        draw()
    return found


def _save(figure: Figure, number: str, path: Path) -> float:
    """Draw a figure; return its width in inches."""
    import matplotlib

    settings = {"svg.hashsalt": number, "font.size": 9}
    with replacing(path) as temporary, matplotlib.rc_context(settings):
        drawn = figure.draw()
        drawn.savefig(temporary, format="svg", metadata={"Date": None}, dpi=150)
    return float(drawn.get_figwidth())
