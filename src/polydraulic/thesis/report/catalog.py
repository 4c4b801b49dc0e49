"""What a report is made of: chapters with their figures, and results next to printed numbers."""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple

from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab

if TYPE_CHECKING:
    import matplotlib.figure

Number = float | list[float] | list[list[float]]


class Figure(NamedTuple):
    """A figure of the report.

    Attributes
    ----------
    title, see : str
        What it is, and in one line what to see in it.
    data : dict from panel name to Table
        Everything that is drawn; written as CSV beside the report.
    draw : function () -> matplotlib Figure
    """

    title: str
    see: str
    data: dict[str, Table]
    draw: "Callable[[], matplotlib.figure.Figure]"


class Printed(NamedTuple):
    """A number printed in the thesis."""

    value: Number
    unit: str
    section: str
    what: str
    quirk: str


class Ours(NamedTuple):
    """Our value of a printed number, and why it differs if it does."""

    value: Number
    note: str = ""


class Grid(NamedTuple):
    """A table of the report."""

    title: str
    header: list[str]
    rows: list[list[str]]


@dataclass(frozen=True)
class Content:
    """What a chapter says.

    Attributes
    ----------
    text : str
        HTML: a few paragraphs that say what was done.
    ours : dict from id to Ours
        For every printed number of the chapter.
    extra : list of dict
        Numbers of our own, in the form of a result.
    tables : list of Grid
    """

    text: str
    ours: dict[str, Ours] = field(default_factory=dict)
    extra: list[dict[str, Any]] = field(default_factory=list)
    tables: list[Grid] = field(default_factory=list)


class Chapter(NamedTuple):
    """A chapter of the report; nothing is computed before it is asked for.

    Attributes
    ----------
    number : int
    title : str
    content : function of Lab -> Content
    figures : mapping from number to function of Lab -> Figure
        Numbers are those of the thesis (``"4-11"``); figures of our own begin with the chapter and a letter (``"4-C1"``).
    """

    number: int
    title: str
    content: Callable[[Lab], Content]
    figures: Mapping[str, Callable[[Lab], Figure]]


@cache
def printed_numbers() -> dict[str, Printed]:
    """Every number printed in the thesis, by id."""
    text = (files("polydraulic.thesis.report") / "thesis.toml").read_text(encoding="utf-8")
    found: dict[str, Printed] = {}

    def walk(tree: dict[str, Any], where: str) -> None:
        for key, item in tree.items():
            if "value" in item:
                found[where + key] = Printed(
                    item["value"], item["unit"], item["section"], item["what"], item.get("quirk", "")
                )
            else:
                walk(item, f"{where}{key}.")

    walk(tomllib.loads(text), "")
    return found


def result(identity: str, section: str, what: str, unit: str, ours: Number, note: str = "") -> dict[str, Any]:
    """Return a number of our own that the thesis does not have."""
    return {
        "id": identity,
        "section": section,
        "quantity": what,
        "unit": unit,
        "thesis": None,
        "ours": ours,
        "note": note,
        "source": source_of(identity),
    }


def results(content: Content) -> list[dict[str, Any]]:
    """Printed numbers next to ours, then our own; the rows of ``results.json``."""
    printed = printed_numbers()
    rows = []
    for identity, ours in content.ours.items():
        p = printed[identity]
        note = "; ".join(text for text in (ours.note, p.quirk and f"thesis: {p.quirk}") if text)
        row = result(identity, p.section, p.what, p.unit, ours.value, note)
        rows.append(row | {"thesis": p.value})
    return rows + content.extra


def source_of(identity: str) -> str:
    """File and line, from the package's folder on, where a number's id stands: there it is made."""
    for name, lines in _chapter_sources():
        for number, line in enumerate(lines, start=1):
            if f'"{identity}"' in line:
                return f"thesis/report/chapters/{name}:{number}"
    return ""


@cache
def _chapter_sources() -> list[tuple[str, list[str]]]:
    folder = files("polydraulic.thesis.report.chapters")
    chapters = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".py"))
    return [(name, (folder / name).read_text(encoding="utf-8").splitlines()) for name in chapters]
