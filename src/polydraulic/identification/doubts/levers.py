"""Whether joints go the way their levers, or spools, send them.

A spool beyond its deadband feeds one port, and its joint goes that way or stays. Where a lever has pointed one way for half a second, longer than
pilot and line take, each move of the joint is a vote: for the lever, or against it. Of the machines that come with the package, by random operators, at most
one move in eight is against, when others' moves and weights push a joint; of a lever that has nothing to do with a joint about half are.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.identification.log_pieces import even_pieces, raster_of
from polydraulic.identification.noise import noise_of_pieces
from polydraulic.machine.valve import spool_edges
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
from polydraulic.tables import Table

_REACH = 0.15  # s before and after an instant, between which a joint's way is measured
_SETTLED = 0.5  # s after which a spool has forgotten where it came from, besides its dead time
_OPEN = 0.1  # of the travel behind the deadband, which counts as an order to move
_NOISES = 6.0  # standard deviations of noise, beyond which a joint moves
_USUAL = 0.1  # of how far it usually moves at its fastest, beyond which it moves
_LEAST_WAY, _LONGEST_WAY = 2e-3, 3.0  # of the way between stops; rad or m, where it has none
_FEW, _MANY = 8, 16  # moves that tell a turned sign, and that a joint does not follow at all
_AGAINST = 0.8  # share of moves against the lever, from which on its sign is turned
_ASTRAY = 0.3  # the same, from which on it is another one's
_AT_REST = 0.05  # of the voltage of full travel, within which a lever rests
_HARDLY = 0.02  # share of rows in which a lever is on one side, below which it is never there
_SCALE = 3.0  # by which a spool goes further, or less far, than its pilot drives it, beyond which it is another unit
_ZERO = 0.02  # of its travel, that a spool may read while its lever rests

Doubt = tuple[tuple[str, ...], str]


class Votes(NamedTuple):
    """How the moves of a joint vote on a lever, or a spool.

    Attributes
    ----------
    along, against : int
        Orders of the lever that the joint followed, and those that it went against.
    up, down : int
        How often the joint went up and down at all.
    """

    along: int
    against: int
    up: int = 0
    down: int = 0

    @property
    def moves(self) -> int:
        """All of them."""
        return self.along + self.against

    @property
    def share(self) -> float:
        """Share of those against; 0 where there are no moves."""
        return self.against / max(self.moves, 1)

    @property
    def turned(self) -> bool:
        """Whether the sign is turned."""
        return self.moves >= _FEW and self.share >= _AGAINST

    @property
    def astray(self) -> bool:
        """Whether the joint goes as if the lever were another one's."""
        return self.moves >= _MANY and _ASTRAY <= self.share < _AGAINST

    @property
    def sure(self) -> bool:
        """Whether the joint follows, be it with the sign turned."""
        return self.moves >= _FEW and not 1.0 - _AGAINST < self.share < _AGAINST


def lever_votes(machine: LayoutMachine, table: Table) -> dict[str, dict[str, Votes]]:
    """By function, how its joint votes on its own voltage and spool, where the log has them and they tell something."""
    return {f.name: _ordered(machine, f, table) for f in machine.functions}


def lever_doubts(machine: LayoutMachine, table: Table, found: Mapping[str, Mapping[str, Votes]]) -> Iterator[Doubt]:
    """Levers and spools whose joints go another way, by their `lever_votes`."""
    for f in machine.functions:
        yield from _spool_off(f, table)
    astray: list[str] = []
    for f in machine.functions:
        of = found[f.name]
        by_lever, by_spool = of.get("voltage"), of.get("spool")
        place = position_column(machine, f)
        if by_spool is not None and by_spool.turned:
            yield _turned(f"{f.name}.spool", place, by_spool, by_lever, f"{f.name}.voltage")
        elif by_lever is not None and by_lever.turned:
            yield _turned(f"{f.name}.voltage", place, by_lever, by_spool, f"{f.name}.spool")
        elif by_lever is not None and min(by_lever.up, by_lever.down) >= _FEW and _one_sided(f, table):
            voltage = table.columns[f"{f.name}.voltage"]
            low, high = float(np.nanmin(voltage)), float(np.nanmax(voltage))
            yield (
                (f"{f.name}.voltage",),
                f"{place} goes up and down, {by_lever.up} and {by_lever.down} times, and {f.name}.voltage lies between {low:.4g} and {high:.4g} V, hardly "
                "ever on both sides of zero: take off its centre where the log is imported, or leave it out if it is dead",
            )
        elif (by_lever is not None and by_lever.astray) or (by_spool is not None and by_spool.astray):
            astray.append(f.name)
    yield from _exchanged(machine, table, astray, found)


def _spool_off(f: MachineFunction, table: Table) -> Iterator[Doubt]:
    """A spool that reads a way of its own where its lever rests, or goes many times as far as its pilot drives it, or as little."""
    voltage, spool, full = f"{f.name}.voltage", f"{f.name}.spool", f.valve.knots[-1]
    if not {voltage, spool} <= set(table.names) or not table.known([voltage, spool]).any():
        return
    raster, rest, far = raster_of(table), list[np.ndarray](), list[np.ndarray]()
    wait = max(1, round((_SETTLED + f.pilot.dead_time) / raster))
    for _, values in even_pieces(table, [voltage, spool]):
        driven = np.clip(f.pilot.gain * values[:, 0], -full, full)
        side = np.where(np.abs(driven) < _AT_REST * full, 0.0, np.sign(driven))
        for begin, end in _runs(side):
            (far if side[begin] else rest).append(np.column_stack([driven, values[:, 1]])[begin + wait : end])
    at_rest, away = (np.concatenate([*parts, np.empty((0, 2))]) for parts in (rest, far))
    if len(away) >= _FEW:
        ratio = float(np.median(np.abs(away[:, 1])) / np.median(np.abs(away[:, 0])))
        if not 1.0 / _SCALE < ratio < _SCALE:
            yield (
                (spool,),
                f"{spool} goes {ratio:.3g} times as far as the file's pilot drives it by {voltage}: look at its unit where the log is imported, or at the "
                f"gain in the file",
            )
            return
    if len(at_rest) >= _FEW and abs(zero := float(np.median(at_rest[:, 1]))) > _ZERO * full:
        yield (
            (spool,),
            f"{spool} reads {amount(zero, 'm')} while its lever rests, and curves over its travel would be off by as much: take it off where the log is "
            "imported",
        )


def votes_of(machine: LayoutMachine, table: Table, lever: MachineFunction, what: str, moved: MachineFunction) -> Votes:
    """How one function's joint moves by another's, or its own, voltage or spool.

    Parameters
    ----------
    machine : LayoutMachine
    table : Table
        The log, in SI; it may declare missing values.
    lever : MachineFunction
        Whose orders are looked at.
    what : {"voltage", "spool"}
        By what of it.
    moved : MachineFunction
        Whose joint votes.
    """
    full, edge = lever.valve.knots[-1], spool_edges(lever.valve)[0]
    least_open = min(edge + _OPEN * (full - edge), 0.9 * full)
    columns = [f"{lever.name}.{what}", position_column(machine, moved)]
    if not table.known(columns).any():
        return Votes(0, 0)
    gain, late = (lever.pilot.gain, lever.pilot.dead_time) if what == "voltage" else (1.0, 0.0)
    raster = raster_of(table)
    reach, wait = max(1, round(_REACH / raster)), max(1, round((_SETTLED + late) / raster))
    pieces = [
        (gain * order, _way(position, reach), position)
        for _, values in even_pieces(table, columns)
        for order, position in [values.T]
        if len(position) > 2 * reach
    ]
    if not pieces:
        return Votes(0, 0)
    fastest = float(np.quantile(np.abs(np.concatenate([way for _, way, _ in pieces])), 0.98))
    between = min(moved.stops.high - moved.stops.low, _LONGEST_WAY)
    of_difference = np.sqrt(2.0) * noise_of_pieces([position for _, _, position in pieces])
    least = max(_NOISES * of_difference, _USUAL * fastest, _LEAST_WAY * between)
    along = against = up = down = 0
    for order, way, _ in pieces:
        going = np.sign(way) * (np.abs(way) > least)
        ways = [going[begin] for begin, end in _stretches(going) if end - begin > reach]
        up, down = up + ways.count(1.0), down + ways.count(-1.0)
        side = np.sign(order) * (np.abs(order) > least_open)
        for begin, end in _stretches(side):
            moves = way[begin + wait : end]
            net = side[begin] * np.sign(moves[np.abs(moves) > least]).sum()
            along, against = along + int(net > 0.0), against + int(net < 0.0)
    return Votes(along, against, up, down)


def _ordered(machine: LayoutMachine, f: MachineFunction, table: Table) -> dict[str, Votes]:
    """Votes on a function's own voltage and spool."""
    if position_column(machine, f) not in table.names:
        return {}
    there = [what for what in ("voltage", "spool") if f"{f.name}.{what}" in table.names]
    return {what: votes_of(machine, table, f, what, f) for what in there}


def _exchanged(
    machine: LayoutMachine, table: Table, astray: list[str], found: Mapping[str, Mapping[str, Votes]]
) -> Iterator[Doubt]:
    """Of joints that do not follow: which lever they do follow, or that they follow none."""
    for name in astray:
        f = machine.function(name)
        what = "voltage" if "voltage" in found[name] and found[name]["voltage"].astray else "spool"
        column, place, own = f"{name}.{what}", position_column(machine, f), found[name][what]
        others = [
            g for g in machine.functions if g.name in astray and g.name != name and f"{g.name}.{what}" in table.names
        ]
        followed = [g.name for g in others if votes_of(machine, table, g, what, f).sure]
        begun = _moves(place, column, own)
        if len(followed) == 1:
            yield (
                (column, place),
                f"{begun}, and follows {followed[0]}.{what}: channels of {name} and {followed[0]} are exchanged; give each its own where the log is "
                "imported",
            )
        else:
            yield (
                (column, place),
                f"{begun}: they are not of the same joint, or their clocks are apart; look at both where the log is imported",
            )


def _turned(column: str, place: str, votes: Votes, second: Votes | None, other: str) -> Doubt:
    """A joint that goes against its spool, or its lever; the other of the two, where it tells something, says which one is wrong."""
    begun, do = _moves(place, column, votes), "turn it where the log is imported"
    if second is None or not second.sure:
        return (column, place), f"{begun}, so that one of them has the wrong sign: {do}"
    if second.turned:
        return (place,), f"{begun}, and {other} too, so that {place} has the wrong sign: {do}"
    return (column,), f"{begun}, and with {other}, so that {column} has the wrong sign: {do}"


def _one_sided(f: MachineFunction, table: Table) -> bool:
    """Whether a lever hardly ever leaves its rest to one of its sides."""
    voltage = table.whole([f"{f.name}.voltage"])[f"{f.name}.voltage"]
    least = _AT_REST * f.valve.knots[-1] / f.pilot.gain
    return bool(min((voltage > least).mean(), (voltage < -least).mean()) < _HARDLY)


def _moves(place: str, column: str, votes: Votes) -> str:
    return f"{place} goes against {column} in {votes.against} of {votes.moves} moves"


def _way(position: np.ndarray, reach: int) -> np.ndarray:
    """How far a joint goes around each row; none at the ends."""
    way = np.zeros(len(position))
    way[reach:-reach] = position[2 * reach :] - position[: -2 * reach]
    return way


def _runs(side: np.ndarray) -> list[tuple[int, int]]:
    """Rows from which on, and before which, a lever is on one side, or at rest."""
    return list(pairwise([0, *(np.flatnonzero(np.diff(side)) + 1).tolist(), len(side)]))


def _stretches(side: np.ndarray) -> list[tuple[int, int]]:
    """Those in which it points one way."""
    return [(begin, end) for begin, end in _runs(side) if side[begin] != 0.0]
