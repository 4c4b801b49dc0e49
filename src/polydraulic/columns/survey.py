"""One reading of the numbers of a whole column: which mark is the decimal one, and whether the other sets thousands apart."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from polydraulic.columns.cells import MISSING, OFF, ON, all_switches, numbers, text_numbers

_ENGLISH = (",", ".")  # thousands, decimal


class Notation(NamedTuple):
    """How the numbers of a column are written.

    Attributes
    ----------
    decimal : str
        The decimal mark.
    thousands : str
        The mark between thousands; empty for none.
    mixed : bool
        Whether the mark that is not the decimal one comes in the column.
    switch : bool
        Words for on and off.
    kind, detail : str
        What to note about the column: a kind of finding, empty for none.
    """

    decimal: str = "."
    thousands: str = ""
    mixed: bool = False
    switch: bool = False
    kind: str = ""
    detail: str = ""

    def numbers(self, cells: Any) -> tuple[np.ndarray, np.ndarray]:
        """Values of an Arrow array of texts, NaN where there is none, and places that hold something else."""
        import pyarrow as pa
        import pyarrow.compute as pc

        if self.switch:
            lower = pc.utf8_lower(pc.utf8_trim_whitespace(cells))
            on, off = pc.is_in(lower, pa.array(ON)), pc.is_in(lower, pa.array(OFF))
            cells = pc.if_else(on, "1", pc.if_else(off, "0", cells))
        elif self.decimal == ",":
            if self.mixed:
                odd = pc.match_substring(cells, ".")
                if self.thousands:
                    grouped = pc.match_substring_regex(cells, _grouped(".", ","))
                    cells = pc.if_else(grouped, pc.replace_substring(cells, ".", ""), cells)
                    odd = pc.and_(odd, pc.invert(grouped))
                cells = pc.if_else(odd, "?", cells)
            cells = _points(cells)
        elif self.thousands:
            grouped = pc.match_substring_regex(cells, _grouped(",", "."))
            cells = pc.if_else(grouped, pc.replace_substring(cells, ",", ""), cells)
        return text_numbers(cells)


def _points(cells: Any) -> Any:
    """Texts with points in place of commas: in all bytes at once, which is ten times as fast as text by text."""
    import pyarrow as pa

    valid, offsets, data = cells.buffers()
    if data is None:
        return cells
    held = np.frombuffer(data, dtype=np.uint8).copy()
    held[held == ord(",")] = ord(".")
    return pa.StringArray.from_buffers(len(cells), offsets, pa.py_buffer(held), valid, -1, cells.offset)


def _grouped(thousands: str, decimal: str) -> str:
    return rf"^\s*[+-]?[0-9]{{1,3}}(?:[{thousands}][0-9]{{3}})+(?:[{decimal}][0-9]*)?\s*$"


class Evidence:
    """What speaks for one or the other mark in a column, block by block."""

    def __init__(self) -> None:
        # cells by what they show: a decimal mark for sure, groups of three digits only, several of these or both marks
        self.decimal = {",": 0, ".": 0}
        self.three = {",": 0, ".": 0}
        self.certain = {",": 0, ".": 0}  # groups of thousands for sure, by the mark between them
        self.bare_small = self.bare_large = 0
        self.words = self.switches = 0
        self.seen = {",": False, ".": False}
        self.example: dict[str, str] = {}

    def look(self, cells: Any) -> None:
        """Take note of an Arrow array of texts."""
        import pyarrow as pa
        import pyarrow.compute as pc

        cells = pc.utf8_trim_whitespace(cells).drop_null()
        cells = cells.filter(pc.invert(pc.is_in(cells, pa.array(MISSING))))
        if len(cells) == 0:
            return

        def count(which: Any, pattern: str) -> int:
            found = pc.match_substring_regex(which, pattern)
            return int(pc.sum(found).as_py() or 0)

        comma, point = pc.match_substring(cells, ","), pc.match_substring(cells, ".")
        self.seen = {",": self.seen[","] or pc.any(comma).as_py(), ".": self.seen["."] or pc.any(point).as_py()}
        for mark, mine in ((",", pc.and_(comma, pc.invert(point))), (".", pc.and_(point, pc.invert(comma)))):
            only = cells.filter(mine)
            if len(only) == 0:
                continue
            m = f"[{mark}]"
            groups = pc.match_substring_regex(only, rf"^[+-]?[1-9][0-9]{{0,2}}(?:{m}[0-9]{{3}})+$")
            three = count(only, rf"^[+-]?[1-9][0-9]{{0,2}}{m}[0-9]{{3}}$")
            several = count(only, rf"^[+-]?[1-9][0-9]{{0,2}}(?:{m}[0-9]{{3}}){{2,}}$")
            numbers = count(only, rf"^[+-]?[0-9]*{m}[0-9]*(?:[eEdD][+-]?[0-9]+)?$")
            self.three[mark] += three
            self.certain[mark] += several
            self.decimal[mark] += numbers - three
            self.words += len(only) - numbers - several
            if three + several:
                self.example.setdefault(mark, str(only.filter(groups)[0]))
        both = cells.filter(pc.and_(comma, point))
        if len(both):
            for thousands, decimal in (_ENGLISH, _ENGLISH[::-1]):
                grouped = count(both, _grouped(thousands, decimal))
                self.certain[thousands] += grouped
        bare = cells.filter(pc.invert(pc.or_(comma, point)))
        if len(bare):
            self.bare_small += count(bare, r"^[+-]?[0-9]{1,3}$")
            self.bare_large += count(bare, r"^[+-]?[0-9]{4,}$")
            lower = pc.utf8_lower(bare)
            self.switches += int(pc.sum(pc.is_in(lower, pa.array([*ON, *OFF]))).as_py() or 0)
            self.words += len(bare) - count(bare, r"^[+-]?[0-9]+(?:[eEdD][+-]?[0-9]+)?$")

    def reading(self, usual: str, elsewhere: str = "") -> Notation:
        """Decide; `usual` is the decimal mark of the file where a column does not tell, `elsewhere` that of other columns for sure."""
        found = self._reading_beside(elsewhere) if elsewhere else None
        found = self._reading(usual) if found is None else found
        return found._replace(mixed=self.seen["." if found.decimal == "," else ","])

    def _reading_beside(self, mark: str) -> Notation | None:
        """Decide where three digits behind every mark leave a doubt, and other columns have this decimal mark; None elsewhere."""
        other = "." if mark == "," else ","
        sure = self.decimal[mark] + self.certain[other]
        against = self.decimal[other] + self.certain[mark]
        if self.three[mark] and against and not sure and self.three[mark] > against:
            detail = f"{self.three[mark]} with {mark!r} as in other columns, {against} with {other!r}"
            return Notation(mark, kind="decimal mark", detail=detail)
        if self.three[other] and not sure and not against and (self.bare_large or not self.bare_small):
            such = f"{self.three[other]} of them, such as {self.example[other]!r}"
            if self.three[mark]:
                return Notation(mark, kind="decimal mark", detail=f"{such}; other columns have {mark!r}")
            return Notation(
                mark, other, kind="thousands", detail=f"{such}; other columns have the decimal mark {mark!r}"
            )
        return None

    def _reading(self, usual: str) -> Notation:
        n_number = sum(self.decimal.values()) + sum(self.three.values()) + sum(self.certain.values())
        n_number += self.bare_small + self.bare_large
        if self.switches and self.switches == self.words and n_number == 0:
            return Notation(switch=True, kind="on and off")
        comma = self.decimal[","] + self.certain["."]
        point = self.decimal["."] + self.certain[","]
        if comma and point:
            mark = "," if comma > point else "."
            return Notation(mark, kind="decimal mark", detail=f"{comma} with a comma, {point} with a point")
        if comma or point:
            mark, other = (",", ".") if comma else (".", ",")
            grouped = self.three[other] + self.certain[other]
            if not grouped:
                return Notation(mark)
            example = self.example.get(other)
            such = f"{grouped} of them" + (f", such as {example!r}" if example else "")
            return Notation(mark, other, kind="thousands", detail=f"{such}; the decimal mark is {mark!r}")
        if self.three[","] and self.three["."]:
            n = {m: self.three[m] for m in ",."}
            detail = f"{n[',']} with a comma, {n['.']} with a point, each before three digits"
            return Notation(usual, kind="decimal mark", detail=detail)
        mark = "," if self.three[","] else "." if self.three["."] else usual
        if self.three[mark] and self.bare_small and not self.bare_large:
            detail = f"such as {self.example[mark]!r} beside numbers without {mark!r}"
            return Notation(mark, kind="doubtful numbers", detail=detail)
        return Notation(mark)


def survey(
    blocks: Iterable[dict[str, Any]], columns: Iterable[str], usual: str, elsewhere: str = ""
) -> dict[str, Notation]:
    """One reading for each column, from all blocks of cells."""
    evidence = {name: Evidence() for name in columns}
    for block in blocks:
        for name, seen in evidence.items():
            seen.look(block[name])
    return {name: seen.reading(usual, elsewhere) for name, seen in evidence.items()}


class TextColumn:
    """A column of texts, block by block; the whole of it is looked at where words for on and off come before any number.

    Parameters
    ----------
    reading : Notation
    whole : function () -> Notation
        Looks at the whole column.
    """

    def __init__(self, reading: Notation, whole: Callable[[], Notation]) -> None:
        self.reading, self.whole = reading, whole
        self._settled = reading.switch or bool(reading.kind)

    def plain(self, decimal: str) -> bool:
        """Whether texts that Arrow takes as numbers with this decimal mark are the numbers that they are read as."""
        return self.reading.decimal == decimal and not self.reading.switch

    def numbers(self, cells: Any) -> tuple[np.ndarray, np.ndarray]:
        """Values of an Arrow array of texts, NaN where there is none, and places that hold something else.

        Numbers that have been read already are their own values.
        """
        import pyarrow as pa

        values, bad = numbers(cells) if pa.types.is_floating(cells.type) else self.reading.numbers(cells)
        if not self._settled and bad.size and not np.isfinite(values).any() and all_switches(cells.take(bad)):
            found = self.whole()
            self.reading = found if found.switch else self.reading
            values, bad = self.reading.numbers(cells)
        self._settled = self._settled or bad.size > 0 or bool(np.isfinite(values).any())
        return values, bad
