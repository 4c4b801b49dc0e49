"""Logs as files hold them: signals in groups of common rows, read block by block."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings

ENDINGS = (".csv", ".csv.gz", ".txt", ".parquet", ".mf4", ".mat")
BLOCK = 1 << 16  # rows


class Signal(NamedTuple):
    """A signal of a log: its name, its unit as the log gives it (empty if it gives none), its group."""

    name: str
    unit: str
    group: int


class Block(NamedTuple):
    """Some rows of one group.

    Attributes
    ----------
    rows : (n_row,) array of int
        Their numbers in the file, data rows counted from 1.
    time : (n_row,) array or None
        In the log's unit of time; None where the log has no clock of its own and none was asked for.
    values : dict from name to (n_row,) array
        NaN where there is no value.
    text : dict from name to array of int
        Places in the block that hold something that is no number.
    done : float
        Share of the group that has been read.
    """

    rows: np.ndarray
    time: np.ndarray | None
    values: dict[str, np.ndarray]
    text: dict[str, np.ndarray]
    done: float


Reader = Callable[[int, Sequence[str], str | None, Findings], Iterator[Block]]


@dataclass(frozen=True)
class Log:
    """An opened log.

    Attributes
    ----------
    path : Path
    signals : list of Signal
        Each name once: the first where the file has it more than once.
    duplicates : list of str
        Names that the file has more than once.
    own_clock : bool
        Whether every group has a time of its own (MDF), in s.
    read : function (group, names, time, findings) -> iterator of Block
    close : function ()
        Lets go of what the log holds; a log is a context that does so at its end.
    """

    path: Path
    signals: list[Signal]
    own_clock: bool
    read: Reader = field(repr=False)
    duplicates: list[str] = field(default_factory=list)
    close: Callable[[], None] = field(default=lambda: None, repr=False)

    def __enter__(self) -> "Log":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def signal(self, name: str) -> Signal:
        """Return the signal of a name, or raise an InputError that lists those there are."""
        for signal in self.signals:
            if signal.name == name:
                return signal
        names = [s.name for s in self.signals]
        shown = f"{names[:30]}" + (f" and {len(names) - 30} more" if len(names) > 30 else "")
        raise InputError(f"{self.path}: no channel {name!r}; the log has {shown}")


def open_log(path: str | Path) -> Log:
    """Open a log: CSV (plain or .gz), Parquet, MDF4, MAT v5 or v7.3.

    Parameters
    ----------
    path : str or Path
        A CSV header may carry units as ``name [unit]``, or in a line of their own below it.

    Raises
    ------
    InputError
        No such file, another ending, a file that is not what its ending says.
    """
    path = Path(path)
    ending = next((e for e in ENDINGS if path.name.lower().endswith(e)), None)
    if ending is None:
        raise InputError(f"{path}: a log ends in one of {list(ENDINGS)}, not in {path.suffix!r}")
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if ending == ".parquet":
        from polydraulic.measure.parquet_log import open_parquet as opener
    elif ending == ".mf4":
        from polydraulic.measure.mdf_log import open_mdf as opener
    elif ending == ".mat":
        from polydraulic.measure.mat_log import open_mat as opener
    else:
        from polydraulic.measure.csv_log import open_csv as opener
    return opener(path)


def once(signals: list[Signal]) -> tuple[list[Signal], list[str]]:
    """Signals by name, the first of each, and the names that come more than once."""
    first: dict[str, Signal] = {}
    twice: dict[str, None] = {}
    for signal in signals:
        if signal.name in first:
            twice[signal.name] = None
        else:
            first[signal.name] = signal
    return list(first.values()), list(twice)


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
