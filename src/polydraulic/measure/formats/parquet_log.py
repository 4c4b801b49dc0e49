"""Parquet logs: one group of rows; units from the metadata of the fields."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.arrow import numbers
from polydraulic.measure.formats.log import BLOCK, Log, LogBlock, Signal, once


def open_parquet(path: Path) -> Log:
    """Open a Parquet log; see `polydraulic.measure.formats.logs.open_log`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            schema, n_row = file.schema_arrow, file.metadata.num_rows
    except (pa.ArrowInvalid, OSError) as error:
        raise InputError(f"{path}: cannot be read as a Parquet log ({str(error).splitlines()[0]})") from error
    if n_row == 0:
        raise InputError(f"{path}: the log has no rows")
    signals, twice = once([Signal(f.name, _unit(f), 0) for f in schema if not pa.types.is_nested(f.type)])
    places = {s.name: schema.names.index(s.name) for s in signals}

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        begun = 0
        with pq.ParquetFile(
            path, pre_buffer=False, buffer_size=1 << 20
        ) as file:  # buffered ahead, the file is in memory
            columns = list(dict.fromkeys([*([time] if time else []), *wanted]))
            try:
                for batch in file.iter_batches(BLOCK, columns=columns):
                    of = {name: numbers(batch.column(batch.schema.names.index(name))) for name in columns}
                    rows = np.arange(begun, begun + batch.num_rows) + 1
                    begun += batch.num_rows
                    yield LogBlock(
                        rows,
                        of[time][0] if time else None,
                        {name: of[name][0] for name in wanted},
                        {name: of[name][1] for name in wanted},
                        begun / n_row,
                    )
            except (pa.ArrowInvalid, OSError) as error:
                raise InputError(f"{path}: damaged after row {begun} ({str(error).splitlines()[0]})") from error

    assert len(places) == len(signals)
    return Log(path, signals, False, read, twice)


def _unit(field: Any) -> str:
    return (field.metadata or {}).get(b"unit", b"").decode()
