"""Times as text: dates of every common form, times of day, durations; as seconds.

Which of two numbers of 03/04/2024 is the day is never guessed: a day above 12 somewhere in the column tells, or the caller says.
"""

import re
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np

from polydraulic.errors import InputError

ORDERS = ("dd/mm/yyyy", "mm/dd/yyyy")
DAY = 86400.0  # s
_MONTHS = "jan feb mar apr may jun jul aug sep oct nov dec".split()
_NAMES = {name: n for n, name in enumerate(_MONTHS, 1)} | {"mrz": 3, "mär": 3, "mai": 5, "okt": 10, "dez": 12}
_DATE = r"(?P<a>\d{1,4})(?P<mark>[-./ ])(?P<b>\d{1,2}|[A-Za-zä]{3})[-./ ](?P<c>\d{1,4})"
_OF_DAY = (
    r"(?P<h>\d{1,3}):(?P<m>\d{1,2})(?::(?P<s>\d{1,2}(?:[.,]\d*|:\d{3}(?:\d{3})?)?))?\s*(?P<half>[AaPp]\.?[Mm]\.?)?"
)
# h; of North America, and of Europe; what means two things, such as IST, or CST (China's, too), is none
_ZONES = {
    "EST": -5, "EDT": -4, "MST": -7, "MDT": -6, "PST": -8, "PDT": -7,
    "WET": 0, "WEST": 1, "CET": 1, "CEST": 2, "MEZ": 1, "MESZ": 2, "EET": 2, "EEST": 3,
}  # fmt: skip
# a place in brackets, such as [Europe/Berlin], says nothing more behind an offset; alone it is no zone, and the text no time
_ZONE = rf"\s*(?:(?P<zone>[Zz]|UTC|GMT|[+-]\d{{2}}:?\d{{2}}|[+-]\d{{2}}|{'|'.join(_ZONES)})(?:\[[\w/+-]+\])?)?"
_STAMP = rf"^{_DATE}(?:(?:[T,_]\s*|\s+){_OF_DAY}{_ZONE})?$"
_CLOCK = rf"^(?:(?P<days>-?\d{{1,5}}) days?,?\s+\+?)?(?P<sign>-?){_OF_DAY}$"  # days, as durations of pandas have
# dates and times without marks between their numbers, and with them
_CLOSE = r"^(\d{4})(\d{2})(\d{2})[Tt _](\d{2})(\d{2})(\d{2})"
_APART = r"\1-\2-\3T\4:\5:\6"
# of digits alone, milliseconds among them; no number of seconds since 1970, nor of parts of these, is like it within 200 years
_DIGITS = (
    r"^((?:19|20)\d{2})(0[1-9]|1[0-2])(0[1-9]|[12]\d|3[01])([01]\d|2[0-3])([0-5]\d)([0-5]\d)(?:[.,](\d+)|(\d{3}))?$"
)
_DIGITS_APART = r"\1-\2-\3T\4:\5:\6.\7\8"
# weekdays and months before the day: Sun, 31 Mar 2024; Mar 31, 2024; Sun Mar 31 13:59:57 2024
_DAY_LAST = (
    (r"^(?:Mon|Tue|Wed|Thu|Fri|Sat|Sun),?\s+", ""),
    (r"^([A-Z][a-z]{2})[a-z]*\s+(\d{1,2}),?\s+(\d{4})\b", r"\2-\1-\3"),
    (r"^([A-Z][a-z]{2})\s+(\d{1,2})\s+(\d[\d:.]+)\s+(\d{4})$", r"\2-\1-\4 \3"),
)
_SHORT = r"^(?P<m>\d{1,2}):(?P<s>\d{1,2}[.,]\d+)$"  # minutes and seconds, as Excel writes them


def time_kind(cells: Iterable[str]) -> str:
    """What texts are: ``"stamp"`` (a date, mostly with a time), ``"clock"`` (a time of day), or nothing of it: an empty text."""
    kinds = [_kind(text) for cell in cells if (text := cell.strip())]
    for kind in ("stamp", "clock"):
        if kinds and kinds.count(kind) > 0.5 * len(kinds):
            return kind
    return ""


@lru_cache(1 << 14)  # of the cells that a file is known by, each is looked at several times
def _kind(text: str) -> str:
    if re.match(_STAMP, _in_order(text)):
        return "stamp"
    return "clock" if ":" in text and (re.match(_CLOCK, text) or re.match(_SHORT, text)) else ""


def _in_order(text: str) -> str:
    """A date that `_STAMP` knows, where a text is one."""
    text = re.sub(_DIGITS, _DIGITS_APART, re.sub(_CLOSE, _APART, text))
    if text[:1].isalpha():
        for written, read in _DAY_LAST:
            text = re.sub(written, read, text)
    return text


def has_time_of_day(cells: Iterable[str]) -> bool:
    """Whether texts that are dates have a time of day."""
    return any(":" in cell or re.match(_CLOSE, cell.strip()) or re.match(_DIGITS, cell.strip()) for cell in cells)


def has_zone(cells: Iterable[str]) -> bool:
    """Whether texts that are times say their zone."""
    found = (re.match(_STAMP, _in_order(cell.strip())) for cell in cells)
    return any(match["zone"] for match in found if match)


class DateOrder:
    """Which of two numbers is the day, from all dates of a column."""

    def __init__(self) -> None:
        self.order: str | None = None
        self.needed = False
        self.example = ""

    def look(self, cells: Any) -> None:
        """Take note of an Arrow array of texts."""
        import pyarrow.compute as pc

        parts = pc.extract_regex(
            pc.utf8_trim_whitespace(cells), r"^(?P<a>\d{1,2})[/-](?P<b>\d{1,2})[/-](?:\d{2}|\d{4})\b"
        )
        parts = parts.drop_null()
        if len(parts) == 0 or self.order is not None:
            return
        a, b = (int(pc.max(pc.struct_field(parts, name).cast("int32")).as_py()) for name in ("a", "b"))
        self.needed = True
        self.example = self.example or str(cells.drop_null()[0])
        if a > 12 or b > 12:
            self.order = ORDERS[0] if a > 12 else ORDERS[1]

    @property
    def settled(self) -> bool:
        """Whether the day is known, or need not be."""
        return self.order is not None or not self.needed


def doubt(path: Any, column: str, example: str) -> InputError:
    """Return the error of a column of dates that can be read in two ways."""
    return InputError(
        f"{path}: dates of {column!r} such as {example!r} can be read in two ways, and no day of the log is above the 12th; "
        f'say in the map, at the channel of the time, dates = "{ORDERS[0]}" or dates = "{ORDERS[1]}"'
    )


def seconds(cells: Any, kind: str, order: str | None = None) -> np.ndarray:
    """Seconds of an Arrow array of texts, NaN where a text is no time.

    Parameters
    ----------
    cells : Arrow array of string
    kind : str
        As `time_kind` says: ``"stamp"`` gives seconds since 1970 (of UTC where the text has a zone), ``"clock"`` seconds of the day.
    order : str, optional
        One of `ORDERS`, for dates with slashes or dashes whose year stands last.
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    cells = pc.utf8_trim_whitespace(cells)
    if kind == "clock":
        return _clock(cells)
    cells = pc.replace_substring_regex(pc.replace_substring_regex(cells, _CLOSE, _APART), _DIGITS, _DIGITS_APART)
    for zone in (None, "UTC"):
        try:
            exact = cells.cast(pa.timestamp("ns", tz=zone)).cast(pa.int64())
        except pa.ArrowInvalid:
            continue
        return since_1970(exact, 1_000_000_000)
    if pc.any(pc.match_substring_regex(cells, "^[A-Z]")).as_py():
        for written, read in _DAY_LAST:
            cells = pc.replace_substring_regex(cells, written, read)
    parts = pc.extract_regex(cells, _STAMP)
    part = {field.name: pc.struct_field(parts, field.name) for field in parts.type}
    return _days(part, order) * DAY + _of_day(part, 0.0) - _offset(part["zone"])


def since_1970(ticks: Any, a_second: int) -> np.ndarray:
    """Seconds of whole ticks (Arrow array of int64), rounded once; NaN where there is none."""
    missing = ticks.is_null().to_numpy(zero_copy_only=False)
    whole = ticks.fill_null(0).to_numpy(zero_copy_only=False)
    found = whole // a_second + (whole % a_second) / float(a_second)
    return np.where(missing, np.nan, found)


def _clock(cells: Any) -> np.ndarray:
    import pyarrow.compute as pc

    parts = pc.extract_regex(cells, _CLOCK)
    part = {field.name: pc.struct_field(parts, field.name) for field in parts.type}
    found = _of_day(part, np.nan)
    found = np.where(_is(part["sign"], "-"), -found, found) + DAY * np.nan_to_num(_float(part["days"]))
    short = pc.extract_regex(cells, _SHORT)
    if short.null_count < len(short):
        m, s = (_float(pc.struct_field(short, name)) for name in ("m", "s"))
        found = np.where(np.isfinite(m), 60.0 * m + s, found)
    return found


def _of_day(part: dict[str, Any], without: float) -> np.ndarray:
    """Seconds of the day; `without` where a text has none."""
    h, m, s = _float(part["h"]), _float(part["m"]), np.nan_to_num(_float(part["s"]))
    given = np.isfinite(h)
    half = part["half"]
    if half.null_count < len(half):
        evening, morning = _is(half, "p", first=True), _is(half, "a", first=True)
        h = np.where((evening | morning) & (h == 12.0), 0.0, h) + np.where(evening, 12.0, 0.0)
    found = np.where((m < 60.0) & (s < 61.0), 3600.0 * h + 60.0 * m + s, np.nan)
    return np.where(given, found, without)


def _days(part: dict[str, Any], order: str | None) -> np.ndarray:
    """Days since 1970."""
    import pyarrow as pa
    import pyarrow.compute as pc

    a, c = _float(part["a"]), _float(part["c"])
    word = pc.index_in(pc.utf8_lower(part["b"]), pa.array(list(_NAMES)))
    named = word.is_valid().to_numpy(zero_copy_only=False)
    digits = _float(pc.if_else(word.is_valid(), None, part["b"]))
    b = np.where(named, np.array(list(_NAMES.values()))[np.nan_to_num(_float(word)).astype(int)], digits)
    year_first = _long(part["a"])
    year = np.where(year_first, a, np.where(_long(part["c"]), c, c + 2000.0))
    month, day = b, np.where(year_first, c, a)
    point = _is(part["mark"], ".")
    if order == ORDERS[1]:
        turned = ~year_first & ~named & ~point
        month, day = np.where(turned, day, month), np.where(turned, month, day)
    elif order is None:
        day = np.where(year_first | named | point, day, np.nan)
    good = np.isfinite(day) & np.isfinite(month) & np.isfinite(year) & (month >= 1) & (month <= 12)
    months = ((np.where(good, year, 1970) - 1970) * 12 + np.where(good, month, 1) - 1).astype("datetime64[M]")
    begins, ends = months.astype("datetime64[D]"), (months + 1).astype("datetime64[D]")
    good &= (day >= 1) & (day <= (ends - begins).astype(float))
    return np.where(good, begins.astype(float) + day - 1.0, np.nan)


def _offset(zone: Any) -> np.ndarray:
    import pyarrow as pa
    import pyarrow.compute as pc

    if zone.null_count == len(zone):
        return np.zeros(len(zone))
    parts = pc.extract_regex(zone, r"^(?P<h>[+-]\d{2}):?(?P<m>\d{2})?$")
    h, m = (np.nan_to_num(_float(pc.struct_field(parts, name))) for name in ("h", "m"))
    named = pc.index_in(zone, pa.array(list(_ZONES))).fill_null(len(_ZONES)).to_numpy(zero_copy_only=False)
    h = h + np.array([*_ZONES.values(), 0])[named]
    return 3600.0 * h + np.where(_is(zone, "-", first=True), -60.0, 60.0) * m


def _float(texts: Any) -> np.ndarray:
    """Numbers of texts that are digits; NaN where there is none."""
    import pyarrow as pa
    import pyarrow.compute as pc

    if pa.types.is_string(texts.type):
        texts = pc.replace_substring_regex(texts, "[,:]", ".")
        texts = pc.if_else(pc.match_substring_regex(texts, r"^[+-]?[0-9]+\.?[0-9]*$"), texts, None)
        texts = pc.replace_substring_regex(texts, r"^\+", "")
    return texts.cast(pa.float64()).to_numpy(zero_copy_only=False)


def _is(texts: Any, what: str, first: bool = False) -> np.ndarray:
    import pyarrow.compute as pc

    same = pc.starts_with(texts, what, ignore_case=True) if first else pc.equal(texts, what)
    return same.fill_null(False).to_numpy(zero_copy_only=False)


def _long(texts: Any) -> np.ndarray:
    import pyarrow.compute as pc

    return pc.equal(pc.utf8_length(texts), 4).fill_null(False).to_numpy(zero_copy_only=False)
