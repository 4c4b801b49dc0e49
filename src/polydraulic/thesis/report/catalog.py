"""What a report is made of: chapters with their figures, and results next to printed numbers."""

import ast
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
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


class Computed(NamedTuple):
    """The computed value of a printed number, and why it differs if it does."""

    value: Number
    note: str = ""


class Grid(NamedTuple):
    """A table of the report."""

    title: str
    header: list[str]
    rows: list[list[str]]


class Paragraph(NamedTuple):
    """A paragraph of plain text; `lead`, in bold, says what it is about."""

    text: str
    lead: str = ""


@dataclass(frozen=True)
class Content:
    """What a chapter says.

    Attributes
    ----------
    text : sequence of Paragraph
        What was done, and what came of it.
    computed : dict from id to Computed
        For every printed number of the chapter.
    extra : list of dict
        Numbers that the thesis does not have, in the form of a result.
    tables : list of Grid
    """

    text: Sequence[Paragraph]
    computed: dict[str, Computed] = field(default_factory=dict)
    extra: list[dict[str, Any]] = field(default_factory=list)
    tables: list[Grid] = field(default_factory=list)


class Chapter(NamedTuple):
    """A chapter of the report; nothing is computed before it is asked for.

    Attributes
    ----------
    number : int
    title : str
    about : str
        One sentence for the first page.
    content : function of Lab -> Content
    figures : mapping from number to function of Lab -> Figure
        Numbers are those of the thesis (``"4-11"``); figures that it does not have begin with the chapter and a letter (``"4-C1"``).
    """

    number: int
    title: str
    about: str
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


def printed_mm(identity: str) -> str:
    """A length that is printed in metres, in millimetres."""
    value = printed_numbers()[identity].value
    assert isinstance(value, float)
    return f"{1e3 * value:.0f}"


def result(identity: str, section: str, what: str, unit: str, value: Number, note: str = "") -> dict[str, Any]:
    """Return a computed number that the thesis does not have, as a row of ``results.json``."""
    return {
        "id": identity,
        "section": section,
        "quantity": what,
        "unit": unit,
        "thesis": None,
        "computed": value,
        "note": note,
        "source": sources()[identity],
    }


def results(content: Content) -> list[dict[str, Any]]:
    """Printed numbers with the computed ones, then those that the thesis does not have; the rows of ``results.json``."""
    printed = printed_numbers()
    rows = []
    for identity, found in content.computed.items():
        p = printed[identity]
        note = "; ".join(text for text in (found.note, p.quirk and f"thesis: {p.quirk}") if text)
        row = result(identity, p.section, p.what, p.unit, found.value, note)
        rows.append(row | {"thesis": p.value})
    return rows + content.extra


@cache
def sources() -> dict[str, str]:
    """File and line where each number is made, by id: the line of its key or of its call of `result`."""
    folder = files("polydraulic.thesis.report.chapters")
    found: dict[str, str] = {}
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.name.endswith(".py"):
            for identity, line in _identities(entry.read_text(encoding="utf-8")):
                found[identity] = f"polydraulic/thesis/report/chapters/{entry.name}:{line}"
    return found


def _identities(source: str) -> Iterator[tuple[str, int]]:
    """Ids of numbers in a chapter's source, with the lines that make them."""
    for node in ast.walk(ast.parse(source)):
        made: list[ast.expr | None] = []
        if isinstance(node, ast.Dict):
            made = [key for key, value in zip(node.keys, node.values, strict=True) if _called(value) == "Computed"]
        elif isinstance(node, ast.Call) and _called(node) == "result":
            made = [*node.args[:1]]
        for key in made:
            if isinstance(key, ast.Constant) and isinstance(key.value, str):
                yield key.value, key.lineno


def _called(node: ast.AST) -> str:
    return node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
