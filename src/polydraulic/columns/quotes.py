"""Cells that are quoted in other ways than a reader of CSV expects, as it expects them."""

import re
from collections.abc import Sequence

# what such a cell looks like, and what is left of it
_FORMS = (
    # blanks before the quote, or behind it
    (
        re.compile(rb'(?m)(^|[,;|\t])(?:[ ]+("(?:[^"\r\n]|"")*")[ ]*|("(?:[^"\r\n]|"")*")[ ]+)(?=[,;|\t\r\n]|$)'),
        rb"\1\2\3",
    ),
    (re.compile(rb'(?m)(^|[,;|\t])=(?=")'), rb"\1"),  # ="1.5", so that a spreadsheet keeps all digits
    (re.compile(rb"(?m)(^|[,;|\t])[ ]*'([^',;|\t\r\n]*)'(?=[ ]*(?:[,;|\t\r\n]|$))"), rb"\1\2"),  # single quotes
)
_MOST = 0.5  # of the lines

Quotes = tuple[re.Pattern[bytes], bytes] | None


def quotes_of(lines: Sequence[bytes]) -> Quotes:
    """How most lines quote their cells, where not as usual."""
    for form, left in _FORMS:
        if sum(form.search(line) is not None for line in lines) > _MOST * len(lines):
            return form, left
    return None


def as_usual(text: bytes, quotes: Quotes) -> bytes:
    """Lines with their cells quoted as usual, or not at all."""
    return text if quotes is None else quotes[0].sub(quotes[1], text)
