"""Pages, tables and lists as HTML, in one style: report, model cards, quality pages, documentation inside FMUs.

All text that is passed in is escaped, except for the body of a page, which is made of what these functions return.
"""

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from typing import NamedTuple

_MANY, _LONG = 5, 40  # columns, and characters in a cell, from which a row does not fit on a narrow screen


class Cell(NamedTuple):
    """A cell of a table that looks unlike plain text.

    Attributes
    ----------
    text : str
    look : str
        Class in ``page.css``: ``"number"``, ``"small"``, ``"error"``, ``"warning"`` or ``"good"``.
    """

    text: str
    look: str = ""


def document(title: str, body: str, *, top: str = "") -> str:
    """Return a page that needs nothing but what `body` links to.

    Parameters
    ----------
    title : str
        Plain text, of the window and the first heading.
    body, top : str
        HTML below and above the first heading.
    """
    style = (files("polydraulic.pages") / "page.css").read_text(encoding="utf-8")
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{style}</style></head><body>
{top}<h1>{escape(title)}</h1>
{body}
</body></html>
"""


def table(title: str, header: Sequence[str], rows: Sequence[Sequence[str | Cell]]) -> str:
    """Return a table; a caption if there is a title. On narrow screens a row that does not fit becomes a list of its cells."""
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "\n".join("<tr>" + "".join(map(_cell, header, row)) + "</tr>" for row in rows)
    long = any(len(cell.text if isinstance(cell, Cell) else cell) > _LONG for row in rows for cell in row)
    look = ' class="wide"' if len(header) >= _MANY or (len(header) > 2 and long) else ""
    return f"<table{look}>{caption}<thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"


def svg_image(svg: str | bytes, alt: str = "") -> str:
    """Return a drawing, as its text in SVG, as an image inside the page, and what it says to who does not see it."""
    data = svg.encode() if isinstance(svg, str) else svg
    return f'<figure><img src="data:image/svg+xml;base64,{b64encode(data).decode()}" alt="{escape(alt)}"></figure>'


def bullets(items: Iterable[str]) -> str:
    """Return a list of plain texts; nothing if there are none."""
    listed = "".join(f"<li>{escape(item)}</li>" for item in items)
    return f"<ul>{listed}</ul>" if listed else ""


def _cell(name: str, cell: str | Cell) -> str:
    text, look = cell if isinstance(cell, Cell) else (cell, "")
    kind = f' class="{escape(look)}"' if look else ""
    return f'<td{kind} data-name="{escape(name)}">{escape(text)}</td>'
