"""Parameter sets: by name or path, of whatever layout."""

from pathlib import Path
from typing import Any, Literal, NamedTuple, overload

from polydraulic.errors import InputError
from polydraulic.parameters.conditions import broken_conditions
from polydraulic.parameters.entries import build, find, read_toml
from polydraulic.parameters.keys import is_layout
from polydraulic.parameters.layout.load import build_layout
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.schema import LINKS, Machine

_SETS = Path(__file__).parent / "sets"


class Entry(NamedTuple):
    """One number of a parameter file, as written there."""

    key: str
    value: Any
    unit: str
    source: str


@overload
def load_machine(source: Literal["cat215b"]) -> Machine: ...
@overload
def load_machine(
    source: Literal["cat215b_bucket", "cat215b_crossover", "excavator_22t", "loader_crane", "wheel_loader"],
) -> LayoutMachine: ...
@overload
def load_machine(source: str | Path) -> Machine | LayoutMachine: ...
def load_machine(source: str | Path) -> Machine | LayoutMachine:
    """Load a parameter set.

    Parameters
    ----------
    source : str or Path
        Name of a set that comes with the package (``"cat215b"``), or the path of a TOML file.

    Returns
    -------
    Machine or LayoutMachine
        In SI units: the layout of cat215b, or one that the file describes by links, functions and circuits.

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
    machine = build(Machine, data, where="", path=path)
    broken = broken_conditions(machine)
    if broken:
        raise InputError(f"{path}: " + "; ".join(broken))
    return machine


def as_machine(machine: Machine | LayoutMachine | str | Path) -> Machine | LayoutMachine:
    """Return a machine that is given, or load the parameter set of that name or path."""
    return machine if isinstance(machine, Machine | LayoutMachine) else load_machine(machine)


def as_excavator(machine: Machine | LayoutMachine | str | Path) -> Machine:
    """Return a machine with the layout of cat215b, for what knows no other.

    Raises
    ------
    InputError
        A machine of another layout.
    """
    found = as_machine(machine)
    if isinstance(found, Machine):
        return found
    given = f"{found.title!r}" if isinstance(machine, LayoutMachine) else f"{machine}"
    raise InputError(
        f"{given} has the functions {', '.join(found.names)}; this works for the layout of 'cat215b' alone (swing, boom and stick on "
        "two pumps). Machines of other layouts can be checked, drawn, simulated, animated, recorded, replayed and exported"
    )


def load_layout(source: str | Path) -> LayoutMachine:
    """Load a machine that is described by links, functions and circuits.

    Raises
    ------
    InputError
        As `load_machine`, or if it is of the older form, whose layout is fixed.
    """
    machine = load_machine(source)
    if isinstance(machine, LayoutMachine):
        return machine
    raise InputError(f"{source}: has the older form, without [links], [functions] and [circuits]; its layout is fixed")


def machine_names() -> list[str]:
    """Names of the machines that come with the package."""
    return sorted(path.stem for path in _SETS.glob("*.toml"))


def machine_title(name: str | Path) -> str:
    """What a machine is, in a line: its title, or the first comment of its file."""
    path = find(name, _SETS, "parameter set")
    return str(read_toml(path).get("title", path.read_text(encoding="utf-8").partition("\n")[0].strip("# .")))


def machine_text(source: str | Path) -> str:
    """The file of a machine, as it is written."""
    return find(source, _SETS, "parameter set").read_text(encoding="utf-8")


def function_names(machine: Machine | LayoutMachine) -> tuple[str, ...]:
    """What an operator of a machine can move: the names of scenarios, recordings and columns."""
    return LINKS if isinstance(machine, Machine) else machine.names


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
