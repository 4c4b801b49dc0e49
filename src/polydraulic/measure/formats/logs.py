"""Open a log by the ending of its file."""

from collections.abc import Sequence
from pathlib import Path

from polydraulic.errors import InputError
from polydraulic.measure.formats.log import Log

ENDINGS = (
    ".csv",
    ".csv.gz",
    ".txt",
    ".tsv",
    ".parquet",
    ".mf4",
    ".mdf",
    ".dat",
    ".mat",
    ".blf",
    ".asc",
    ".mcap",
    ".db3",
    ".bag",
)
_BUS = (".mf4", ".blf", ".asc")
_SHEETS = (".xlsx", ".xls", ".xlsm", ".xlsb", ".ods")
_PACKED = (".zip", ".bz2", ".xz", ".7z", ".zst", ".tar", ".tgz", ".rar")
_OTHERS = dict.fromkeys((".h5", ".hdf5", ".hdf"), "HDF5 with a data set for each signal is read as .mat")
_OTHERS |= dict.fromkeys(
    (".feather", ".arrow", ".ipc"), "an Arrow file is written as .parquet by pyarrow.parquet.write_table"
)
_OTHERS |= {".log": "a text of columns is read as .csv, frames of a CAN bus as .asc or .blf"}
_OTHERS |= {".trc": "frames of a CAN bus are read as .asc or .blf", ".json": "write the rows as .csv"}
_BAGS = (".mcap", ".db3", ".bag")


def open_log(path: str | Path, *, dates: str | None = None, dbc: Sequence[str | Path] = ()) -> Log:
    """Open a log: CSV (plain or .gz), Parquet, MDF 3 or 4, MAT v5 or v7.3; a CAN bus log (MDF 4, BLF, ASC) with its databases; a ROS bag.

    Parameters
    ----------
    path : str or Path
        A CSV header may carry units as ``name [unit]``, or in a line of their own below it. Bags are a folder, or a file of it.
    dates : str, optional
        ``"dd/mm/yyyy"`` or ``"mm/dd/yyyy"``, for dates as text that can be read in two ways.
    dbc : sequence of str or Path, optional
        CAN databases that say what is in the frames of a bus log.

    Raises
    ------
    InputError
        No such file, another ending, a file that is not what its ending says.
    """
    path = Path(path)
    if path.is_dir() and any(path.glob("*.parquet")) and not (path / "metadata.yaml").exists():
        raise InputError(f"{path}: a folder of Parquet files: give these, as in {str(path / '*.parquet')!r}")
    if path.is_dir() and not dbc:
        from polydraulic.measure.formats.ros.bag_log import open_bag

        return open_bag(path)
    ending = next((e for e in ENDINGS if path.name.lower().endswith(e)), None)
    if ending is None:
        hint = "save the sheet as .csv" if path.suffix.lower() in _SHEETS else "a text of columns is read as .csv"
        hint = _OTHERS.get(path.suffix.lower(), hint)
        hint = "unpack it" if path.suffix.lower() in _PACKED else hint
        hint = "a text of columns that gzip packed is read as .csv.gz" if path.suffix.lower() == ".gz" else hint
        raise InputError(f"{path}: a log ends in one of {list(ENDINGS)}, not in {path.suffix!r}; {hint}")
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if dbc and ending not in _BUS:
        raise InputError(f"{path}: CAN databases go with a bus log, {', '.join(_BUS)}")
    if ending in _BUS[1:] and not dbc:
        raise InputError(
            f"{path}: a raw bus log (frames with identifiers and data bytes, no signals); give the CAN databases that say what is in "
            "them: --dbc FILE.dbc"
        )
    if dbc:
        from polydraulic.measure.formats.can.can_log import open_can

        return open_can(path, [Path(file) for file in dbc])
    if ending in _BAGS:
        from polydraulic.measure.formats.ros.bag_log import open_bag

        return open_bag(path)
    if ending == ".parquet":
        from polydraulic.measure.formats.parquet_log import open_parquet

        return open_parquet(path, dates)
    if ending in (".mf4", ".mdf") or (ending == ".dat" and not _is_text(path)):
        from polydraulic.measure.formats.mdf.mdf_log import open_mdf as opener
    elif ending == ".mat":
        from polydraulic.measure.formats.mat.mat_log import open_mat as opener
    else:
        from polydraulic.measure.formats.csv_log import open_csv

        return open_csv(path, dates)
    return opener(path)


def _is_text(path: Path) -> bool:
    """Whether a file begins as a text of columns; loggers call these ``.dat``, as MDF files are called, too."""
    with path.open("rb") as file:
        first = file.read(64)
    return bool(first) and not first.startswith((b"MDF ", b"UnFinMF")) and all(c >= 32 or c in b"\t\r\n" for c in first)
