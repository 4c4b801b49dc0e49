"""What a report is made of: figures, results next to printed numbers, and the chapters that hold them."""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple

from polydraulic.tables import Table

if TYPE_CHECKING:
    import matplotlib.figure

Number = float | list[float] | list[list[float]]


class Figure(NamedTuple):
    """A figure of the report.

    Attributes
    ----------
    number : str
        As in the thesis (``"4-11"``); figures of our own begin with the chapter and a letter (``"4-C1"``).
    title, see : str
        What it is, and in one line what to see in it.
    data : dict from panel name to Table
        Everything that is drawn; written as CSV beside the report.
    draw : function () -> matplotlib Figure
    """

    number: str
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


@dataclass(frozen=True)
class Chapter:
    """A finished chapter of the report.

    Attributes
    ----------
    number : int
    title, text : str
        `text` is HTML: a few paragraphs that say what was done.
    figures : list of Figure
    ours : dict from id to Ours
        For every printed number of the chapter.
    extra : list of dict
        Numbers of our own, in the form of a result.
    tables : list of (title, header, rows)
    """

    number: int
    title: str
    text: str
    figures: list[Figure]
    ours: dict[str, Ours]
    extra: list[dict[str, Any]] = field(default_factory=list)
    tables: list[tuple[str, list[str], list[list[str]]]] = field(default_factory=list)


def printed_numbers() -> dict[str, Printed]:
    """Every number printed in the chapters that the report covers, by id."""
    text = (files("polydraulic.studies") / "thesis.toml").read_text(encoding="utf-8")
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
    }


def results(chapter: Chapter) -> list[dict[str, Any]]:
    """Printed numbers next to ours, then our own; the rows of ``results.json``."""
    printed = printed_numbers()
    rows = []
    for identity, ours in chapter.ours.items():
        p = printed[identity]
        note = "; ".join(text for text in (ours.note, p.quirk and f"thesis: {p.quirk}") if text)
        rows.append(
            {
                "id": identity,
                "section": p.section,
                "quantity": p.what,
                "unit": p.unit,
                "thesis": p.value,
                "ours": ours.value,
                "note": note,
            }
        )
    return rows + chapter.extra
