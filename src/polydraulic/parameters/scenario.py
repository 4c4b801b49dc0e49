"""Scenarios: what the operator does, for how long, and what differs from the machine's parameter set.

A scenario file may change the pilots and the initial state of single links under ``[change.LINK...]``; the entries there
have the form of a parameter set. Links that are not listed under ``[voltage]`` get 0 V. A recording of all three joysticks is a
scenario as it is, and so is a random operator.
"""

from collections.abc import Collection
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.keys import check_keys
from polydraulic.parameters.load import build, find, read_quantity, read_toml
from polydraulic.parameters.operator import random_signals
from polydraulic.parameters.quantity import Quantity
from polydraulic.parameters.recording import ENDINGS, Recording
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.parameters.signals import Constant, Piecewise, Signal, Sine

_SCENARIOS = Path(__file__).parent / "scenarios"
_SECTIONS = {"title", "source", "duration", "locked", "voltage", "change"}
_CHANGEABLE = {"pilot", "initial"}
_RANDOM = "random:"
_TIME_NAMES = ("time", "zeit", "timestamp", "zeitstempel")  # of the column of the time in a recording
_TIME, _VOLT = Quantity("s"), Quantity("V")
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
    voltage : dict from link to Signal
        Joystick voltages; links left out get 0 V.
    locked : tuple of str
        Links that are held at their initial angle.
    changes : dict
        Partial parameter tree, as in a file, applied by `adapt`.
    """

    name: str
    duration: float
    voltage: dict[str, Signal]
    locked: tuple[str, ...] = ()
    title: str = ""
    changes: dict[str, Any] = field(default_factory=dict, repr=False)
    path: Path = field(default=Path("scenario"), repr=False)

    def adapt(self, machine: Machine) -> Machine:
        """Return the machine with this scenario's pilots and initial state."""
        return build(Machine, self.changes, where="change.", path=self.path, base=machine)

    def voltages(self, t: np.ndarray) -> np.ndarray:
        """Joystick voltages at the times `t`; shape (n_time, 3), links in the order of `LINKS`."""
        return np.column_stack([self.voltage.get(link, Constant())(t) for link in LINKS])


def load_scenario(source: str | Path) -> Scenario:
    """Load a scenario.

    Parameters
    ----------
    source : str or Path
        Name of a scenario that comes with the package (``"single_08"``); the path of a TOML file; the path of a recording,
        ``.csv``, ``.csv.gz``, ``.txt`` or ``.parquet``, with the columns ``time`` and ``swing``, ``boom``, ``stick`` or some of
        these (the others get 0 V), in s and V or in the units of the header, which starts at its first row; or ``"random:SEED"``, ``"random:SEED:SECONDS"`` for a `random_operator`.

    Raises
    ------
    InputError
        Unknown or missing key, wrong unit, value out of range, unreadable recording, times that do not rise.
    """
    if str(source).startswith(_RANDOM):
        return _random(str(source))
    if isinstance(source, str | Path) and str(source).lower().endswith(ENDINGS):
        return _recording(Path(source))
    path = find(source, _SCENARIOS, "scenario", ", of a .csv or .parquet recording, or random:SEED")
    data = read_toml(path)
    check_keys(data, _SECTIONS, {"title", "source", "duration", "voltage"}, file=str(path))
    duration = read_quantity(data["duration"], Quantity("s", above=0.0, high=inf), "duration", path)
    locked = data.get("locked", [])
    if not isinstance(locked, list) or any(link not in LINKS for link in locked):
        raise InputError(f"{path}: locked = {locked!r}: must be a list of {list(LINKS)}")
    check_keys(data["voltage"], LINKS, (), "voltage", str(path))
    signals = {link: _signal(item, f"voltage.{link}", path) for link, item in data["voltage"].items()}
    changes = data.get("change", {})
    check_keys(changes, LINKS, (), "change", str(path))
    for link, part in changes.items():
        check_keys(part, _CHANGEABLE, (), f"change.{link}", str(path))
    return Scenario(path.stem, duration, signals, tuple(locked), str(data["title"]), changes, path)


def as_scenario(scenario: Scenario | str | Path) -> Scenario:
    """Return a scenario that is given, or load the one of that name or path."""
    return scenario if isinstance(scenario, Scenario) else load_scenario(scenario)


def random_operator(
    seed: int, duration: float = 60.0, *, links: Collection[str] = LINKS, limit: float = 0.8
) -> Scenario:
    """Scenario of a random operator who moves all links as a hand could.

    Each joystick by itself: a move to one side (seven times in ten the other one than before) holds one to three levels, each
    for 0.4 s and an exponential time of mean 0.6 s; the first lies between 0.4 and 1 of the limit, the next at 0.6 to 1.3 of
    the one before. After two moves in three the joystick rests for 0.2 s and an exponential time of mean 0.8 s; otherwise the
    next move follows at once. Two lags of 0.08 s smooth all of this. A longer run begins like a shorter one.

    Parameters
    ----------
    seed : int
    duration : float, s
    links : collection of str
        Links to move; the others are locked.
    limit : float, V
        No voltage is beyond it.

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
    signals: dict[str, Signal] = {**random_signals(seed, duration, links=links, limit=limit)}
    locked = tuple(link for link in LINKS if link not in links)
    return Scenario(f"{_RANDOM}{seed}", duration, signals, locked, f"Random operator, seed {seed}")


def scenario_names() -> list[str]:
    """Names of the scenarios that come with the package."""
    return sorted(path.stem for path in _SCENARIOS.glob("*.toml"))


def _signal(item: Any, where: str, path: Path) -> Signal:
    kind = item.get("kind") if isinstance(item, dict) else None
    if not isinstance(kind, str) or kind not in _KINDS:
        raise InputError(f"{path}: {where}.kind = {kind!r}: must be one of {sorted(_KINDS)}")
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


def _recording(path: Path) -> Scenario:
    recording = Recording(path)
    time = next((name for name in recording.names if name.lower() in _TIME_NAMES), "time")
    links = [link for link in LINKS if link in recording.names]
    unknown = [name for name in recording.names if name not in LINKS and name != time]
    missing = [link for link in LINKS if link not in links]
    if missing and (unknown or not links):  # a link misspelt would rest unseen
        raise InputError(
            f"{path}: no column {missing[0]!r}; the table has {recording.names}, of which {unknown} are no link; leave these out, "
            'or name columns in a scenario file with kind = "table"'
        )
    signals = _recorded(recording, time, links)
    seconds = signals[0].time - signals[0].time[0]
    if len(seconds) < 2:
        raise InputError(f"{path}: a recording needs two rows at least")
    moved: dict[str, Signal] = {link: Piecewise(seconds, s.voltage) for link, s in zip(links, signals, strict=True)}
    title = f"Recording of {seconds[-1]:g} s"
    title += f"; of {', '.join(links)} alone" if missing else ""
    title += f"; not used: {', '.join(unknown)}" if unknown else ""
    return Scenario(path.stem, float(seconds[-1]), moved, title=title, path=path)


def _random(source: str) -> Scenario:
    seed, _, seconds = source.removeprefix(_RANDOM).partition(":")
    try:
        return random_operator(int(seed), float(seconds) if seconds else 60.0)
    except ValueError as error:
        reason = f": {error}" if isinstance(error, InputError) else ""
        raise InputError(
            f"scenario {source!r}: must be random:SEED or random:SEED:SECONDS, for example random:42:120{reason}"
        ) from error
