"""Parameter sets: by name or path, of whatever layout."""

from pathlib import Path
from typing import Any, NamedTuple

from polydraulic.errors import InputError
from polydraulic.parameters.entries import find, read_toml
from polydraulic.parameters.keys import is_layout
from polydraulic.parameters.layout.load import build_layout
from polydraulic.parameters.layout.older_form import build_older, is_older
from polydraulic.parameters.layout.schema import LayoutMachine

_SETS = Path(__file__).parent / "sets"


class Entry(NamedTuple):
    """One number of a parameter file, as written there."""

    key: str
    value: Any
    unit: str
    source: str


def load_machine(source: str | Path) -> LayoutMachine:
    """Load a parameter set.

    Parameters
    ----------
    source : str or Path
        Name of a set that comes with the package (``"cat215b"``), or the path of a TOML file: one that describes links, functions and
        circuits, or one of the older form, three links on two pumps.

    Returns
    -------
    LayoutMachine
        In SI units.

    Raises
    ------
    InputError
        Unknown or missing key, wrong unit, value out of range or not finite: file, key, value and what is allowed.
    """
    path = find(source, _SETS, "parameter set")
    data = read_toml(path)
    if is_layout(data):
        return build_layout(data, path)
    if {"duration", "voltage"} <= set(data):
        raise InputError(f"{path}: is a scenario, not a machine; run it by `polydraulic simulate {path}`")
    if not is_older(data):
        raise InputError(
            f"{path}: is no machine, for it has no [links], [functions] and [circuits]; "
            "`polydraulic machine new FILE.toml` writes one to begin with"
        )
    return build_older(data, path)


def as_machine(machine: LayoutMachine | str | Path) -> LayoutMachine:
    """Return a machine that is given, or load the parameter set of that name or path."""
    return machine if isinstance(machine, LayoutMachine) else load_machine(machine)


def machine_names() -> list[str]:
    """Names of the machines that come with the package."""
    return sorted(path.stem for path in _SETS.glob("*.toml"))


def machine_title(name: str | Path) -> str:
    """What a machine is, in a line: its title, or the first comment of its file."""
    path = find(name, _SETS, "parameter set")
    return str(read_toml(path).get("title", path.read_text(encoding="utf-8-sig").partition("\n")[0].strip("# .")))


def machine_path(source: str | Path) -> Path:
    """The file of a machine that is given by its name or path."""
    return find(source, _SETS, "parameter set")


def machine_text(source: str | Path) -> str:
    """The file of a machine, as it is written."""
    return find(source, _SETS, "parameter set").read_text(encoding="utf-8-sig")


def machine_entries(source: str | Path) -> list[Entry]:
    """Every number of a parameter set as its file gives it, with its source: for tables and documentation."""
    found: list[Entry] = []

    def walk(tree: dict[str, Any], where: str) -> None:
        for key, item in tree.items():
            if not isinstance(item, dict):
                continue  # words such as a title
            if "value" in item:
                found.append(Entry(where + key, item["value"], item.get("unit", ""), item["source"]))
            else:
                walk(item, f"{where}{key}.")

    walk(read_toml(find(source, _SETS, "parameter set")), "")
    return found
