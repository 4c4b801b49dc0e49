"""Numbers in Arrow arrays, of whatever kind a file has made them."""

from typing import Any

import numpy as np


def numbers(column: Any) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of an Arrow array of any kind: values, NaN where there is none, and places that hold something else.

    Times of day become s since 1970.
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    if isinstance(column, pa.ChunkedArray):
        column = column.combine_chunks()
    if pa.types.is_dictionary(column.type):
        column = column.dictionary_decode()
    none = np.zeros(0, dtype=np.int64)
    if pa.types.is_timestamp(column.type):
        exact = column.cast(pa.timestamp("ns"), safe=False).cast(pa.int64())
        return exact.to_numpy(zero_copy_only=False) * 1e-9, none
    if not (pa.types.is_string(column.type) or pa.types.is_large_string(column.type)):
        try:
            return column.cast(pa.float64()).to_numpy(zero_copy_only=False).astype(np.float64), none
        except (pa.ArrowInvalid, pa.ArrowNotImplementedError):
            return np.full(len(column), np.nan), np.arange(len(column))
    trimmed = pc.utf8_trim_whitespace(column)
    trimmed = pc.if_else(pc.is_in(trimmed, pa.array(["", "NaN", "nan", "NA", "n/a", "null", "-"])), None, trimmed)
    try:
        return trimmed.cast(pa.float64()).to_numpy(zero_copy_only=False), none
    except pa.ArrowInvalid:
        pass
    try:
        return numbers(trimmed.cast(pa.timestamp("ns")))
    except pa.ArrowInvalid:
        pass
    values, bad = np.full(len(column), np.nan), []
    for place, item in enumerate(trimmed.to_pylist()):
        try:
            values[place] = np.nan if item is None else float(item)
        except ValueError:
            bad.append(place)
    return values, np.asarray(bad, dtype=np.int64)
