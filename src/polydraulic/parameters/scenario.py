"""Scenarios: what the operator does, for how long, and what differs from the machine's parameter set.

A scenario file may change the pilots and the initial state of single links under ``[change.LINK...]``; the entries there
have the form of a parameter set. Links that are not listed under ``[voltage]`` get 0 V. A recording of all three joysticks is a
scenario as it is, and so is a random operator. ``machine`` says which machine a file is for, if that is not cat215b.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import cache
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.parameters.deviations import ScheduledFault, size_unit
from polydraulic.parameters.entries import find, read_quantity, read_toml
from polydraulic.parameters.keys import check_keys, is_layout
from polydraulic.parameters.loads import Loads, read_loads
from polydraulic.parameters.operator import random_signals
from polydraulic.parameters.quantity import Quantity
from polydraulic.parameters.recording import ENDINGS, Recording
from polydraulic.parameters.signals import Constant, Piecewise, Signal, Sine

_SCENARIOS = Path(__file__).parent / "scenarios"
_SETS = Path(__file__).parent / "sets"
_SECTIONS = {"title", "machine", "source", "duration", "locked", "voltage", "change", "force", "payload", "faults"}
_USUAL_MACHINE = "cat215b"
_CHANGEABLE = {"pilot", "initial"}
_RANDOM = "random:"
_RANDOM_USUAL = ("60", "0.8")  # s and V
_TIME_NAMES = ("time", "zeit", "timestamp", "zeitstempel")  # of the column of the time in a recording
_TIME, _VOLT = Quantity("s"), Quantity("V")
_FAULT = ("size", "begin", "end", "growth")
_KINDS = {
    "sine": {"amplitude", "omega"},
    "constant": {"voltage"},
    "piecewise": {"time", "voltage"},
    "table": {"file", "time_column", "voltage_column"},
}


@dataclass(frozen=True)
class Scenario:
    """A run to simulate.

    Attributes
    ----------
    name, title : str
    duration : float, s
    voltage : dict from function to Signal
        Joystick voltages; functions left out get 0 V.
    locked : tuple of str
        Functions whose joints are held at their initial position.
    changes : dict
        Pilots and initial states by function, as in a file.
    loads : Loads
        What acts at the tip.
    faults : tuple of ScheduledFault
        What breaks, and when.
    """

    name: str
    duration: float
    voltage: dict[str, Signal]
    locked: tuple[str, ...] = ()
    title: str = ""
    changes: dict[str, Any] = field(default_factory=dict, repr=False)
    path: Path = field(default=Path("scenario"), repr=False)
    loads: Loads = field(default_factory=Loads, repr=False)
    faults: tuple[ScheduledFault, ...] = field(default=(), repr=False)

    def voltages(self, t: np.ndarray, functions: Sequence[str] | None = None) -> np.ndarray:
        """Joystick voltages at the times `t`; shape (n_time, n_function), functions in their order, those of cat215b if not given."""
        return np.column_stack([self.voltage.get(name, Constant())(t) for name in functions or usual_functions()])


def load_scenario(source: str | Path, *, functions: Sequence[str] | None = None) -> Scenario:
    """Load a scenario.

    Parameters
    ----------
    source : str or Path
        Name of a scenario that comes with the package (``"single_08"``); the path of a TOML file; the path of a recording,
        ``.csv``, ``.csv.gz``, ``.txt`` or ``.parquet``, with the columns ``time`` and ``swing``, ``boom``, ``stick`` or some of
        these (the others get 0 V), in s and V or in the units of the header, which starts at its first row; or ``"random:SEED"``, ``"random:SEED:SECONDS"``,
        ``"random:SEED:SECONDS:VOLTS"`` for a `random_operator`.
    functions : sequence of str, optional
        Of the machine that is to do it; those of the machine that the file is for (`scenario_machine`) if not given.

    Raises
    ------
    InputError
        A scenario for another machine, unknown or missing key, wrong unit, value out of range, unreadable recording, times that do
        not rise.
    """
    if str(source).startswith(_RANDOM):
        return _random(str(source), functions or usual_functions())
    if _is_recording(source):
        return _recording(Path(source), functions or usual_functions())
    path, data = _read(source)
    if is_layout(data) or {"pumps", "geometry"} <= set(data):
        raise InputError(
            f"{path}: is a machine, not a scenario; try it by `polydraulic machine check {path}`, and run it by "
            f"`polydraulic simulate random:1:10 --machine {path}`"
        )
    check_keys(data, _SECTIONS, {"title", "source", "duration", "voltage"}, file=str(path))
    for key in ("title", "source"):
        if not isinstance(data[key], str):
            raise InputError(f"{path}: {key} = {briefly(data[key])}: must be a string")
    own = _functions_of(_machine_of(data, path))
    functions = functions or own
    named = [data[key] for key in ("voltage", "change", "locked") if isinstance(data.get(key), dict | list)]
    moved = {name for part in named for name in part if isinstance(name, str)}
    says = "machine" in data or path.parent == _SCENARIOS
    if says and moved <= set(own) and not moved <= set(functions):
        raise InputError(
            f"{path}: is for the machine {_machine_of(data, path)!r}, which is moved by {', '.join(own)}; "
            f"this one is moved by {', '.join(functions)}"
        )
    duration = read_quantity(data["duration"], Quantity("s", above=0.0, high=inf), "duration", path)
    locked = data.get("locked", [])
    if not isinstance(locked, list) or any(link not in functions for link in locked):
        raise InputError(f"{path}: locked = {briefly(locked)}: must be a list of {list(functions)}")
    unknown = [name for name in data["voltage"] if name not in functions] if isinstance(data["voltage"], dict) else []
    if unknown:
        assumed = (
            f", which {_USUAL_MACHINE} is moved by, as the file names no machine"
            if not says and functions == own
            else ""
        )
        raise InputError(f"{path}: unknown key {unknown[0]!r} in voltage; allowed here: {list(functions)}{assumed}")
    check_keys(data["voltage"], functions, (), "voltage", str(path))
    signals = {link: _signal(item, f"voltage.{link}", path) for link, item in data["voltage"].items()}
    changes = data.get("change", {})
    check_keys(changes, functions, (), "change", str(path))
    for link, part in changes.items():
        check_keys(part, _CHANGEABLE, (), f"change.{link}", str(path))
    loads, faults = read_loads(data, path), _faults(data.get("faults", []), path)
    return Scenario(path.stem, duration, signals, tuple(locked), data["title"], changes, path, loads, faults)


def as_scenario(scenario: Scenario | str | Path, functions: Sequence[str]) -> Scenario:
    """Return a scenario that is given, or load the one of that name or path, for a machine with these functions.

    Raises
    ------
    InputError
        As `load_scenario`, or if a scenario that is given moves, locks or changes what the machine does not have.
    """
    if not isinstance(scenario, Scenario):
        return load_scenario(scenario, functions=functions)
    unknown = [name for name in (*scenario.voltage, *scenario.locked, *scenario.changes) if name not in functions]
    if unknown:
        raise InputError(
            f"scenario {scenario.name!r} names {unknown[0]!r}, which the machine does not have; it has {list(functions)}"
        )
    return scenario


def random_operator(
    seed: int,
    duration: float = 60.0,
    *,
    links: Collection[str] | None = None,
    limit: float = 0.8,
    functions: Sequence[str] | None = None,
) -> Scenario:
    """Scenario of a random operator who moves all joints as a hand could.

    Each joystick by itself: a move to one side (seven times in ten the other one than before) holds one to three levels, each
    for 0.4 s and an exponential time of mean 0.6 s; the first lies between 0.4 and 1 of the limit, the next at 0.6 to 1.3 of
    the one before. After two moves in three the joystick rests for 0.2 s and an exponential time of mean 0.8 s; otherwise the
    next move follows at once. Two lags of 0.08 s smooth all of this. A longer run begins like a shorter one.

    Parameters
    ----------
    seed : int
    duration : float, s
    links : collection of str, optional
        Functions to move, all if not given; the others are locked.
    limit : float, V
        No voltage is beyond it.
    functions : sequence of str
        That the machine has; those of cat215b if not given.

    Raises
    ------
    InputError
        If one of these is not usable.

    Examples
    --------
    >>> scenario = random_operator(42, 10.0)
    >>> scenario.name, scenario.voltages(np.array([0.0, 5.0])).shape
    ('random:42', (2, 3))
    """
    functions = functions or usual_functions()
    moved = functions if links is None else links
    signals: dict[str, Signal] = {**random_signals(seed, duration, links=moved, limit=limit, functions=functions)}
    locked = tuple(name for name in functions if name not in moved)
    return Scenario(f"{_RANDOM}{seed}", duration, signals, locked, f"Random operator, seed {seed}")


def scenario_names(machine: str | None = None) -> list[str]:
    """Names of the scenarios that come with the package: all of them, or those for a machine."""
    names = sorted(path.stem for path in _SCENARIOS.glob("*.toml"))
    return [name for name in names if machine is None or scenario_machine(name) == machine]


def scenario_machine(source: str | Path) -> str:
    """Name or file of the machine that a scenario is for: what its file says, cat215b where nothing does.

    Parameters
    ----------
    source : str or Path
        What `load_scenario` takes.

    Raises
    ------
    InputError
        A scenario that cannot be read.
    """
    if str(source).startswith(_RANDOM) or _is_recording(source):
        return _USUAL_MACHINE
    path, data = _read(source)
    return _machine_of(data, path)


def scenario_files(source: str | Path) -> list[Path]:
    """Files that a scenario is read from: a recording, or a TOML file and the tables that it names.

    Parameters
    ----------
    source : str or Path
        What `load_scenario` takes.

    Raises
    ------
    InputError
        A scenario that cannot be read.
    """
    if str(source).startswith(_RANDOM):
        return []
    if _is_recording(source):
        return [Path(source)]
    path, data = _read(source)
    voltage = data.get("voltage")
    signals = voltage.values() if isinstance(voltage, dict) else ()
    tables = [item["file"] for item in signals if isinstance(item, dict) and isinstance(item.get("file"), str)]
    return [path, *(path.parent / table for table in tables)]


def _read(source: str | Path) -> tuple[Path, dict[str, Any]]:
    path = find(source, _SCENARIOS, "scenario", ", of a .csv or .parquet recording, or random:SEED")
    return path, read_toml(path)


def _is_recording(source: str | Path) -> bool:
    return isinstance(source, str | Path) and str(source).lower().endswith(ENDINGS)


def _machine_of(data: dict[str, Any], path: Path) -> str:
    machine = data.get("machine", _USUAL_MACHINE)
    if not isinstance(machine, str):
        raise InputError(
            f"{path}: machine = {machine!r}: must be the name of a machine, or a .toml file beside this one"
        )
    return str(path.parent / machine) if machine.endswith(".toml") else machine


@cache
def usual_functions() -> tuple[str, ...]:
    """What cat215b is moved by."""
    return _functions_of(_USUAL_MACHINE)


def _functions_of(machine: str) -> tuple[str, ...]:
    """What a machine is moved by, as its file names it; one of the older form as cat215b."""
    named = read_toml(find(machine, _SETS, "parameter set")).get("functions")
    return tuple(named) if isinstance(named, dict) else usual_functions()


def _faults(items: Any, path: Path) -> tuple[ScheduledFault, ...]:
    """Faults of a file: ``[[faults]]`` with a name, and size, begin, end and growth as quantities."""
    if not isinstance(items, list):
        raise InputError(f"{path}: faults = {briefly(items)}: must be a list of tables; begin each with [[faults]]")
    found = []
    for number, item in enumerate(items, 1):
        where = f"faults {number}"
        check_keys(item, ("name", *_FAULT), ("name",), where, str(path))
        if not isinstance(item["name"], str):
            raise InputError(f"{path}: {where}.name = {briefly(item['name'])}: must be a string")
        given: dict[str, Any] = {}
        for key in (key for key in _FAULT if key in item):
            kind = Quantity(size_unit(item["name"])) if key == "size" else _TIME
            given[key] = read_quantity(item[key], kind, f"{where}.{key}", path)
        try:
            found.append(ScheduledFault(item["name"], **given))
        except InputError as error:
            raise InputError(f"{path}: {where}: {error}") from error
    return tuple(found)


def _signal(item: Any, where: str, path: Path) -> Signal:
    kind = item.get("kind") if isinstance(item, dict) else None
    if not isinstance(kind, str) or kind not in _KINDS:
        raise InputError(f"{path}: {where}.kind = {briefly(kind)}: must be one of {sorted(_KINDS)}")
    names = _KINDS[kind]
    check_keys(item, names | {"kind"}, names, where, str(path))
    try:
        if kind == "sine":
            amplitude = read_quantity(item["amplitude"], _VOLT, f"{where}.amplitude", path)
            return Sine(amplitude, read_quantity(item["omega"], Quantity("rad/s"), f"{where}.omega", path))
        if kind == "constant":
            return Constant(read_quantity(item["voltage"], _VOLT, f"{where}.voltage", path))
        if kind == "piecewise":
            time = read_quantity(item["time"], _TIME, f"{where}.time", path, size=-1)
            return Piecewise(
                np.array(time), np.array(read_quantity(item["voltage"], _VOLT, f"{where}.voltage", path, -1))
            )
        time, voltage = str(item["time_column"]), str(item["voltage_column"])
        return _recorded(Recording(path.parent / str(item["file"])), time, [voltage])[0]
    except InputError as error:
        if str(path) in str(error):
            raise
        raise InputError(f"{path}: {where}: {error}") from error


def _recorded(recording: Recording, time: str, voltages: list[str]) -> list[Piecewise]:
    """Signals from the columns of a recording, in SI; a column without a unit is in s or V."""
    seconds, *volts = recording.columns(time, voltages)
    try:
        return [Piecewise(seconds, values) for values in volts]
    except InputError as error:
        raise InputError(f"{recording.path}: {error}") from error


def _recording(path: Path, functions: Sequence[str]) -> Scenario:
    recording = Recording(path)
    time = next((name for name in recording.names if name.lower() in _TIME_NAMES), "time")
    links = [link for link in functions if link in recording.names]
    unknown = [name for name in recording.names if name not in functions and name != time]
    missing = [link for link in functions if link not in links]
    if missing and (unknown or not links):  # a link misspelt would rest unseen
        raise InputError(
            f"{path}: no column {missing[0]!r}; the table has {recording.names}, and the machine is moved by {', '.join(functions)}; name "
            'columns by these, or in a scenario file with kind = "table"'
            + (f"; leave out {', '.join(unknown)}" if unknown and links else "")
        )
    signals = _recorded(recording, time, links)
    seconds = signals[0].time - signals[0].time[0]
    if len(seconds) < 2:
        raise InputError(f"{path}: a recording needs at least two rows")
    moved: dict[str, Signal] = {link: Piecewise(seconds, s.voltage) for link, s in zip(links, signals, strict=True)}
    title = f"Recording of {seconds[-1]:g} s"
    title += f"; of {', '.join(links)} alone" if missing else ""
    title += f"; not used: {', '.join(unknown)}" if unknown else ""
    return Scenario(path.stem, float(seconds[-1]), moved, title=title, path=path)


def _random(source: str, functions: Sequence[str]) -> Scenario:
    seed, *more = source.removeprefix(_RANDOM).split(":")
    try:
        seconds, limit = (float(text) for text in [*more, *_RANDOM_USUAL[len(more) :]])
        return random_operator(int(seed), seconds, limit=limit, functions=functions)
    except ValueError as error:
        reason = f": {error}" if isinstance(error, InputError) else ""
        raise InputError(
            f"scenario {source!r}: must be random:SEED or random:SEED:SECONDS, or random:SEED:SECONDS:VOLTS for another limit, for example random:42:120{reason}"
        ) from error
