"""Numbers in Arrow arrays, of whatever kind a file has made them."""

from typing import Any

import numpy as np

from polydraulic.columns.timestamps import DAY, since_1970

MISSING = ["", "NaN", "nan", "NA", "n/a", "N/A", "null", "NULL", "None", "-", "#N/A", "NaT"]
ON = ("true", "on", "yes", "ein", "an", "ja", "wahr", "vrai", "oui", "enabled", "active", "high")
OFF = ("false", "off", "no", "aus", "nein", "falsch", "faux", "non", "disabled", "inactive", "low")
TICKS = {"s": 1, "ms": 1_000, "us": 1_000_000, "ns": 1_000_000_000}
_FORTRAN = r"^\s*([+-]?[0-9.]+)[dD]([+-]?[0-9]+)\s*$"
_BETWEEN = "[ '’\u00a0\u2009\u202f]"  # thousands, where it can be nothing else
_MINUS = "^[\u2010-\u2013\u2212\ufe63\uff0d]"  # as word processors write it
_BEHIND = r"^([0-9][0-9.]*)-$"  # a minus behind its number, as ledgers have it
_GROUPED = rf"^[+-]?[0-9]{{1,3}}(?:{_BETWEEN}[0-9]{{3}})+(?:\.[0-9]*)?$"
_NONE = np.zeros(0, dtype=np.int64)


def numbers(column: Any) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of an Arrow array of any kind: values, NaN where there is none, and places that hold something else.

    Dates become s since 1970, times of day s since midnight, durations s. The least and the largest 64-bit integer stand for no
    value. Whole numbers above 2^53 are rounded once.
    """
    import pyarrow as pa

    if isinstance(column, pa.ChunkedArray):
        column = column.combine_chunks()
    kind = column.type
    if pa.types.is_dictionary(kind):
        return numbers(column.dictionary_decode())
    if is_time(kind):
        return _times(column), _NONE
    if pa.types.is_int64(kind) or pa.types.is_uint64(kind):
        return _whole(column)
    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return text_numbers(column.cast(pa.string()))
    try:
        return column.cast(pa.float64()).to_numpy(zero_copy_only=False).astype(np.float64), _NONE
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError):
        return np.full(len(column), np.nan), np.flatnonzero(column.is_valid().to_numpy(zero_copy_only=False))


def is_time(kind: Any) -> bool:
    """Whether an Arrow type is a date, a time of day or a duration, and so in s here, whatever a map says."""
    import pyarrow as pa

    return bool(pa.types.is_temporal(kind)) and not bool(pa.types.is_interval(kind))


def _times(column: Any) -> np.ndarray:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_date(kind):
        return since_1970(column.cast(pa.date32()).cast(pa.int32()).cast(pa.int64()), 1) * DAY
    whole = column.cast(pa.int32()) if kind.bit_width == 32 else column
    return since_1970(whole.cast(pa.int64()), TICKS[kind.unit])


def _whole(column: Any) -> tuple[np.ndarray, np.ndarray]:
    missing = column.is_null().to_numpy(zero_copy_only=False)
    given = column.fill_null(0).to_numpy(zero_copy_only=False)
    limits = np.iinfo(given.dtype)
    none = given == limits.max
    if limits.min < 0:
        none |= given == limits.min
    values = given.astype(np.float64)
    values[missing | none] = np.nan
    return values, np.flatnonzero(none & ~missing)


def text_numbers(cells: Any) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of texts with decimal points: values, and places that hold something else."""
    import pyarrow as pa
    import pyarrow.compute as pc

    try:
        return cells.cast(pa.float64()).to_numpy(zero_copy_only=False), _NONE
    except pa.ArrowInvalid:
        pass
    trimmed = pc.utf8_trim_whitespace(cells)
    trimmed = pc.if_else(pc.is_in(trimmed, pa.array(MISSING)), None, trimmed)
    try:
        return trimmed.cast(pa.float64()).to_numpy(zero_copy_only=False), _NONE
    except pa.ArrowInvalid:
        pass
    plain = pc.replace_substring_regex(pc.replace_substring_regex(trimmed, _FORTRAN, r"\1e\2"), _MINUS, "-")
    plain = pc.replace_substring_regex(plain, _BEHIND, r"-\1")
    grouped = pc.match_substring_regex(plain, _GROUPED)
    plain = pc.if_else(grouped, pc.replace_substring_regex(plain, _BETWEEN, ""), plain)
    looks = pc.match_substring_regex(
        plain, r"^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?$|^[+-]?(?i:inf|infinity|nan)$"
    )
    looks = looks.fill_null(False)
    values = pc.if_else(looks, pc.replace_substring_regex(plain, r"^\+", ""), None)
    found = values.cast(pa.float64()).to_numpy(zero_copy_only=False)
    bad = np.flatnonzero(pc.and_(trimmed.is_valid(), pc.invert(looks)).to_numpy(zero_copy_only=False))
    return found, bad


def all_switches(cells: Any) -> bool:
    """Whether texts are all words for on and off."""
    import pyarrow as pa
    import pyarrow.compute as pc

    lower = pc.utf8_lower(pc.utf8_trim_whitespace(cells))
    return bool(pc.all(pc.is_in(lower, pa.array([*ON, *OFF]))).as_py())
