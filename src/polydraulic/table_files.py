"""How tables lie in files, and in tables of Arrow: their columns of numbers, names with units, and what made them."""

import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from polydraulic.errors import InputError, briefly

if TYPE_CHECKING:
    import pyarrow as pa

OF_LOGS = "a log as it was recorded goes through `polydraulic import` first"
_HEADER = re.compile(r"^\s*(?P<name>.*?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*$", re.DOTALL)
_INFO_KEY = b"polydraulic"


def arrow_floats(columns: Iterable[np.ndarray], schema: "pa.Schema", *, nulls: bool = False) -> "pa.Table":
    """Arrays of floats as the Arrow table of a schema, uncopied, NaN as null if asked for.

    `pa.table` would import pandas to see whether they are its own.
    """
    import pyarrow as pa

    given = [np.ascontiguousarray(values, dtype=np.float64) for values in columns]
    arrays = [
        pa.Array.from_buffers(pa.float64(), len(values), [_validity(values) if nulls else None, pa.py_buffer(values)])
        for values in given
    ]
    return pa.Table.from_arrays(arrays, schema=schema)


def _validity(values: np.ndarray) -> Any:
    """Bits of the values that are there; None where all are."""
    import pyarrow as pa

    lacks = np.isnan(values)
    return pa.py_buffer(np.packbits(~lacks, bitorder="little")) if lacks.any() else None


def arrow_numbers(column: Any, name: str, where: str = "") -> np.ndarray:
    """An Arrow array as floats; NaN where a value is missing."""
    import pyarrow as pa

    if len(column) and not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
        shown = next((briefly(str(v)) for v in column.to_pylist() if v is not None), "no value")
        held = f"holds {shown} ({column.type})"
        raise InputError(f"{where}column {name!r} {held}; every value must be a number; {OF_LOGS}")
    try:
        return np.array(column.cast(pa.float64()).to_numpy(zero_copy_only=False), dtype=np.float64)
    except pa.ArrowInvalid as error:
        raise InputError(f"{where}column {name!r} holds whole numbers beyond 2^53, which no float holds") from error


def arrow_schema(units: Mapping[str, str], info: Mapping[str, object]) -> "pa.Schema":
    """Names and units as Arrow and Parquet keep them."""
    import pyarrow as pa

    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in units.items()]
    return pa.schema(fields, metadata={_INFO_KEY: _info_text(info)})


def _info_text(info: Mapping[str, object]) -> str:
    """What made a table, as JSON."""
    for key, value in info.items():
        try:
            json.dumps({key: value})
        except (TypeError, ValueError, RecursionError) as error:
            raise InputError(
                f"info[{key!r}] of the table is {briefly(value)} ({type(value).__name__}); files keep numbers, texts, and lists and dicts of "
                "these: convert it first, an array by its tolist()"
            ) from error
    return json.dumps(dict(info))


def arrow_unit(entry: "pa.Field") -> str:
    """Unit of a column, as `arrow_schema` keeps it."""
    return str((entry.metadata or {}).get(b"unit", b"").decode())


def arrow_info(schema: "pa.Schema") -> dict[str, object]:
    """What made a table, as `arrow_schema` keeps it."""
    stored = (schema.metadata or {}).get(_INFO_KEY)
    if not isinstance(found := json.loads(stored) if stored else {}, dict):
        raise ValueError(f"what it says of itself is no object: {str(found)[:40]}")
    return found


def read_file(path: Path, ending: str) -> tuple["pa.Table", list[tuple[str, str]], dict[str, object]]:
    """Columns of a file, names with units, and what made the table."""
    import pyarrow as pa

    try:
        if ending == ".csv":
            from pyarrow import csv

            raw = csv.read_csv(path)
        else:
            import pyarrow.parquet as pq

            raw = pq.read_table(path)
        heads = [entry.name for entry in raw.schema]
        given, info = [arrow_unit(entry) for entry in raw.schema], arrow_info(raw.schema)
    except (pa.ArrowException, OSError, ValueError, RecursionError) as error:  # the latter from damaged units and info
        why = (str(error).splitlines() or ["damaged"])[0]
        hint = f"; {OF_LOGS}" if ending == ".csv" else ""
        raise InputError(f"{path}: cannot be read as a {ending[1:]} table ({why}){hint}") from error
    return raw, list(map(name_and_unit, heads)) if ending == ".csv" else list(zip(heads, given, strict=True)), info


def write_rows(file: TextIO, columns: Sequence[np.ndarray], *, empty: bool) -> None:
    """Write rows of a CSV file, NaN as an empty cell if asked for."""
    text = StringIO()
    np.savetxt(text, np.column_stack(columns), fmt="%.17g", delimiter=",")
    file.write(text.getvalue().replace("nan", "") if empty else text.getvalue())


def quoted(text: str) -> str:
    """A head of a CSV column, in quotes where it holds what parts columns and lines."""
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n\r') else text


def name_and_unit(text: str) -> tuple[str, str]:
    """Name and unit of a head such as ``boom.p_in [Pa]``."""
    found = _HEADER.match(text)
    return (found["name"], found["unit"] or "") if found else (text, "")


def refuse_twice(names: Sequence[str], where: str) -> None:
    """Refuse columns of one name."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(f"{where}column {twice[0]!r} appears twice; give each column its own name")
