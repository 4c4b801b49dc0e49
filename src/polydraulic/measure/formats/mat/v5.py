"""MAT files up to v7: SciPy reads one variable at a time, its columns wait in files."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.files import Scratch
from polydraulic.measure.formats.floats import as_floats
from polydraulic.measure.formats.mat.arrays import (
    CELL,
    COMPLEX,
    CUBE,
    DEEPEST,
    EMPTY,
    SPARSE,
    TEXTS,
    Arrays,
    axis_of_time,
    labels,
    object_of,
)
from polydraulic.measure.formats.mat.variables import variables_of

_LEFT_OUT = {"cell": CELL, "function": "a function", "sparse": SPARSE}
_LEFT_OUT |= dict.fromkeys(("object", "unknown"), object_of(""))


def arrays_of_v5(path: Path) -> Arrays:
    """Columns of numbers of a file."""
    from scipy import io

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of names that come twice
            listed = variables_of(path)
    except InputError:
        raise
    except Exception as error:  # SciPy raises errors of many kinds on damaged files
        raise InputError(f"{path}: cannot be read as a MAT log ({error})") from error
    # one variable in memory at a time: each signal goes to a file of its own, from which blocks are read
    scratch = Scratch()
    kept = _Kept(scratch)
    for name, shape, kind, object_kind in listed:
        if not name or name.startswith("__"):  # MATLAB's own bookkeeping
            continue
        if kind == "char":
            if shape[0] > 1:  # a single one is a remark
                kept.left_out[name] = TEXTS
            continue
        if kind == "opaque":
            kept.left_out[name] = object_of(object_kind)
        elif kind in _LEFT_OUT or 0 in shape:
            kept.left_out[name] = _LEFT_OUT.get(kind, EMPTY)
        else:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    read = io.loadmat(path, variable_names=[name], simplify_cells=True)
                kept.keep(name, read.get(name))
            except InputError:
                scratch.close()
                raise
            except Exception as error:
                scratch.close()
                raise InputError(f"{path}: variable {name!r} cannot be read ({error})") from error

    def read_part(name: str, begun: int, end: int) -> np.ndarray:
        return np.fromfile(kept.files[name], count=end - begun, offset=8 * begun)

    return Arrays(kept.lengths, kept.left_out, read_part, scratch.close)


class _Kept:
    """Columns in files of a folder."""

    def __init__(self, scratch: Scratch) -> None:
        self.scratch = scratch
        self.files: dict[str, Path] = {}
        self.lengths: dict[str, int] = {}
        self.left_out: dict[str, str] = {}

    def keep(self, name: str, item: Any, rows: int | None = None, deep: int = 0) -> None:
        """Write the columns of an item, and of what is in it."""
        if deep > DEEPEST:
            self.left_out[name] = f"more than {DEEPEST} structures in each other"
        elif isinstance(item, dict):
            time = item.get("time")
            own = time.size if isinstance(time, np.ndarray) and "signals" in item else rows
            for key, part in item.items():
                self.keep(f"{name}.{key}", part, own, deep + 1)
        elif isinstance(item, list) or (isinstance(item, np.ndarray) and item.dtype == object):
            parts = list(item) if isinstance(item, list) else item.ravel(order="F").tolist()
            if not parts or not all(isinstance(part, dict) for part in parts):
                self.left_out[name] = CELL if parts else EMPTY
                return
            for key in parts[0]:
                values = [part.get(key) for part in parts]
                if len(parts) > 1 and all(isinstance(v, int | float | np.number | np.bool_) for v in values):
                    self._array(f"{name}.{key}", np.array(values), rows)  # a number each: one row of a table each
                    parts = [{other: v for other, v in part.items() if other != key} for part in parts]
            for number, part in enumerate(parts, 1):
                self.keep(f"{name}[{number}]", part, rows, deep + 1)
        elif isinstance(item, np.ndarray):
            self._array(name, item, rows)
        elif hasattr(item, "nnz"):
            self.left_out[name] = SPARSE

    def _array(self, name: str, item: np.ndarray, rows: int | None) -> None:
        if item.dtype.kind not in "fiubc":
            if item.dtype.kind not in "US":
                self.left_out[name] = object_of("")
            elif item.size > 1:  # a single text is a remark
                self.left_out[name] = TEXTS
        elif item.size == 0:
            self.left_out[name] = EMPTY
        elif item.dtype.kind == "c":
            self.left_out[name] = COMPLEX
        elif item.size > 1:
            axis = axis_of_time(item.shape, rows)
            if axis is None:
                self.left_out[name] = CUBE
                return
            columns = np.moveaxis(item, axis, 0).reshape((item.shape[axis], -1), order="F")
            for number, label in enumerate(labels(name, columns.shape[1])):
                self.files[label] = self.scratch.folder / str(len(self.files))
                with self.scratch.writing():
                    as_floats(columns[:, number]).tofile(self.files[label])
                self.lengths[label] = len(columns)
