"""From the raw values of an MDF channel to physical ones.

Scalings, tables of numbers and rational functions are asammdf's, formulas are `mdf_formula`'s. Tables of texts are read here, entry by entry: asammdf gives them
as numbers or as texts, by what a block happens to hold, and takes their bounds as whole numbers.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic.measure.formats.floats import as_floats
from polydraulic.measure.formats.status_text import StatusText, no_value, states

_VALUES_TO_TEXT, _RANGES_TO_TEXT, _BITS_TO_TEXT = 7, 8, 11  # of MDF 4
_TEXT_OF_3 = (11, 12)  # of MDF 3: these have no scaling beside them


class Physical(NamedTuple):
    """Values, NaN where there is none or where they are texts, and the places of each text; no values where all are words."""

    values: np.ndarray | None
    said: dict[str, np.ndarray]


def physical(raw: np.ndarray, conversion: Any, *, version: int, unit: str = "", bits: int | None = None) -> Physical:
    """Convert raw values of a channel.

    Parameters
    ----------
    raw : (n,) array
    conversion : channel conversion of asammdf, or None
    version : int
        Of the MDF format, 3 or 4.
    unit : str
        Of the channel.
    bits : int, optional
        Of the raw value.
    """
    kind = None if conversion is None else conversion.conversion_type
    if kind is None or (kind in _TEXT_OF_3 if version < 4 else kind == _BITS_TO_TEXT):
        return Physical(_numbers(raw), {})
    if version < 4 or kind not in (_VALUES_TO_TEXT, _RANGES_TO_TEXT):
        return Physical(_numbers(conversion.convert(raw)), {})
    if raw.ndim != 1 or raw.dtype.kind not in "fiub":
        return Physical(_numbers(raw), {})
    values, said = _table(raw, conversion, unit, bits) if _scales(conversion) else _names(raw, conversion, bits)
    return Physical(values, {text: np.flatnonzero(there) for text, there in said.items()})


def _table(raw: np.ndarray, conversion: Any, unit: str, bits: int | None) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Values of a table of which at least one entry is a number."""
    entries = _entries(conversion)
    default = conversion.referenced_blocks.get("default_addr")
    texts = [(n, StatusText(low, high, _text(item))) for n, (low, high, item) in enumerate(entries) if _is_text(item)]
    numbered = states([t for _, t in texts], scaled=bool(unit) or not _same(default), bits=bits)
    names = {n: t.text for (n, t), number in zip(texts, numbered, strict=True) if not number}
    values = np.full(len(raw), np.nan)
    said: dict[str, np.ndarray] = {}
    open_ = np.ones(len(raw), dtype=bool)
    for n, (low, high, item) in enumerate([*entries, (-np.inf, np.inf, default)]):
        if n == len(entries):
            here = open_ & ~np.isnan(raw)
        elif raw.dtype.kind == "f" and low < high:
            here = open_ & (raw >= low) & (raw < high)  # ranges of numbers with a fraction do not hold their end
        else:
            here = open_ & (raw >= low) & (raw <= high)
        if not here.any():
            continue
        open_ &= ~here
        if n in names or (n == len(entries) and (item is None or _is_text(item))):
            text = names.get(n) or (_text(item) if item is not None else "") or "(not in the table of values)"
            said[text] = said.get(text, False) | here
        elif item is None or _is_text(item):  # a state, or an entry that changes nothing
            values[here] = raw[here]
        elif item.conversion_type in (_VALUES_TO_TEXT, _RANGES_TO_TEXT) and _scales(item):
            values[here], inner = _table(raw[here], item, unit, None)
            for text, there in inner.items():
                places = np.zeros(len(raw), dtype=bool)
                places[np.flatnonzero(here)[there]] = True
                said[text] = said.get(text, False) | places
        elif item.conversion_type in (_VALUES_TO_TEXT, _RANGES_TO_TEXT, _BITS_TO_TEXT):
            text = str(item.name or "text")
            said[text] = said.get(text, False) | here
        else:
            values[here] = _numbers(item.convert(raw[here]))
    return values, said


def _names(raw: np.ndarray, conversion: Any, bits: int | None) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Values of a table of nothing but texts: the numbers that these name, but for texts that say that there is no value."""
    texts = [StatusText(low, high, _text(item)) for low, high, item in _entries(conversion) if _is_text(item)]
    values = raw.astype(np.float64)
    said: dict[str, np.ndarray] = {}
    for one, is_state in zip(texts, states(texts, scaled=False, bits=bits), strict=True):
        here = (raw >= one.low) & (raw <= one.high)
        if not is_state and no_value(one.text) and here.any():
            values[here] = np.nan
            said[one.text] = said.get(one.text, False) | here
    return values, said


def _entries(conversion: Any) -> list[tuple[float, float, Any]]:
    refs = conversion.referenced_blocks
    if conversion.conversion_type == _VALUES_TO_TEXT:
        keys = [(f"val_{n}", f"val_{n}", f"text_{n}") for n in range(conversion.val_param_nr)]
    else:
        keys = [(f"lower_{n}", f"upper_{n}", f"text_{n}") for n in range(conversion.val_param_nr // 2)]
    return [(float(conversion[low]), float(conversion[high]), refs.get(text)) for low, high, text in keys]


def _scales(conversion: Any) -> bool:
    """Whether a table holds a scaling, itself or in a table in it: then it gives numbers, and its texts are none."""
    for item in conversion.referenced_blocks.values():
        if item is None or _is_text(item) or item.conversion_type == _BITS_TO_TEXT:
            continue
        if item.conversion_type not in (_VALUES_TO_TEXT, _RANGES_TO_TEXT) or _scales(item):
            return True
    return False


def _same(conversion: Any) -> bool:
    """Whether a scaling changes nothing."""
    if conversion is None or _is_text(conversion):
        return True
    return conversion.conversion_type == 0 or (
        conversion.conversion_type == 1 and (conversion.a, conversion.b) == (1.0, 0.0)
    )


def _is_text(item: Any) -> bool:
    return isinstance(item, (bytes, str))


def _text(item: bytes | str) -> str:
    if isinstance(item, str):
        return item.strip("\0 ")
    try:
        text = item.decode("utf-8")
    except UnicodeDecodeError:  # against the standard, and as many tools write
        text = item.decode("latin-1")
    return text.strip("\0 ")


def _numbers(samples: Any) -> np.ndarray | None:
    samples = np.asarray(samples)
    return as_floats(samples) if samples.ndim == 1 and samples.dtype.kind in "fiub" else None
