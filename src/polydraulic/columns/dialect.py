"""What a text file is: its delimiter, where its rows begin, names and units of its columns; from its first lines."""

import csv
import re
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from polydraulic.columns.cells import MISSING
from polydraulic.columns.header import is_unit, names_and_units, says_time, type_line, unit_line
from polydraulic.columns.quotes import Quotes, as_usual, quotes_of
from polydraulic.columns.source import Scan
from polydraulic.columns.timestamps import time_kind
from polydraulic.errors import InputError

BLANKS = "blanks"  # as a delimiter: any run of blanks or tabs
_LINES = 200  # that are looked at
_USUAL = 0.05  # share of the rows that may be shorter than the header and are no damage
_LONGEST_CELL = 5  # lines that a name and its unit may take
_OPEN = re.compile(rb'(^|[,;\t|])\s*"')  # where a cell in quotes begins
_WRAPPED = re.compile(r"\s*[\r\n]\s*")
_WORDS = re.compile(r'"[^"]*"|[^ \t]+')  # between blanks
_RULE = re.compile(r"^(?=.*[-=_]{2})[-=_|+,;:\s]+$")  # below a header, as databases draw it
_NUMBER = re.compile(
    r"^\s*[-+\u2212\u2013]?(\d+([.,]\d+)*[.,]?|[.,]\d+|\d{1,3}([ '’\u00a0\u2009\u202f]\d{3})+([.,]\d*)?)([eEdD][+-]?\d+)?\s*$"
)
_COMMENT = ("#", "//", "%")
_MISSING = ("", "nan", "na", "n/a", "null", "-", "inf", "-inf", "+inf")


class Dialect(NamedTuple):
    """How a text file is written.

    Attributes
    ----------
    delimiter : str
        One character, or `BLANKS`.
    names, units : list of str
        Of the columns.
    n_column : int
        Columns there are; rows that end in a delimiter have a field more.
    begin : int
        Bytes (of the file as UTF-8) before the first row.
    width : int
        Fields of a row.
    short : frozenset of int
        Numbers of fields, fewer than `width`, that rows may have.
    above : list of str
        Lines above the header: comments, metadata.
    unnamed : str
        What was done where rows have more fields than the header names; empty where they do not.
    quotes : Quotes
        How cells are quoted, where not as usual.
    sample : list of list of str
        The cells of the first rows.
    """

    delimiter: str
    names: list[str]
    units: list[str]
    n_column: int
    begin: int
    width: int
    short: frozenset[int]
    above: list[str]
    sample: list[list[str]]
    unnamed: str = ""
    quotes: Quotes = None


def find_dialect(path: Path, found: Scan) -> Dialect:
    """Find out how a text file is written.

    Raises
    ------
    InputError
        A file that is empty or has no rows.
    """
    head = found.head
    lines = head.splitlines(keepends=True)
    lines = lines[:-1] if found.cut and len(lines) > 1 else lines  # the last may be cut
    lines = _logical(lines[:_LINES])
    quotes = quotes_of(lines)
    texts = [as_usual(line, quotes).decode("utf-8", "replace").lstrip("\ufeff").rstrip("\r\n") for line in lines]
    if not any(text.strip() for text in texts):
        raise InputError(f"{path}: the file is empty")
    said = next((n for n, text in enumerate(texts) if re.match(r"^\s*sep=.\s*$", text)), None)
    told = texts[said].strip()[4:] if said is not None else ("\t" if re.match(r"^\s*sep=\t", texts[0]) else None)
    plain = [n for n, text in enumerate(texts) if text.strip() and n != said and not text.lstrip().startswith(_COMMENT)]
    plain = [n for n in plain if not _RULE.match(texts[n])] or plain
    delimiter = told or (_delimiter([texts[n] for n in plain]) if plain else ",")
    if delimiter != ";":
        plain = [n for n in plain if not texts[n].startswith(";")]
    if not plain:
        raise InputError(f"{path}: the log has no rows")
    cells = {n: fields(texts[n], delimiter) for n in plain}
    first = _first_row(plain, cells)
    if first is None:
        if len(plain) < 2 and found.cut:
            raise InputError(
                f"{path}: the names of the columns and a first row must stand in the first {len(head)} bytes; leave columns out, or write Parquet"
            )
        if len(plain) < 2:
            raise InputError(f"{path}: the log has no rows")
        first = plain[1]  # words in all columns: the first line is the header
    body = [cells[n] for n in plain if n >= first]
    above = [n for n in plain if n < first]
    units: list[str] | None = None
    header: list[str] | None = None
    kept = above
    if above:
        wide = [n for n in above if len(_trimmed(cells[n])) > 1 or len(_trimmed(body[0])) == 1 or _one_unit(n, cells)]
        kinds = [n for n in wide if type_line(cells[n]) and (n != wide[0] or _repeats(cells[n]))]
        wide = [n for n in wide if n not in kinds] or wide
        last = wide[-1] if wide else above[-1]
        header, kept = cells[last], [n for n in above if n < last]
        # two lines directly above the rows: names, and units below them
        beside = len(wide) > 1 and all(n in kinds for n in range(wide[-2] + 1, last))
        if beside and unit_line(cells[last], cells[wide[-2]]):
            header, units, kept = cells[wide[-2]], cells[last], [n for n in kept if n < wide[-2]]
        elif beside and all(is_unit(cell) for cell in cells[wide[-2]]):
            units, kept = cells[wide[-2]], [n for n in kept if n < wide[-2]]  # above the names
        over = kept[-1] if kept else last
        if over != last and over in wide and _described(header, cells[over]):
            header, kept = cells[over], [n for n in kept if n < over]  # with what each name means below it
        if kept:
            header = _in_groups(header, cells[kept[-1]])
    elif (named := _commented_header(texts, first, delimiter, body[0])) is not None:
        header = named
    width, short = _widths(body, header)
    short = short if delimiter != BLANKS else frozenset()  # of runs of blanks nobody knows which field is missing
    if delimiter == "," and header is not None and _torn(body, width, len(_trimmed(header))):
        raise InputError(
            f"{path}: {width} fields in a row and {len(_trimmed(header))} names: commas part the columns and are decimal marks, too, and cannot be "
            "told apart; write the log with another delimiter, or with decimal points"
        )
    unnamed = ""
    if header is not None and (count := len(_trimmed(header))) < width and _filled(body, width):
        unnamed = f"{count} names, {width} fields in a row: the last ones are called by their numbers"
        if count == width - 1 and _counted(body, _trimmed(header)):
            header, units = ["", *_trimmed(header)], None if units is None else ["", *units]
            unnamed = f"{count} names, {width} fields in a row, of which the first counts the rows: the names are those of the others"
    n_named = width if header is None else len(_trimmed(header))
    filled = {place for row in body for place, cell in enumerate(row) if cell}
    n_column = max([n_named, *(place + 1 for place in filled)])
    if header is None:
        header = [f"column {n}" for n in range(1, width + 1)]
        names, of_names = header, [""] * width
    else:
        names, of_names = names_and_units(header, width)
    if units is not None:
        below = [cell.strip("[]() ") for cell in units] + [""] * width
        of_names = [given or cell for given, cell in zip(of_names, below[:width], strict=True)]
    begin = sum(len(line) for line in lines[:first])
    return Dialect(
        delimiter, names, of_names, min(n_column, width), begin, width, short, [texts[n] for n in kept], body, unnamed, quotes,
    )  # fmt: skip


def end_of_cell(lines: Sequence[bytes], place: int) -> int | None:
    """The line behind one, or behind the last of those that a cell in quotes goes over; None where no quote closes it."""
    odd = 0
    for end in range(place, min(place + _LONGEST_CELL, len(lines))):
        odd ^= lines[end].count(b'"') % 2
        if not odd:
            return end + 1
    return None


def _logical(lines: Sequence[bytes]) -> list[bytes]:
    """Lines, of which those that a cell in quotes goes over are one: names with their units below them."""
    found: list[bytes] = []
    place = 0
    while place < len(lines):
        end = (end_of_cell(lines, place) if _OPEN.search(lines[place]) else None) or place + 1
        found.append(b"".join(lines[place:end]))
        place = end
    return found


def fields(line: str, delimiter: str) -> list[str]:
    """Cells of a line, without the blanks around them."""
    if delimiter == BLANKS:
        return [word.strip('"') for word in _WORDS.findall(line)]
    return [
        _WRAPPED.sub(" ", cell.strip())
        for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    ]


@lru_cache(1 << 14)  # each cell is looked at several times
def looks_numeric(cell: str) -> bool:
    """Whether a cell is a number, with a point or a comma."""
    return bool(_NUMBER.match(cell)) or cell.strip().lower() in ("nan", "inf", "-inf")


def _delimiter(lines: Sequence[str]) -> str:
    """The delimiter that makes most numbers and times of the lower half of the lines, in rows of one length."""
    body = list(lines[len(lines) // 2 :]) or list(lines)
    best, most = ",", 0.0
    for candidate in ("\t", ";", "|", ",", BLANKS):
        try:
            rows = [fields(line, candidate) for line in body]
        except csv.Error:
            continue
        lengths = Counter(len(row) for row in rows)
        usual, count = lengths.most_common(1)[0]
        if usual < 2:
            continue
        cells = [cell for row in rows for cell in row]
        good = sum(_clean(cell, candidate) for cell in cells)
        score = good / len(cells) + 0.5 * count / len(rows)
        if score > most + 1e-9:
            best, most = candidate, score
    return best


def _clean(cell: str, delimiter: str) -> float:
    """1 for a number or a time, less for words, nothing for what holds another delimiter."""
    if any(mark in cell for mark in ";\t|" if mark != delimiter):
        return 0.0
    if looks_numeric(cell):
        return 1.0
    if cell.lower() in _MISSING:
        return 0.7
    if time_kind([cell]):
        return 1.1 if delimiter != BLANKS else 0.9
    return 0.5 if "," not in cell else 0.2


def _first_row(plain: Sequence[int], cells: dict[int, list[str]]) -> int | None:
    """The first line of the rows: it has a number or a time, and as many fields as most of the lines below it."""
    body = plain[len(plain) // 2 :]
    usual = {len(cells[n]) for n in body} | {len(_trimmed(cells[n])) for n in body}
    frequent = Counter(len(_trimmed(cells[n])) for n in body).most_common(1)[0][0]
    where = {place for n in body for place, cell in enumerate(cells[n]) if _value(cell)}
    found = None
    for n in reversed(plain):
        row = cells[n]
        if n == plain[0] and found is not None and _names_first(row, [cells[k] for k in plain if k >= found]):
            break
        values = [place for place, cell in enumerate(row) if _value(cell)]
        fits = len(row) in usual or len(_trimmed(row)) in usual
        if fits and (len(_trimmed(row)) > 1 or frequent == 1) and where.intersection(values):
            words = sum(bool(cell) and not _value(cell) for cell in row)
            if found is None or words <= max(len(values), _words(cells[found])):
                found = n
                continue
        if found is not None and _heads(row) and not _amid(plain.index(n), plain, cells, cells[found]):
            break
    return found


def _names_first(row: Sequence[str], below: Sequence[Sequence[str]]) -> bool:
    """Whether a line names its first column, in which all rows have a value: the others may be called by numbers."""
    said = bool(row) and row[0] not in MISSING and row[0].strip("-#. ") != ""
    return said and not _value(row[0]) and all(cells and _value(cells[0]) for cells in below)


def _words(row: Sequence[str]) -> int:
    return sum(bool(cell) and not _value(cell) for cell in row)


def _heads(row: Sequence[str]) -> bool:
    """Whether a line can stand above rows: all words."""
    return any(row) and not any(_value(cell) for cell in row)


def _amid(place: int, plain: Sequence[int], cells: dict[int, list[str]], row: Sequence[str]) -> bool:
    """Whether a line of words stands between rows: a header or its units that come again, the rest of a cell of two lines."""
    line, before = cells[plain[place]], [cells[n] for n in plain[:place]]
    return line in before or (len(before) >= 3 and all(_alike(cells, row) for cells in before[-3:]))


def _alike(cells: Sequence[str], row: Sequence[str]) -> bool:
    """Whether a line is a row as another is: both begin with a value, or neither, and so it is at most places where both say something."""
    said = [
        _value(a) == _value(b)
        for a, b in zip(cells, row, strict=False)
        if a.lower() not in _MISSING and b.lower() not in _MISSING
    ]
    begins = bool(cells and row) and _value(cells[0]) == _value(row[0])
    return begins and abs(len(_trimmed(cells)) - len(_trimmed(row))) <= len(row) // 2 and 2 * sum(said) > len(said)


def _torn(body: Sequence[Sequence[str]], width: int, named: int) -> bool:
    """Whether numbers with decimal commas are torn at them: twice as many fields as names, and whole numbers in all."""
    return width == 2 * named and all(cell.lstrip("+-").isdigit() for row in body for cell in row if cell)


def _value(cell: str) -> bool:
    return looks_numeric(cell) or bool(time_kind([cell]))


def _one_unit(n: int, cells: dict[int, list[str]]) -> bool:
    """Whether a line gives the unit of the first column alone."""
    above = cells.get(n - 1, [])
    return len(above) > 1 and len(cells[n]) == len(above) and unit_line(cells[n], above)


def _described(line: Sequence[str], above: Sequence[str]) -> bool:
    """Whether a line says in words what the names in the line above it mean, one of which is the time."""
    given, names = _trimmed(line), _trimmed(above)
    short = len(given) == len(names) and not any(" " in name for name in names) and any(map(says_time, names))
    return short and sum(" " in cell for cell in given) > 0.5 * len(given)


def _filled(body: Sequence[Sequence[str]], width: int) -> bool:
    """Whether most rows have a last field."""
    return sum(len(_trimmed(row)) == width for row in body) > 0.5 * len(body)


def _counted(body: Sequence[Sequence[str]], header: Sequence[str]) -> bool:
    """Whether the first field of rows is their number, and not a time that the header names."""
    first = [row[0] for row in body]
    begin = int(first[0]) if first[0] in ("0", "1") else -1
    if len(first) < 2 or begin < 0 or first != [str(begin + n) for n in range(len(first))]:
        return False
    second = [row[1] for row in body if len(row) > 1]
    numbers = [float(cell) for cell in second if re.fullmatch(r"[+-]?\d+(\.\d*)?", cell)]
    rises = len(numbers) == len(body) and all(a < b for a, b in pairwise(numbers))
    return rises or bool(time_kind(second)) or not says_time(header[0])


def _repeats(row: Sequence[str]) -> bool:
    """Whether a cell comes twice: the first line may be names that look like kinds of data, such as real and double, but these differ."""
    given = [cell for cell in row if cell]
    return len(set(given)) < len(given)


def _in_groups(header: list[str], above: Sequence[str]) -> list[str]:
    """Names, of which those that come again are ``group/name`` where the line above parts them; a group reaches to the next, as in merged cells."""
    again = {name for name, count in Counter(header).items() if name and count > 1}
    if not again or not _heads(above) or len(above) != len(header):
        return header
    groups: list[str] = []
    for group in above:
        groups.append(group or (groups[-1] if groups else ""))
    return [f"{group}/{name}" if group and name in again else name for group, name in zip(groups, header, strict=True)]


def _commented_header(texts: Sequence[str], first: int, delimiter: str, row: Sequence[str]) -> list[str] | None:
    """Names in a comment directly above the rows, as NumPy writes them."""
    text = texts[first - 1].strip() if first else ""
    if not text.startswith(_COMMENT):
        return None
    names = fields(text.lstrip("#/% "), delimiter)
    return names if len(names) == len(row) and len(names) > 1 else None


def _trimmed(row: Sequence[str]) -> list[str]:
    """A row without the empty fields at its end."""
    end = len(row)
    while end and not row[end - 1]:
        end -= 1
    return list(row[:end])


def _widths(body: Sequence[Sequence[str]], header: Sequence[str] | None) -> tuple[int, frozenset[int]]:
    """Fields of the rows, and the smaller numbers of fields that many of them have."""
    lengths = Counter(len(row) for row in body)
    named = len(_trimmed(header)) if header is not None else 0
    filled = max((len(_trimmed(row)) for row in body if lengths[len(row)] >= _USUAL * len(body)), default=1)
    usual = lengths.most_common(1)[0][0]
    width = max(usual, min(named, max(lengths)), filled)
    short = frozenset(n for n, count in lengths.items() if n < width and count >= max(2, _USUAL * len(body)))
    return width, short
