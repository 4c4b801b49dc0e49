"""MAT logs: v5 through SciPy, variable by variable; v7.3 through h5py, block by block.

Vectors are signals, columns of matrices are signals ``name[1]``, ``name[2]``; fields of structures are ``name.field``, those of arrays of
structures ``name[1].field``; where each of these has one number, ``name.field`` is a signal of all. The longer side of a matrix is
time; in Simulink's structure with time the side that has as many values as its time. What is no array of numbers (objects such as timetables, sparse matrices, cells) is left out by name.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import BLOCK, Log, LogBlock, Signal, by_reason, once


def open_mat(path: Path) -> Log:
    """Open a MAT log; see `polydraulic.measure.formats.logs.open_log`."""
    with path.open("rb") as file:
        head = file.read(520)
    if b"MATLAB 7.3" in head[:128] or b"\x89HDF" in (head[:4], head[512:516]):
        from polydraulic.measure.formats.mat.hdf import arrays_of_hdf as arrays_of
    else:
        from polydraulic.measure.formats.mat.v5 import arrays_of_v5 as arrays_of
    found = arrays_of(path)
    lengths = found.lengths
    if not lengths:
        found.close()
        why = f"; it has {by_reason(found.left_out)}" if found.left_out else ""
        raise InputError(f"{path}: the file has no numeric vectors or matrices{why}")
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
            try:
                values = {name: found.read(name, begun, end) for name in wanted}
                clock = found.read(time, begun, end) if time else None
            except Exception as error:  # h5py raises errors of many kinds on damaged files
                raise InputError(f"{path}: damaged after row {begun} of {wanted[0]!r} ({error})") from error
            text = {name: np.zeros(0, dtype=np.int64) for name in wanted}
            yield LogBlock(np.arange(begun, end) + 1, clock, values, text, end / total)

    return Log(path, signals, False, blocks, twice, found.close, left_out=found.left_out)
