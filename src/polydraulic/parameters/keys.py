"""Which keys a table of a file may hold, and must; and what a file is by its keys."""

from collections.abc import Collection, Mapping
from typing import Any

from polydraulic.errors import InputError, briefly


def is_layout(data: Collection[str]) -> bool:
    """Whether a parameter file describes links, functions and circuits of its own."""
    return any(key in data for key in ("links", "functions", "circuits"))


def check_keys(data: Any, allowed: Collection[str], needed: Collection[str], where: str = "", file: str = "") -> None:
    """Check that `data` is a table with the keys that it needs, and no others.

    Parameters
    ----------
    data : Any
        What stands in the file.
    allowed, needed : collection of str
    where : str
        The table in words, or its path in the file; nothing for the file itself.
    file : str
        Name of the file, where the caller does not add it.

    Raises
    ------
    InputError
        It is no table, or has an unknown key, or lacks one: which, and what is allowed.
    """
    at = f"{file}: " if file else ""
    if not isinstance(data, Mapping):
        raise InputError(f"{at}{where or 'file'} must be a table, not {briefly(data)}")
    of = f" in {where}" if where else ""
    unknown = sorted(str(key) for key in data if key not in allowed)
    missing = sorted(key for key in needed if key not in data)
    if unknown:
        raise InputError(f"{at}unknown key {unknown[0]!r}{of}; allowed here: {sorted(allowed)}")
    if missing:
        raise InputError(f"{at}missing key {missing[0]!r}{of}; needed here: {sorted(needed)}")
