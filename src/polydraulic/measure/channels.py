"""The channel map: what each channel of a log is, as a TOML file that is checked before a log is opened."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

from polydraulic.columns.timestamps import ORDERS
from polydraulic.errors import InputError, briefly
from polydraulic.measure.columns_made import RATES, FlowChannel, RateChannel
from polydraulic.measure.log_units import conversion, quantity, says_pressure
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.keys import check_keys
from polydraulic.unit_table import ATMOSPHERE, KINDS
from polydraulic.units import Conversion, unit_kind

ROLES = ("input", "output", "time", "ignore")
BETWEEN = ("linear", "hold")
RESERVED = ("time", "segment", "missing")  # columns that imported tables have
SHORTEST, LONGEST = 1e-6, 1e5  # s, of rasters
FARTHEST = 1e100  # of ranges: differences and squares are numbers
THINNEST, DENSEST = 0.3e5, 1.2e5  # Pa, of atmospheres: from the highest mountain to the deepest mine
_NEARLY = 1.0 - 1e-9  # three times 0.1 s are more than 0.3 s in floats
_SI_OF_KIND = {kind.name: kind.si for kind in KINDS}
_MAP = {"raster", "interval", "atmosphere", "channel", "flow", "derivative"}
_CHANNEL = {"source", "name", "role", "kind", "unit", "raster", "between", "range", "sign", "dates"}
_DERIVATIVE = {"name", "of", "window", "role"}
_FLOW = {"name", "position", "area", "pressure", "compliance", "window", "role"}


@dataclass(frozen=True)
class Channel:
    """One channel of a log.

    Attributes
    ----------
    source : str
        Its name in the log.
    name : str
        Its column in the table.
    role : str
        One of `ROLES`.
    unit : str
        Of the numbers in the log.
    kind : str
        SI unit of what is known to be measured, from the map or because its name says that it is a pressure; empty if nothing is.
    raster : float, s, or None
        Interval between its samples; found in the log where it is None.
    between : str
        What holds between two samples: ``"linear"`` or ``"hold"``.
    low, high : float
        Plausible range in `unit`; a value beyond it is none.
    sign : int
        -1 turns the channel round.
    dates : str or None
        Of the time: how its dates are written, one of `ORDERS`; None where the log tells.
    """

    source: str
    name: str
    role: str = "input"
    unit: str = ""
    kind: str = ""
    raster: float | None = None
    between: str = "linear"
    low: float = -inf
    high: float = inf
    sign: int = 1
    dates: str | None = None


@dataclass(frozen=True)
class ChannelMap:
    """All channels of a log.

    Attributes
    ----------
    raster : float, s
        Of the table that is made of the log.
    channels : tuple of Channel
    flows : tuple of FlowChannel
        To reconstruct.
    interval : float, s, or None
        Between rows, of a log that has no channel of the time.
    atmosphere : float, Pa, or None
        Subtracted from absolute pressures; the standard atmosphere where it is None.
    rates : tuple of RateChannel
        To differentiate.
    """

    raster: float
    channels: tuple[Channel, ...]
    flows: tuple[FlowChannel, ...] = ()
    interval: float | None = None
    atmosphere: float | None = None
    rates: tuple[RateChannel, ...] = ()

    def conversion(self, channel: Channel, unit: str | None = None) -> Conversion:
        """How a channel converts to SI, or would if its numbers were in `unit`."""
        atmosphere = ATMOSPHERE if self.atmosphere is None else self.atmosphere
        return conversion(channel.unit if unit is None else unit, kind=channel.kind, atmosphere=atmosphere)

    @property
    def time(self) -> Channel | None:
        """The channel of the time; None where the log has clocks of its own (MDF)."""
        return next((c for c in self.channels if c.role == "time"), None)

    @property
    def used(self) -> list[Channel]:
        """Inputs and outputs, in order."""
        return [c for c in self.channels if c.role in ("input", "output")]

    def of_role(self, role: str) -> list[str]:
        """Columns that are inputs or outputs, those that are made among them."""
        found = [c.name for c in self.used if c.role == role]
        return found + [f.name for f in self.flows if f.role == role] + [r.name for r in self.rates if r.role == role]

    def made(self) -> dict[str, str]:
        """SI units of columns that are made of others."""
        of = {c.name: self.conversion(c).si for c in self.used}
        return {flow.name: "m3/s" for flow in self.flows} | {rate.name: RATES[of[rate.of]] for rate in self.rates}


def load_channels(path: str | Path) -> ChannelMap:
    """Read a channel map.

    Parameters
    ----------
    path : str or Path
        A TOML file: ``raster = "10 ms"`` of the table; ``interval = "10 ms"`` between rows where no channel is the time;
        ``atmosphere = "1.01325 bar"``, subtracted from absolute pressures; for each channel a ``[[channel]]`` with ``source``, ``role``, and
        optional ``name``, ``kind`` (such as ``"pressure"``), ``unit``, ``raster``, ``between``, ``range``, ``sign``; for each flow to reconstruct a ``[[flow]]`` with
        ``name``, ``position``, ``area``, and optional ``pressure``, ``compliance``, ``window``, ``role``; for each rate a
        ``[[derivative]]`` with ``name``, ``of``, ``window``, and optional ``role``.

    Raises
    ------
    InputError
        Unknown or missing key, unknown unit, a value that is not allowed, two channels of one name: file, key, value.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"channel map {path}: no such file; `polydraulic import --suggest LOG` writes a first one")
    data = read_toml(path)
    try:
        return channel_map(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def channel_map(data: Mapping[str, Any]) -> ChannelMap:
    """Make a channel map from what its file would hold.

    Parameters
    ----------
    data : mapping
        Keys and values as in the TOML file that `load_channels` reads.

    Raises
    ------
    InputError
        As `load_channels`, without the name of a file.
    """
    check_keys(data, _MAP, {"raster", "channel"})
    raster = duration(data["raster"], "raster")
    flows = tuple(_flow(item, f"flow {n}") for n, item in enumerate(_tables(data, "flow"), 1))
    pressures = {flow.pressure for flow in flows}
    channels = tuple(_channel(item, f"channel {n}", pressures) for n, item in enumerate(_tables(data, "channel"), 1))
    interval = duration(data["interval"], "interval") if "interval" in data else None
    rates = tuple(_rate(item, f"derivative {n}") for n, item in enumerate(_tables(data, "derivative"), 1))
    found = ChannelMap(raster, channels, flows, interval, _atmosphere(data), rates)
    clocks = [c.source for c in channels if c.role == "time"]
    if len(clocks) > 1:
        raise InputError(f"channels {clocks[0]!r} and {clocks[1]!r} both have the role 'time'; one log has one time")
    if clocks and interval is not None:
        raise InputError(f"channel {clocks[0]!r} has the role 'time', and interval is given too; leave one of them out")
    if not found.used:
        raise InputError("no channel has the role 'input' or 'output'; give at least one of them")
    for what, names in (
        ("name", [*(c.name for c in found.used), *(f.name for f in flows), *(r.name for r in rates)]),
        ("source", [c.source for c in channels if c.role != "ignore"]),
    ):
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InputError(f"two channels have the {what} {twice!r}; each needs its own")
    for flow in flows:
        _check_flow(flow, found)
    for rate in rates:
        _check_rate(rate, found)
    return found


def duration(value: Any, where: str, low: float = SHORTEST, high: float = LONGEST) -> float:
    """Read a time such as ``"10 ms"`` and check its range, in s."""
    seconds = quantity(value, "s", where)
    if not low <= seconds <= high:
        raise InputError(f"{where} = {value!r}: must lie in [{low:g}, {high:g}] s")
    return seconds


def text(value: Any, where: str, allowed: Sequence[str] | None = None) -> str:
    """Check a text that is not empty, one of `allowed` if given."""
    if not isinstance(value, str) or not value.strip():
        raise InputError(f"{where} = {briefly(value)}: must be a string")
    if allowed is not None and value not in allowed:
        raise InputError(f"{where} = {value!r}: must be one of {list(allowed)}")
    return value


def low_and_high(value: Any, where: str) -> tuple[float, float]:
    """Check a range ``[low, high]``."""
    good = isinstance(value, list) and len(value) == 2
    good = good and all(isinstance(v, int | float) and not isinstance(v, bool) and abs(v) <= FARTHEST for v in value)
    if not good or not value[0] < value[1]:
        raise InputError(
            f"{where} = {briefly(value)}: must be [low, high], two numbers in the channel's unit of at most {FARTHEST:g}, low below high"
        )
    return float(value[0]), float(value[1])


def _tables(data: Mapping[str, Any], key: str) -> list[Any]:
    items = data.get(key, [])
    if not isinstance(items, list):
        raise InputError(f"{key} must be a list of tables; begin each with [[{key}]]")
    return items


def _atmosphere(data: Mapping[str, Any]) -> float | None:
    if "atmosphere" not in data:
        return None
    value = quantity(data["atmosphere"], "Pa", "atmosphere", atmosphere=0.0)
    if not THINNEST <= value <= DENSEST:
        raise InputError(
            f"atmosphere = {data['atmosphere']!r}: must lie in [{THINNEST / 1e5:g}, {DENSEST / 1e5:g}] bar"
        )
    return value


def _channel(item: Any, where: str, pressures: set[str | None]) -> Channel:
    check_keys(item, _CHANNEL, {"source", "role"}, where)
    source = text(item["source"], f"source in {where}")
    where = f"channel {source!r}"
    role = text(item["role"], f"role of {where}", ROLES)
    if role == "ignore":
        return Channel(source, source, role)
    unit = item.get("unit", "s" if role == "time" else "")
    if not isinstance(unit, str):
        raise InputError(f"unit of {where} = {briefly(unit)}: must be a string, empty for plain numbers")
    name = source if role == "time" else text(item.get("name", source), f"name of {where}")
    kind, why = _kind(item, where, name, pressures) if role != "time" else ("s", "its role")
    try:
        found = conversion(unit, kind=kind)
    except InputError as error:
        raise InputError(f"unit of {where}: {error}") from error
    if role == "time":
        if found.si != "s":
            raise InputError(f"unit of {where} = {unit!r}: time needs a unit of time")
        check_keys(item, {"source", "role", "unit", "raster", "dates"}, (), f"the time {where}")
        dates = text(item["dates"], f"dates of {where}", ORDERS) if "dates" in item else None
        return Channel(source, "time", role, unit, "s", _raster(item, where), dates=dates)
    if "dates" in item:
        raise InputError(f"dates of {where}: only the channel of the time has dates")
    if why and "unit" not in item:
        raise InputError(
            f'{where} has no unit, but {why} says {unit_kind(kind).name}: give its unit, or unit = "" for plain numbers'
        )
    if why and found.si != kind and (unit.strip() or "kind" in item):
        raise InputError(
            f"unit of {where} = {unit!r} measures {unit_kind(found.si).name}, but {why} says {unit_kind(kind).name}: give a unit such as "
            f"{(unit_kind(kind).offered or (kind,))[-1]!r}, or what is measured as kind = {unit_kind(found.si).name!r}"
        )
    if name in RESERVED:
        raise InputError(f"name of {where} = {name!r}: the table has a column of this name already; choose another")
    low, high = low_and_high(item["range"], f"range of {where}") if "range" in item else (-inf, inf)
    between = text(item.get("between", "linear"), f"between of {where}", BETWEEN)
    sign = item.get("sign", 1)
    if isinstance(sign, bool) or sign not in (1, -1):
        raise InputError(f"sign of {where} = {briefly(sign)}: must be 1 or -1")
    return Channel(source, name, role, unit, kind, _raster(item, where), between, low, high, int(sign))


def _kind(item: Mapping[str, Any], where: str, name: str, pressures: set[str | None]) -> tuple[str, str]:
    """SI unit of what a channel is known to measure, and what says so in its own entry."""
    if "kind" in item:
        kind = text(item["kind"], f"kind of {where}", tuple(_SI_OF_KIND))
        return _SI_OF_KIND[kind], "its kind"
    said = next((given for given in dict.fromkeys((name, item["source"])) if says_pressure(given)), None)
    if said is not None:
        return "Pa", f"its name {said!r}"
    return ("Pa" if name in pressures else ""), ""  # `_check_flow` looks at what flows are made of


def _raster(item: Mapping[str, Any], where: str) -> float | None:
    return duration(item["raster"], f"raster of {where}") if "raster" in item else None


def _flow(item: Any, where: str) -> FlowChannel:
    check_keys(item, _FLOW, {"name", "position", "area"}, where)
    name = text(item["name"], f"name in {where}")
    where = f"flow {name!r}"
    if name in RESERVED:
        raise InputError(f"name of {where}: the table has a column of this name already; choose another")
    if ("pressure" in item) != ("compliance" in item):
        raise InputError(f"{where}: pressure and compliance go together; give both or neither")
    area = item["area"]
    kind = conversion(area.strip().partition(" ")[2]).si if isinstance(area, str) else "m2"
    kind = kind if kind in ("m2", "m3/rad") else "m2"
    return FlowChannel(
        name,
        text(item["position"], f"position of {where}"),
        quantity(area, kind, f"area of {where}"),
        text(item["pressure"], f"pressure of {where}") if "pressure" in item else None,
        quantity(item["compliance"], "m3/Pa", f"compliance of {where}") if "compliance" in item else 0.0,
        duration(item.get("window", "0.1 s"), f"window of {where}"),
        text(item.get("role", "output"), f"role of {where}", ("input", "output")),
    )


def _rate(item: Any, where: str) -> RateChannel:
    check_keys(item, _DERIVATIVE, {"name", "of", "window"}, where)
    name = text(item["name"], f"name in {where}")
    if name in RESERVED:
        raise InputError(f"name of derivative {name!r}: the table has a column of this name already; choose another")
    where = f"derivative {name!r}"
    role = text(item.get("role", "output"), f"role of {where}", ("input", "output"))
    return RateChannel(name, text(item["of"], f"of in {where}"), duration(item["window"], f"window of {where}"), role)


def _check_rate(rate: RateChannel, channels: ChannelMap) -> None:
    columns = {c.name: c for c in channels.used}
    if rate.of not in columns:
        raise InputError(f"of in derivative {rate.name!r} = {rate.of!r}: no such column; there are {list(columns)}")
    source = columns[rate.of]
    if (si := channels.conversion(source).si) not in RATES:
        raise InputError(
            f"of in derivative {rate.name!r} = {rate.of!r} is in {si or 'plain numbers'}; it must be in one of {list(RATES)}"
        )
    if source.between == "hold":
        raise InputError(
            f'of in derivative {rate.name!r} = {rate.of!r} is held between its samples: steps have no rate; use between = "linear"'
        )
    least = 3.0 * max(channels.raster, source.raster or 0.0)
    if rate.window < least * _NEARLY:
        raise InputError(
            f"window of derivative {rate.name!r} = {rate.window:g} s: must be {least:g} s at least, three rasters of table and channel"
        )


def _check_flow(flow: FlowChannel, channels: ChannelMap) -> None:
    columns = {c.name: channels.conversion(c).si for c in channels.used}
    area = "m3/rad" if columns.get(flow.position) == "rad" else "m2"
    for key, name, kinds in (
        ("position", flow.position, ("m", "rad")),
        ("pressure", flow.pressure, ("Pa",)),
    ):
        if name is None:
            continue
        if name not in columns:
            raise InputError(f"{key} of flow {flow.name!r} = {name!r}: no such column; there are {list(columns)}")
        if columns[name] not in kinds:
            raise InputError(f"{key} of flow {flow.name!r} = {name!r} is in {columns[name]}; it must be in {kinds[0]}")
    if flow.compliance < 0.0 or flow.area == 0.0:
        raise InputError(f"flow {flow.name!r}: area must not be 0, compliance not negative")
    if flow.window < 3.0 * channels.raster * _NEARLY:
        raise InputError(
            f"window of flow {flow.name!r} = {flow.window:g} s: must be three rasters of the table ({channels.raster:g} s) "
            f"at least, with an area in {area}"
        )
