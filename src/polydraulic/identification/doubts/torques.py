"""Whether torques of the oil go with motion, weight and friction.

The torque of the oil follows from both pressures and the actuator's levers, what a motion needs from positions and masses. By the file of a machine whose
masses are off by half the two still go together; with ports exchanged, one of them in another unit, or the sign of a joint turned, they do not, and the log
says which of these it is: the one with which they do.
"""

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.identification.doubts.levers import Doubt
from polydraulic.identification.log_pieces import even_pieces, weighted_sums
from polydraulic.machine.joint_torques import torques_of_friction, torques_of_motion
from polydraulic.machine.volumes import levers
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine, position_columns
from polydraulic.tables import Table
from polydraulic.watch.blocks import motion_filters

# of what is read: powers of ten, and psi for bar or bar for psi
_FACTORS = (0.01, 0.0689476, 0.1, 10.0, 14.5038, 100.0)
_MOST_ROWS = 60_000  # that are looked at
_FEW = 300  # rows away from stops that tell something
_SLOWEST = 0.1  # s between rows, at which accelerations are still seen
_NEAR_STOP = 0.02  # rad or m
_TURNS = 3.0  # rates of Stribeck and of smoothing, above which friction is no longer anything
# where pressures are put right, what is left of torques at most, of what was left; correlation of both torques at least, and how much more at least
_BETTER, _TOGETHER, _CLOSER = 0.35, 0.9, 0.03
_SCALE = 5.0  # by which the masses of a file are not off
# cosine of torques that go together, at least, and of those that a sign put right
_ALONG, _PUT_RIGHT = 0.5, 0.8
_ABOVE, _RARE = 2.0, 1e-3  # times the highest relief setting, and share of rows beyond


class TorqueDoubts(NamedTuple):
    """What torques of a log say against its channels.

    Attributes
    ----------
    named : list of Doubt
        Channels that contradict each other, and what would mend them.
    apart : list of str
        Functions whose torques do not go together and no single mistake explains it, with how far they are apart.
    """

    named: list[Doubt]
    apart: list[str]


class _Put(NamedTuple):
    """A way to put pressures right: ports exchanged, and what each reading is multiplied by."""

    exchanged: bool
    a: float
    b: float


class _Match(NamedTuple):
    """How the oil's torque goes with what is needed: correlation, slope, share that is left, and cosine while the joint moves.

    A joint at rest carries by friction whatever there is, so that the cosine is NaN where it hardly moves.
    """

    together: float
    slope: float
    left: float
    along: float

    @property
    def scaled(self) -> bool:
        """Whether the torque of the oil is of the size that is needed."""
        return 1.0 / _SCALE < self.slope < _SCALE

    @property
    def against(self) -> bool:
        """Whether the oil does not move the machine of the file, whatever its masses are."""
        return bool(np.isfinite(self.along)) and not (self.along > _ALONG and self.scaled)

    def far_better(self, read: "_Match", put: _Put) -> bool:
        """Whether pressures that were put right move the machine of the file, and those that were read do not."""
        if not (self.left < _BETTER * read.left and self.together > _TOGETHER and self.scaled):
            return False
        return self.together > read.together + _CLOSER if put.a != put.b or put.exchanged else not read.scaled


class _Piece(NamedTuple):
    """Rows of the log without a gap, smoothed: positions, their rates and accelerations, pressures at A and B, (n_row, n_function) each."""

    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    p_a: np.ndarray
    p_b: np.ndarray

    def turned(self, k: int) -> "_Piece":
        """The same with the sign of a position turned."""
        sign = np.ones(self.q.shape[1])
        sign[k] = -1.0
        return self._replace(q=sign * self.q, qd=sign * self.qd, qdd=sign * self.qdd)


_AS_READ = _Put(False, 1.0, 1.0)
_WAYS = [
    _AS_READ,
    _Put(True, 1.0, 1.0),
    *(_Put(False, factor, factor) for factor in _FACTORS),
    *(_Put(False, factor, 1.0) for factor in _FACTORS),
    *(_Put(False, 1.0, factor) for factor in _FACTORS),
]


def beyond_relief(machine: LayoutMachine, table: Table) -> Iterator[Doubt]:
    """Pressures that no valve of the file lets stand."""
    for f in machine.functions:
        most = max(f.line.relief, *(c.pump.relief for c in machine.circuits))
        beyond = tuple(p for p in _ports(f) if p in table.names and (table.columns[p] > _ABOVE * most).mean() > _RARE)
        if beyond:
            read = max(float(np.nanmax(table.columns[p])) for p in beyond)
            yield (
                beyond,
                f"{' and '.join(beyond)} read{'' if len(beyond) > 1 else 's'} up to {amount(read, 'Pa')}, and no relief valve of the file opens "
                f"above {amount(most, 'Pa')}: look at the unit where the log is imported",
            )


def torque_doubts(machine: LayoutMachine, table: Table, right: Collection[str] = ()) -> TorqueDoubts:
    """Pressures, or signs of joints, by which the oil pushes another way than joints go.

    Parameters
    ----------
    machine : LayoutMachine
    table : Table
        The log, in SI, with times that rise; nothing is said without positions and both pressures of all functions.
    right : collection of str
        Columns of positions whose signs are known to be right, by levers for example.
    """
    places = position_columns(machine)
    needed = ["time", *places, *(p for f in machine.functions for p in _ports(f))]
    if not set(needed) <= set(table.names) or not table.known(needed).any():
        return TorqueDoubts([], [])
    pieces = _smoothed(machine, table)
    ways = _matches(machine, pieces, _WAYS)
    read = {k: of[_AS_READ] for k, of in enumerate(ways) if _AS_READ in of}
    bad = {k: own for k, own in read.items() if own.against}
    puts = {k: put for k in read if (put := _far_better(ways[k])) is not None}
    unsure = [k for k, place in enumerate(places) if bad and place not in right]
    signs = tuple(places[k] for k in unsure if _goes_turned(machine, pieces, k, bad))
    if signs and not puts.keys() >= bad.keys():  # one sign explains all, and ports do not
        return TorqueDoubts([_told_of_signs(machine, signs, bad)], [])
    named = [_told_of_ports(machine.functions[k], read[k], put, signs) for k, put in puts.items()]
    return TorqueDoubts(named, [_said(machine.names[k], own) for k, own in bad.items() if k not in puts])


def check_torques(machine: LayoutMachine, table: Table) -> None:
    """Refuse a log whose torques of the oil do not go with its motion; arguments as of `torque_doubts`.

    Raises
    ------
    InputError
        Which channels it is and what would mend it, or which functions, where no single mistake explains it.
    """
    found = torque_doubts(machine, table)
    if found.named:
        raise InputError("; ".join(text for _, text in found.named))
    if found.apart:
        raise InputError(
            f"torques of the oil do not go with motion, and with what masses of the file need, at {', '.join(found.apart)}: look at the signs of "
            "positions, at ports that are exchanged, at units of pressures, and at the masses of the file"
        )


def _said(of: str, own: _Match) -> str:
    return f"{of} (correlation {own.together:.2f}, slope {own.slope:.3g})"


def _told_of_signs(machine: LayoutMachine, signs: tuple[str, ...], bad: dict[int, _Match]) -> Doubt:
    where = ", ".join(_said(machine.names[k], own) for k, own in bad.items())
    return signs, (
        f"torques of the oil contradict what motion needs at {where} and fit it with the sign of {' or of '.join(signs)} turned: turn it where the log "
        "is imported"
    )


def _told_of_ports(f: MachineFunction, own: _Match, put: _Put, signs: tuple[str, ...]) -> Doubt:
    """What puts the pressures of a function right; turned signs may explain it as well."""
    a, b = _ports(f)
    begun = f"torques of the oil by {a} and {b} contradict {_said(f'what the motion of {f.name} needs', own)} and fit it with"
    either = "".join(f", or with the sign of {place} turned" for place in signs)
    if put.exchanged:
        do = "mend that" if signs else "exchange them"
        return (a, b, *signs), f"{begun} the two exchanged{either}: {do} where the log is imported"
    wrong = tuple(column for column, factor in ((a, put.a), (b, put.b)) if factor != 1.0)
    factor = put.a if put.a != 1.0 else put.b
    return (*wrong, *signs), (
        f"{begun} {' and '.join(wrong)} times {factor:.3g}{either}: look at {'their' if len(wrong) > 1 else 'its'} unit where the log is imported"
    )


def _smoothed(machine: LayoutMachine, table: Table) -> list[_Piece]:
    """Pieces of the log from which accelerations are seen, up to so many rows."""
    columns = position_columns(machine)
    columns += [_ports(f)[port] for port in (0, 1) for f in machine.functions]
    found, left = list[_Piece](), _MOST_ROWS
    for time, values in even_pieces(table, columns):
        raster = float(np.median(np.diff(time))) if len(time) > 1 else np.inf
        if left <= 0 or raster > _SLOWEST:
            continue
        smooth, slope, curve = motion_filters(raster)
        values = values[:left]
        if len(values) < 2 * len(smooth):
            continue
        position, p_a, p_b = np.split(values, 3, axis=1)
        left -= len(values)
        motion = (weighted_sums(position, weights) for weights in (smooth, slope, curve))
        found.append(_Piece(*motion, *(weighted_sums(p, smooth) for p in (p_a, p_b))))
    return found


def _matches(machine: LayoutMachine, pieces: Sequence[_Piece], puts: Sequence[_Put]) -> list[dict[_Put, _Match]]:
    """Of each function, how torques go together with each way to put pressures right; empty where the log tells nothing."""
    needed = [torques_of_motion(machine, *piece[:3]) + torques_of_friction(machine, piece.qd)[0] for piece in pieces]
    return [_matches_of(machine, k, pieces, [of[:, k] for of in needed], puts) for k in range(len(machine.functions))]


def _matches_of(
    machine: LayoutMachine, k: int, pieces: Sequence[_Piece], needed: Sequence[np.ndarray], puts: Sequence[_Put]
) -> dict[_Put, _Match]:
    f, found = machine.functions[k], dict[_Put, _Match]()
    away = [(p.q[:, k] > f.stops.low + _NEAR_STOP) & (p.q[:, k] < f.stops.high - _NEAR_STOP) for p in pieces]
    if sum(map(np.count_nonzero, away)) < _FEW:
        return found
    q, rate, p_a, p_b = (
        np.concatenate([of[:, k][rows] for of, rows in zip(parts, away, strict=True)])
        for parts in zip(*((p.q, p.qd, p.p_a, p.p_b) for p in pieces), strict=True)
    )
    need = np.concatenate([of[rows] for of, rows in zip(needed, away, strict=True)])
    whole = float(np.median(np.abs(need)))
    if not (whole > 0.0 and np.std(need) > 0.0):
        return found
    moves = np.abs(rate) > _TURNS * max(f.friction.stribeck, f.friction.smoothing)
    arm_a, arm_b = levers(machine, f, q)
    for put in puts:
        a, b = (p_b, p_a) if put.exchanged else (put.a * p_a, put.b * p_b)
        oil = arm_a * a - arm_b * b
        if np.std(oil) > 0.0:
            found[put] = _Match(
                float(np.corrcoef(oil, need)[0, 1]),
                float(oil @ need / (need @ need)),
                float(np.median(np.abs(oil - need))) / whole,
                _cosine(oil[moves], need[moves]),
            )
    return found


def _cosine(oil: np.ndarray, need: np.ndarray) -> float:
    """Correlation about zero; NaN of few rows."""
    sizes = float(np.linalg.norm(oil) * np.linalg.norm(need))
    return float(oil @ need) / sizes if len(need) >= _FEW and sizes > 0.0 else float("nan")


def _far_better(ways: dict[_Put, _Match]) -> _Put | None:
    """The way in which pressures go with motion, if they do not as they are read."""
    others = {put: match for put, match in ways.items() if put != _AS_READ}
    if _AS_READ not in ways or not others:
        return None
    put, best = min(others.items(), key=lambda item: item[1].left)
    return put if best.far_better(ways[_AS_READ], put) else None


def _goes_turned(machine: LayoutMachine, pieces: Sequence[_Piece], k: int, bad: Collection[int]) -> bool:
    """Whether all torques go together with the sign of a position turned, and well at its joint and where they did not."""
    found = [of.get(_AS_READ) for of in _matches(machine, [piece.turned(k) for piece in pieces], [_AS_READ])]
    if any(own is not None and own.against for own in found):
        return False
    return all((own := found[n]) is not None and own.along > _PUT_RIGHT for n in (k, *bad))


def _ports(f: MachineFunction) -> tuple[str, str]:
    return f"{f.name}.p_a", f"{f.name}.p_b"
