"""What a machine stands on: tracks or single contacts, mass and centre of gravity of all that no joint moves, and the ground's slope."""

from collections.abc import Iterator, Mapping
from math import atan2, pi, sqrt, tan
from typing import Annotated, Any, NamedTuple

from polydraulic.display import amount
from polydraulic.parameters.layout.names import name_trouble
from polydraulic.parameters.layout.parts import COORDINATES, POINT, Point
from polydraulic.parameters.layout.reader import Reader
from polydraulic.parameters.quantity import Quantity
from polydraulic.parameters.schema import Length

FEWEST_CONTACTS, MOST_CONTACTS = 3, 8
WEIGHT = Quantity("kg", above=0.0)
_STEEPEST = 0.7  # rad, 40 deg: no machine works on more
Tilt = Annotated[float, Quantity("rad", low=-_STEEPEST, high=_STEEPEST)]
_KEYS = ("mass", "cg", "tracks", "contacts", "slope")


class Tracks(NamedTuple):
    """Two tracks along x: distance of their centre lines, and of the wheels at their ends that carry while a machine tips forward."""

    gauge: Length
    length: Length


class Slope(NamedTuple):
    """How the ground rises along the machine's x (`pitch`) and y (`roll`)."""

    pitch: Tilt
    roll: Tilt


class Chassis(NamedTuple):
    """What a machine stands on, and what stands with it.

    Attributes
    ----------
    mass : float, kg
        Of all that no joint moves.
    cg : Point
        Its centre of gravity, in the ground's frame.
    tracks : Tracks or None
        In place of contacts.
    middle : Point
        Of the tracks, on the ground.
    contacts : mapping from name to Point
        Where wheels or outriggers carry, in the ground's frame.
    slope : Slope or None
        None where the ground is level.
    """

    mass: float
    cg: Point
    tracks: Tracks | None
    middle: Point
    contacts: Mapping[str, Point]
    slope: Slope | None = None

    @property
    def corners(self) -> tuple[tuple[float, float, float], ...]:
        """Points on which it stands, counter-clockwise as seen from above, from the most forward edge on, m."""
        if self.tracks is not None:
            x, y, z = _xyz(self.middle)
            a, b = 0.5 * self.tracks.length, 0.5 * self.tracks.gauge
            return (x + a, y - b, z), (x + a, y + b, z), (x - a, y + b, z), (x - a, y - b, z)
        points = [_xyz(point) for point in self.contacts.values()]
        x, y = (sum(point[k] for point in points) / len(points) for k in (0, 1))
        around = sorted(points, key=lambda p: atan2(p[1] - y, p[0] - x))
        first = min(range(len(around)), key=lambda k: abs(_outward(around[k], around[(k + 1) % len(around)])))
        return (*around[first:], *around[:first])

    @property
    def upward(self) -> tuple[float, float, float]:
        """Against gravity, along the axes of the machine's ground frame."""
        pitch, roll = self.slope or (0.0, 0.0)
        x, y = tan(pitch), tan(roll)
        whole = sqrt(x * x + y * y + 1.0)
        return x / whole, y / whole, 1.0 / whole


def read_chassis(reader: Reader, top: Mapping[str, Any]) -> Chassis | None:
    """Chassis of a machine file, None where there is none or something is wrong, which has been noted.

    Parameters
    ----------
    reader : Reader
    top : mapping
        What the file holds.
    """
    if "chassis" not in top:
        return None
    before = len(reader.wrong)
    data = reader.table(top["chassis"], _KEYS, ("mass",), "chassis")
    mass = reader.number(data, "mass", WEIGHT, "chassis")
    cg = reader.components(data, "cg", COORDINATES, POINT, "chassis")
    reader.require(
        ("tracks" in data) != ("contacts" in data),
        "chassis: give either tracks (gauge and length) or contacts, one point for each wheel or outrigger",
    )
    tracks, middle = None, {}
    if isinstance(data.get("tracks"), Mapping):
        tracks = reader.part(Tracks, data, "tracks", "chassis", ("at",))
        middle = reader.components(data["tracks"], "at", COORDINATES, POINT, "chassis.tracks")
    elif "tracks" in data:
        reader.require(False, f"chassis.tracks = {data['tracks']!r}: must be a table of gauge, length and at")
    contacts = _contacts(reader, data["contacts"]) if "contacts" in data else {}
    slope = reader.part(Slope, data, "slope", "chassis")
    return Chassis(mass, cg, tracks, middle, contacts, slope) if len(reader.wrong) == before else None


def _contacts(reader: Reader, data: Any) -> dict[str, Point]:
    if not reader.require(
        isinstance(data, Mapping), f"chassis.contacts = {data!r}: must hold points [chassis.contacts.NAME]"
    ):
        return {}
    reader.require(
        FEWEST_CONTACTS <= len(data) <= MOST_CONTACTS,
        f"chassis.contacts: {len(data)} of them; must be {FEWEST_CONTACTS} to {MOST_CONTACTS}",
    )
    found: dict[str, Point] = {}
    for name in data:
        trouble = name_trouble(name)
        reader.require(not trouble, f"chassis.contacts.{name}: the name {name!r} {trouble}")
        found[name] = reader.components(data, name, COORDINATES, POINT, "chassis.contacts")
    return found


def broken_chassis(chassis: Chassis | None) -> list[str]:
    """Say why a machine cannot stand on these contacts: each of them must be a corner of the area between them."""
    if chassis is None or chassis.tracks is not None:
        return []
    corners = chassis.corners
    for before, here, after in _neighbours(corners):
        turn = (here[0] - before[0]) * (after[1] - here[1]) - (here[1] - before[1]) * (after[0] - here[0])
        if turn <= 1e-6:  # m2
            place = ", ".join(f"{c} {amount(value, 'm')}" for c, value in zip(COORDINATES, here, strict=True))
            return [
                f"chassis.contacts: the one at {place} is no corner of the area between them, seen from above; leave it out or correct it"
            ]
    return []


def _neighbours(corners: tuple[tuple[float, float, float], ...]) -> Iterator[tuple[tuple[float, float, float], ...]]:
    count = len(corners)
    return ((corners[k - 1], corners[k], corners[(k + 1) % count]) for k in range(count))


_SECTORS = ("forward", "forward left", "left", "rear left", "rear", "rear right", "right", "forward right")


def edge_names(chassis: Chassis) -> tuple[str, ...]:
    """Direction in which a machine tips over each edge, from one of its `corners` to the next: ``forward``, ``forward left``, ``left``, ...

    Edges in one of these eight directions are numbered, ``left 1`` and ``left 2``.
    """
    corners = chassis.corners
    found = []
    for _, here, after in _neighbours(corners):
        found.append(_SECTORS[round(_outward(here, after) / (0.25 * pi)) % 8])
    return tuple(
        f"{name} {found[: k + 1].count(name)}" if found.count(name) > 1 else name for k, name in enumerate(found)
    )


def _outward(begin: tuple[float, float, float], end: tuple[float, float, float]) -> float:
    """Direction across an edge, rad from x towards y."""
    return atan2(begin[0] - end[0], end[1] - begin[1])


def _xyz(point: Point) -> tuple[float, float, float]:
    x, y, z = (point.get(c, 0.0) for c in COORDINATES)
    return x, y, z
