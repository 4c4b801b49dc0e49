"""Columns of numbers as tables of Arrow, which write them."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pyarrow as pa


def arrow_floats(columns: Iterable[np.ndarray], schema: "pa.Schema") -> "pa.Table":
    """Arrays of floats as the Arrow table of a schema, uncopied; `pa.table` would import pandas to see whether they are its own."""
    import pyarrow as pa

    given = [np.ascontiguousarray(values, dtype=np.float64) for values in columns]
    arrays = [pa.Array.from_buffers(pa.float64(), len(values), [None, pa.py_buffer(values)]) for values in given]
    return pa.Table.from_arrays(arrays, schema=schema)
