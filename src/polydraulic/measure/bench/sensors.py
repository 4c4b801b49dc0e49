"""Sensors of a virtual test bench: what they read of a run, how accurately and how often. A TOML file."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.measure.channels import FARTHEST, duration, low_and_high, text
from polydraulic.measure.log_units import conversion, says_pressure
from polydraulic.names import checked_name
from polydraulic.parameters.deviations import TimedFault
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.faults import faulty_column
from polydraulic.parameters.keys import check_keys
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.tables import Table

_FILE = {"seed", "pause", "sensor"}
_SENSOR = {
    "column", "name", "unit", "raster", "noise", "offset", "drift", "resolution", "range", "delay", "lag", "dropout",
    "dropout_length",
}  # fmt: skip

_PARTING = ',"\n\r'


@dataclass(frozen=True)
class Sensor:
    """One sensor.

    Attributes
    ----------
    column : str
        Of the run.
    name : str
        In the log.
    unit : str
        Of the log; all that follows is in it.
    raster : float, s
        Between samples.
    noise : float
        Standard deviation of white noise.
    offset : float
        Constant error.
    drift : float
        Standard deviation of a random walk after an hour.
    resolution : float
        Step of the digits; 0 for none.
    low, high : float
        Range of the sensor; beyond it, it reads the end.
    delay : float, s
        Dead time.
    lag : float, s
        Time constant of a first-order lag.
    dropout : float
        Share of the time in which there is no value.
    dropout_length : float, s
        Mean length of a dropout; lengths are exponential.
    """

    column: str
    name: str
    unit: str
    raster: float
    noise: float = 0.0
    offset: float = 0.0
    drift: float = 0.0
    resolution: float = 0.0
    low: float = -inf
    high: float = inf
    delay: float = 0.0
    lag: float = 0.0
    dropout: float = 0.0
    dropout_length: float = 0.2


@dataclass(frozen=True)
class Bench:
    """All sensors, the seed of their errors, and the pause between two runs, s."""

    sensors: tuple[Sensor, ...]
    seed: int = 0
    pause: float = 5.0


def example_sensors(*, machine: LayoutMachine | str | Path = "cat215b") -> str:
    """Text of a file of sensors to begin with: all that machines are learnt from and run against, with every key explained.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of one
        Whose functions are measured.
    """
    text = (files("polydraulic.measure.bench") / "example_sensors.toml").read_text(encoding="utf-8")
    head, first, rest = text.partition("[[sensor]]")
    pattern, found = (first + rest).rstrip(), as_machine(machine)
    slides = {f.name for f in found.functions if found.link(f.moves).joint == "prismatic"}
    blocks = []
    for name in found.names:
        block = pattern.replace("FUNCTION", name)
        if name in slides:
            block = block.replace(
                f'"{name}.angle"\nunit = "deg"\nraster = "20 ms"\nnoise = 0.03',
                f'"{name}.position"\nunit = "mm"\nraster = "20 ms"\nnoise = 1.0',
            )
        blocks.append(block)
    return head + "\n\n".join(blocks) + "\n"


def load_sensors(path: str | Path) -> Bench:
    """Read the sensors of a virtual test bench.

    Parameters
    ----------
    path : str or Path
        A TOML file: optional ``seed`` and ``pause`` (``"5 s"``), and for each sensor a ``[[sensor]]`` with ``column``, ``unit``,
        ``raster``, and optional ``name``, ``noise``, ``offset``, ``drift``, ``resolution``, ``range``, ``delay``, ``lag``,
        ``dropout``, ``dropout_length``. Times are strings with a unit, all else are numbers in the sensor's unit.

    Raises
    ------
    InputError
        Unknown or missing key, unknown unit, a value that is not allowed: file, key, value.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"sensors {path}: no such file")
    data = read_toml(path)
    try:
        return _bench(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _bench(data: Any) -> Bench:
    check_keys(data, _FILE, {"sensor"})
    items = data["sensor"]
    if not isinstance(items, list) or not items:
        raise InputError("sensor must be a list of tables; begin each with [[sensor]]")
    sensors = tuple(_sensor(item, f"sensor {n}") for n, item in enumerate(items, 1))
    names = [sensor.name for sensor in sensors]
    twice = next((name for name in names if names.count(name) > 1 or name == "time"), None)
    if twice is not None:
        raise InputError(f"name {twice!r}: each sensor needs its own, other than 'time'")
    seed = data.get("seed", 0)
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError(f"seed = {briefly(seed)}: must be a whole number, at least 0")
    return Bench(sensors, seed, duration(data.get("pause", "5 s"), "pause"))


def _sensor(item: Any, where: str) -> Sensor:
    check_keys(item, _SENSOR, {"column", "unit", "raster"}, where)
    column = text(item["column"], f"column of {where}")
    where = f"sensor {item.get('name', column)!r}"
    if not isinstance(item["unit"], str):
        raise InputError(f"unit of {where} = {item['unit']!r}: must be a string, empty for plain numbers")
    try:
        conversion(item["unit"], kind=_kind(column))
    except InputError as error:
        raise InputError(f"unit of {where}: {error}") from error

    def number(key: str, least: float = 0.0, most: float = inf) -> float:
        value = item.get(key, 0.0)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= FARTHEST:
            raise InputError(f"{key} of {where} = {briefly(value)}: must be a finite number in the sensor's unit")
        if not least <= value <= most:
            raise InputError(f"{key} of {where} = {value!r}: must lie in [{least:g}, {most:g}]")
        return float(value)

    def seconds(key: str, default: str) -> float:
        return duration(item.get(key, default), f"{key} of {where}", low=0.0)

    low, high = low_and_high(item["range"], f"range of {where}") if "range" in item else (-inf, inf)
    return Sensor(
        column,
        _name(item.get("name", column), f"name of {where}"),
        item["unit"],
        duration(item["raster"], f"raster of {where}"),
        number("noise"),
        number("offset", least=-inf),
        number("drift"),
        number("resolution"),
        low,
        high,
        seconds("delay", "0 s"),
        seconds("lag", "0 s"),
        number("dropout", most=0.9),
        duration(item.get("dropout_length", "0.2 s"), f"dropout_length of {where}"),
    )


def _name(value: Any, where: str) -> str:
    """A name that stands in one line of a text log."""
    name = checked_name(text(value, where), where)
    if set(name) & set(_PARTING):
        raise InputError(
            f"{where} = {name!r}: must hold no comma, quote or end of line, which part the columns of a text log"
        )
    return name


def _kind(column: str) -> str:
    return "Pa" if says_pressure(column) else ""


class Reading:
    """What one sensor reads of runs that follow each other; its drift goes on from run to run.

    Parameters
    ----------
    sensor : Sensor
    rng : numpy Generator
    """

    def __init__(self, sensor: Sensor, rng: np.random.Generator) -> None:
        self.sensor, self.rng = sensor, rng
        self.conversion = conversion(sensor.unit, kind=_kind(sensor.column))
        self._drift = 0.0
        self._held: dict[tuple[str, str], float] = {}

    def check(self, run: Table) -> None:
        """Raise an InputError if the run has no such column, or it is not in this kind of unit."""
        s = self.sensor
        if s.column not in run.names:
            raise InputError(f"sensor {s.name!r}: the run has no column {s.column!r}; {_alike(s.column, run.names)}")
        if run.unit(s.column) != self.conversion.si:
            raise InputError(f"sensor {s.name!r} = {s.column} in {s.unit!r}: it is in {run.unit(s.column)}")

    def of(self, run: Table, faults: Sequence[TimedFault] = ()) -> tuple[np.ndarray, np.ndarray]:
        """Times since the start of the run and values in the sensor's unit, NaN where there is none.

        Parameters
        ----------
        run : Table
        faults : sequence of TimedFault
            Those of this column act on what the sensor would measure; its own errors come on top.
        """
        s, rng = self.sensor, self.rng
        time = np.arange(int(run["time"][-1] / s.raster * (1.0 + 1e-12)) + 1) * s.raster
        measured = faulty_column(s.column, run["time"], run[s.column], faults, self._held)
        truth = self._lagged(run["time"], self.conversion.from_si(measured))
        value = np.interp(time - s.delay, run["time"], truth)
        walk = self._drift + np.cumsum(rng.normal(0.0, s.drift * np.sqrt(s.raster / 3600.0), len(time)))
        self._drift = float(walk[-1])
        value = value + s.offset + walk + rng.normal(0.0, s.noise, len(time))
        value = np.clip(value, s.low, s.high)
        if s.resolution > 0.0:
            value = s.resolution * np.round(value / s.resolution)
        return time, np.where(self._lost(time), np.nan, value)

    def _lagged(self, time: np.ndarray, value: np.ndarray) -> np.ndarray:
        from scipy.signal import lfilter

        if self.sensor.lag == 0.0:
            return value
        keep = np.exp(-(time[1] - time[0]) / self.sensor.lag)
        return lfilter([1.0 - keep], [1.0, -keep], value, zi=[keep * value[0]])[0]

    def _lost(self, time: np.ndarray) -> np.ndarray:
        """Times without a value: gaps of exponential length, so many that their share of the time is as asked."""
        s, rng = self.sensor, self.rng
        lost = np.zeros(len(time), dtype=bool)
        if s.dropout == 0.0:
            return lost
        apart = s.dropout_length * (1.0 - s.dropout) / s.dropout
        n = int(2.0 * time[-1] / (apart + s.dropout_length)) + 20
        begins = np.cumsum(
            rng.exponential(apart, n) + np.concatenate([[0.0], (lengths := rng.exponential(s.dropout_length, n))[:-1]])
        )
        for begin, length in zip(begins, lengths, strict=True):
            if begin > time[-1]:
                break
            lost[np.searchsorted(time, begin) : np.searchsorted(time, begin + length)] = True
        return lost


def _alike(column: str, names: Sequence[str]) -> str:
    """Columns of the run that may have been meant: of the same owner, else of the same quantity, else all of them."""
    owner, _, quantity = column.partition(".")
    own = [name for name in names if name.partition(".")[0] == owner]
    same = [name for name in names if "." in name and name.partition(".")[2] == quantity]
    if own:
        return f"of {owner} it has {', '.join(own)}"
    if same:
        return f"{owner!r} is none of its functions and circuits; it has {', '.join(same)}"
    return f"it has {', '.join(names)}"
