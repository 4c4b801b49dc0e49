"""Scenarios: what the operator does, for how long, and what differs from the machine's parameter set.

A scenario file may change the pilots and the initial state of single links under ``[change.LINK...]``; the entries there
have the form of a parameter set. Links that are not listed under ``[voltage]`` get 0 V.
"""

from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.load import build, find, read_quantity, read_toml
from polydraulic.parameters.schema import LINKS, Machine, Quantity
from polydraulic.parameters.signals import Constant, Piecewise, Signal, Sine
from polydraulic.tables import read_table

_SCENARIOS = Path(__file__).parent / "scenarios"
_SECTIONS = {"title", "source", "duration", "locked", "voltage", "change"}
_CHANGEABLE = {"pilot", "initial"}
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
        Name of a scenario that comes with the package (``"single_08"``), or the path of a TOML file.

    Raises
    ------
    InputError
        Unknown or missing key, wrong unit, value out of range, unreadable recording.
    """
    path = find(source, _SCENARIOS, "scenario")
    data = read_toml(path)
    _keys(data, _SECTIONS, {"title", "source", "duration", "voltage"}, "", path)
    duration = read_quantity(data["duration"], Quantity("s", above=0.0, high=inf), "duration", path)
    locked = data.get("locked", [])
    if not isinstance(locked, list) or any(link not in LINKS for link in locked):
        raise InputError(f"{path}: locked = {locked!r}: must be a list of {list(LINKS)}")
    _keys(data["voltage"], set(LINKS), set(), "voltage.", path)
    signals = {link: _signal(item, f"voltage.{link}", path) for link, item in data["voltage"].items()}
    changes = data.get("change", {})
    _keys(changes, set(LINKS), set(), "change.", path)
    for link, part in changes.items():
        _keys(part, _CHANGEABLE, set(), f"change.{link}.", path)
    return Scenario(path.stem, duration, signals, tuple(locked), str(data["title"]), changes, path)


def scenario_names() -> list[str]:
    """Names of the scenarios that come with the package."""
    return sorted(path.stem for path in _SCENARIOS.glob("*.toml"))


def _keys(data: Any, allowed: set[str], needed: set[str], where: str, path: Path) -> None:
    if not isinstance(data, dict):
        raise InputError(f"{path}: {where or 'file'} must be a table, not {data!r}")
    unknown, missing = sorted(set(data) - allowed), sorted(needed - set(data))
    if unknown:
        raise InputError(f"{path}: unknown key {where}{unknown[0]}; allowed here: {sorted(allowed)}")
    if missing:
        raise InputError(f"{path}: missing key {where}{missing[0]}; needed here: {sorted(needed)}")


def _signal(item: Any, where: str, path: Path) -> Signal:
    kind = item.get("kind") if isinstance(item, dict) else None
    if kind not in _KINDS:
        raise InputError(f"{path}: {where}.kind = {kind!r}: must be one of {sorted(_KINDS)}")
    names = _KINDS[kind]
    _keys(item, names | {"kind"}, names, f"{where}.", path)
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
        table = read_table(path.parent / str(item["file"]), [time, voltage])
        for name, unit in ((time, "s"), (voltage, "V")):
            if table.unit(name) not in ("", unit):
                raise InputError(f"column {name!r} has unit {table.unit(name)!r}; it must be {unit!r}")
        return Piecewise(table[time], table[voltage])
    except InputError as error:
        if str(path) in str(error):
            raise
        raise InputError(f"{path}: {where}: {error}") from error
