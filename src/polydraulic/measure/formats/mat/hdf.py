"""MAT files of v7.3: HDF5, of which MATLAB's attributes say what an item is."""

from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
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
from polydraulic.measure.log_units import need

_NUMBERS = {"double", "single", "logical"} | {f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64)}


def arrays_of_hdf(path: Path) -> Arrays:
    """Columns of numbers of a file."""
    library = need("h5py")
    try:
        file = library.File(path, "r")
    except OSError as error:
        raise InputError(f"{path}: cannot be read as a MAT log ({error})") from error
    kept = _Kept(library, file)
    try:
        kept.members("", file, None, 0)
    except Exception as error:  # h5py raises errors of many kinds on damaged files
        file.close()
        raise InputError(f"{path}: cannot be read as a MAT log ({error})") from error

    def read(name: str, begun: int, end: int) -> np.ndarray:
        item, axis, place = kept.where[name]
        part = item[(*place[:axis], slice(begun, end), *place[axis:])]
        return as_floats(part)

    return Arrays(kept.lengths, kept.left_out, read, file.close)


class _Kept:
    """Columns by name: the dataset, its axis of time, and the place on the others."""

    def __init__(self, library: Any, file: Any) -> None:
        self.library, self.file = library, file
        self.where: dict[str, tuple[Any, int, tuple[int, ...]]] = {}
        self.lengths: dict[str, int] = {}
        self.left_out: dict[str, str] = {}
        self._looked_at: set[int] = set()

    def members(self, name: str, group: Any, rows: int | None, deep: int) -> None:
        """Look at what is in a structure."""
        if self._again(name, group):
            return
        time = group.get("time") if "signals" in group else None
        if isinstance(time, self.library.Dataset):
            rows = int(time.size)
        for key in group:
            link = group.get(key, getlink=True)
            if key.startswith("#") or not isinstance(link, self.library.HardLink):
                continue  # MATLAB's own bookkeeping; links to other files are not followed
            label = key.encode("utf-8", "replace").decode()
            self.keep(f"{name}.{label}" if name else label, group[key], rows, deep)

    def keep(self, name: str, item: Any, rows: int | None, deep: int) -> None:
        """Note the columns of an item, and of what is in it."""
        kind = _kind(item)
        if deep > DEEPEST:
            self.left_out[name] = f"more than {DEEPEST} structures in each other"
        elif "MATLAB_sparse" in item.attrs:
            self.left_out[name] = SPARSE
        elif "MATLAB_object_decode" in item.attrs or kind not in {"", "struct", "cell", "char", *_NUMBERS}:
            self.left_out[name] = object_of(kind)
        elif int(np.ravel(item.attrs.get("MATLAB_empty", 0))[0]):
            if kind != "char":
                self.left_out[name] = EMPTY
        elif isinstance(item, self.library.Group):
            self.members(name, item, rows, deep + 1)
        elif kind == "cell":
            self.left_out[name] = CELL
        elif isinstance(item, self.library.Dataset) and kind != "char":
            self._dataset(name, item, rows, deep)
        elif kind == "char" and len(item.shape) == 2 and min(item.shape) > 1:  # a single text is a remark
            self.left_out[name] = TEXTS

    def _again(self, name: str, item: Any) -> bool:
        """Whether an item was looked at before: one that holds itself would never come to an end."""
        place = self.library.h5o.get_info(item.id).addr
        if place in self._looked_at:
            self.left_out[name] = "the same as another structure"
            return True
        self._looked_at.add(place)
        return False

    def _dataset(self, name: str, item: Any, rows: int | None, deep: int) -> None:
        if self.library.check_ref_dtype(item.dtype) is self.library.Reference:  # a field of an array of structures
            if self._again(name, item):
                return
            of, _, field = name.rpartition(".")
            references = np.ravel(item[()].T, order="F")
            if len(references) > 1 and (column := self._numbers(references)) is not None:
                self.where[name], self.lengths[name] = (column, 0, ()), len(column)
                return
            for number, reference in enumerate(references, 1):
                label = f"{of}[{number}].{field}" if of else f"{field}[{number}]"
                if reference:
                    self.keep(label, self.file[reference], rows, deep + 1)
        elif item.dtype.names is not None:
            self.left_out[name] = COMPLEX if item.dtype.names == ("real", "imag") else "a record"
        elif item.dtype.kind not in "fiub":
            return
        elif item.size in (0, None):
            self.left_out[name] = EMPTY
        elif item.size > 1:
            shape = item.shape[::-1]  # MATLAB's order
            axis = axis_of_time(shape, rows)
            if axis is None:
                self.left_out[name] = CUBE
                return
            others = tuple(n for k, n in enumerate(shape) if k != axis)
            for label, place in zip(labels(name, int(np.prod(others))), np.ndindex(others[::-1]), strict=True):
                self.where[label] = (item, len(shape) - 1 - axis, place)
                self.lengths[label] = shape[axis]

    def _numbers(self, references: np.ndarray) -> np.ndarray | None:
        """A number of each reference, as of an array of structures that are one row of a table each; None if there are others."""
        found = np.empty(len(references))
        for k, reference in enumerate(references):
            part = self.file[reference] if reference else None
            if not isinstance(part, self.library.Dataset) or part.size != 1 or part.dtype.kind not in "fiub":
                return None
            if "MATLAB_empty" in part.attrs or _kind(part) not in {"", *_NUMBERS}:
                return None
            found[k] = float(np.ravel(part[()])[0])
        return found


def _kind(item: Any) -> str:
    """Class that MATLAB gave an item; empty if none."""
    kind = item.attrs.get("MATLAB_class", b"")
    return kind.decode("utf-8", "replace") if isinstance(kind, bytes) else str(kind)
