"""MAT logs: v5 through SciPy, variable by variable; v7.3 through h5py, block by block.

Vectors are signals, columns of matrices are signals ``name[1]``, ``name[2]``; fields of structures are ``name.field``. The longer
side of a matrix is time.
"""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import BLOCK, Log, LogBlock, Signal, once
from polydraulic.measure.log_units import need

Slices = Callable[[str, int, int], np.ndarray]  # (signal, first row, end) -> values


def open_mat(path: Path) -> Log:
    """Open a MAT log; see `polydraulic.measure.formats.logs.open_log`."""
    with path.open("rb") as file:
        head = file.read(128)
    if b"MATLAB 7.3" in head or head.startswith(b"\x89HDF"):
        lengths, read, close = _version_7_3(path)
    else:
        lengths, read, close = _version_5(path)
    if not lengths:
        close()
        raise InputError(f"{path}: the file has no numeric vectors or matrices")
    # signals of one length share their rows
    groups = {length: number for number, length in enumerate(dict.fromkeys(lengths.values()))}
    signals, twice = once([Signal(name, "", groups[length]) for name, length in lengths.items()])

    def blocks(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        total = lengths[wanted[0]]
        if time and lengths[time] != total:
            raise InputError(
                f"{path}: {wanted[0]!r} has {total} values, the time {time!r} has {lengths[time]}; "
                "import channels of another length in a call of their own"
            )
        for begun in range(0, total, BLOCK):
            end = min(begun + BLOCK, total)
            values = {name: read(name, begun, end) for name in wanted}
            clock = read(time, begun, end) if time else None
            text = {name: np.zeros(0, dtype=np.int64) for name in wanted}
            yield LogBlock(np.arange(begun, end) + 1, clock, values, text, end / total)

    return Log(path, signals, False, blocks, twice, close)


def _version_5(path: Path) -> tuple[dict[str, int], Slices, Callable[[], None]]:
    from scipy import io

    try:
        listed = io.whosmat(path)
    except Exception as error:  # SciPy raises errors of many kinds on damaged files
        raise InputError(f"{path}: cannot be read as a MAT log ({error})") from error
    # one variable in memory at a time: each signal goes to a file of its own, from which blocks are read
    folder = tempfile.TemporaryDirectory(prefix="polydraulic-")
    lengths: dict[str, int] = {}
    files: dict[str, Path] = {}

    def keep(name: str, item: Any) -> None:
        if isinstance(item, dict):
            for key, part in item.items():
                keep(f"{name}.{key}", part)
        elif isinstance(item, np.ndarray) and item.dtype.kind in "fiub" and 0 < item.ndim <= 2 and item.size > 1:
            columns = item.reshape(len(item), -1)
            columns = columns if columns.shape[0] >= columns.shape[1] else columns.T
            for number, label in enumerate(_labels(name, columns.shape[1])):
                files[label] = Path(folder.name) / str(len(files))
                columns[:, number].astype(np.float64).tofile(files[label])
                lengths[label] = len(columns)

    for name, _, kind in listed:
        if kind in ("cell", "char", "function", "object", "opaque", "sparse", "unknown"):
            continue
        try:
            keep(name, io.loadmat(path, variable_names=[name], simplify_cells=True).get(name))
        except Exception as error:
            raise InputError(f"{path}: variable {name!r} cannot be read ({error})") from error

    def read(name: str, begun: int, end: int) -> np.ndarray:
        return np.fromfile(files[name], count=end - begun, offset=8 * begun)

    return lengths, read, folder.cleanup


def _version_7_3(path: Path) -> tuple[dict[str, int], Slices, Callable[[], None]]:
    library = need("h5py")
    try:
        file = library.File(path, "r")
    except OSError as error:
        raise InputError(f"{path}: cannot be read as a MAT log ({error})") from error
    lengths: dict[str, int] = {}
    where: dict[str, tuple[str, int, int]] = {}  # dataset, axis of time, place on the other

    def keep(name: str, item: Any) -> None:
        if name.startswith("#") or not isinstance(item, library.Dataset):
            return
        if item.dtype.kind not in "fiub" or item.ndim not in (1, 2) or item.size < 2:
            return
        if item.attrs.get("MATLAB_class", b"double") in (b"char", b"cell"):
            return
        shape = (*item.shape, 1)[:2] if item.ndim == 1 else item.shape
        axis = int(shape[1] >= shape[0])  # MATLAB's rows are the last axis here
        for number, label in enumerate(_labels(name.replace("/", "."), shape[1 - axis])):
            where[label] = (name, axis if item.ndim == 2 else 0, number)
            lengths[label] = shape[axis]

    file.visititems(keep)

    def read(name: str, begun: int, end: int) -> np.ndarray:
        dataset, axis, number = where[name]
        item = file[dataset]
        if item.ndim == 1:
            part = item[begun:end]
        else:
            part = item[number, begun:end] if axis == 1 else item[begun:end, number]
        return np.asarray(part, dtype=np.float64)

    return lengths, read, file.close


def _labels(name: str, count: int) -> list[str]:
    return [name] if count == 1 else [f"{name}[{number}]" for number in range(1, count + 1)]
