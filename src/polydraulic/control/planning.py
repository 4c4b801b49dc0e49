"""Whether a machine can follow a path of its tip from stop to stop, before anything moves."""

from math import ceil, pi
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.control.arm import Arm, arm_pose, arm_rates, joints_at, planar_arm
from polydraulic.control.references import TipPath
from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.simulation.layout.columns import function_column

_EVERY = 0.02  # m or rad between places at which it is looked
_TURNS, _NEAR = 30, 1e-3  # steps towards a place, and m or rad that are near enough
_SLOW = 0.02  # m/s: how little an arm at the end of its reach may move
_TRIED = pi / 36.0 * np.arange(1, 25)  # rad, by which other pitches of the attachment differ


class FollowedPath(NamedTuple):
    """How far a path can be followed.

    Attributes
    ----------
    way, whole : float, m
        Of the tip, or rad where it only turns: what can be followed, and all of the path.
    stop : tuple of str or None
        Function, and ``"low"`` or ``"high"``, whose stop ends it; None where all can be followed, or the arm does not reach further.
    """

    way: float
    whole: float
    stop: tuple[str, str] | None

    @property
    def all(self) -> bool:
        """Whether nothing is left."""
        return self.way >= self.whole


def check_path(machine: LayoutMachine | str | Path, path: TipPath, start: np.ndarray) -> None:
    """Refuse a path that a machine cannot follow between its stops, with the attachment's angle as the path has it.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    path : TipPath
    start : (n_function,) array, rad or m
        Positions of the joints where it begins.

    Raises
    ------
    InputError
        Which joint would come to which stop, after what part of the path; and, where another angle of the attachment would do, which one.
    """
    found = as_machine(machine)
    if len(start) != len(found.names) or not np.isfinite(start).all():
        raise InputError(f"start = {start}: must be {len(found.names)} finite positions, of {', '.join(found.names)}")
    far = followed_path(found, path, start)
    if far.all:
        return
    turns = (np.diff(path.points[:, :2], axis=0) == 0.0).all(axis=1).any()
    part = f"after {far.way / far.whole:.0%} of it" if turns else f"after {far.way:.2f} m of its {far.whole:.2f} m"
    if far.stop is None:
        raise InputError(f"{found.title}: the arm cannot follow the path {part}: it does not reach further; shorten it")
    name, side = far.stop
    f = found.function(name)
    at = amount(f.stops.low if side == "low" else f.stops.high, function_column(found, name, "angle", "rad").unit)
    raise InputError(
        f"{found.title}: the path cannot be followed: {part} {name} comes to its {side} stop, at {at}; {_instead(found, path, start)}"
    )


def followed_path(machine: LayoutMachine, path: TipPath, start: np.ndarray) -> FollowedPath:
    """How far a machine can follow a path; parameters as for `check_path`."""
    arm, n = planar_arm(machine), len(machine.names)
    stops = np.array([f.stops[:2] for f in machine.functions])
    low, high = np.minimum(stops[:, 0], start), np.maximum(stops[:, 1], start)
    live, way = np.concatenate([start, np.zeros(3 * n)]), 0.0
    ways = np.diff(path.points, axis=0)
    longs = _longs(path.points).tolist()
    whole = sum(longs)
    for first, leg, length in zip(path.points, ways, longs, strict=False):
        steps = max(ceil(max(length, float(np.abs(leg[2:]).max())) / _EVERY), 1)
        for k in range(1, steps + 1):
            arrived = _arrive(arm, live, n, first + k / steps * leg)
            beyond = (live[:n] < low - 1e-9) | (live[:n] > high + 1e-9)
            if beyond.any():
                j = int(np.argmax(beyond))
                return FollowedPath(way, whole, (machine.names[j], "low" if live[j] < low[j] else "high"))
            if not arrived:
                return FollowedPath(way, whole, None)
            way += length / steps
    return FollowedPath(whole, whole, None)


def _arrive(arm: Arm, live: np.ndarray, n: int, place: np.ndarray) -> bool:
    """Move joints until the tip is at a place as a controller would, which goes by the height alone with an arm of one joint; whether it gets there."""
    reach, height, swing, pitch = place
    alone = len(arm.function) == 1
    if arm.swing >= 0:
        live[arm.swing] = swing
    for _ in range(_TURNS):
        pose = arm_pose(arm, live, 0, 2 * n)
        turn = pitch - pose.pitch if arm.attachment >= 0 else 0.0
        out, up = 0.0 if alone else reach - pose.reach, height - pose.height
        if max(abs(out), abs(up), abs(turn)) < _NEAR:
            return True
        if arm.attachment >= 0:
            live[arm.attachment] += arm.attachment_sign * turn
            pose = arm_pose(arm, live, 0, 2 * n)
            out, up = 0.0 if alone else reach - pose.reach, height - pose.height
        arm_rates(arm, live, 2 * n, n, out, up, 0.0, 0.0, _SLOW)
        for j in arm.function.tolist():
            live[j] += live[n + j]
        if arm.attachment >= 0:
            live[arm.attachment] += live[n + arm.attachment]
    return False


def _instead(machine: LayoutMachine, path: TipPath, start: np.ndarray) -> str:
    """What can be done about a path: an angle of the attachment that turns on the way, or another one at its beginning, the nearest that serves."""
    arm, points = planar_arm(machine), path.points
    pitch, share = np.array([0.0, 0.0, 0.0, 1.0]), np.concatenate([[0.0], np.cumsum(_longs(points))])[:, None]
    for offset in (sign * by for by in _TRIED for sign in (1.0, -1.0)) if arm.attachment >= 0 else ():
        turned = path._replace(points=points + offset * share / share[-1] * pitch)
        if followed_path(machine, turned, start).all:
            whole = offset + float(points[-1, 3] - points[0, 3])
            return f"it can if its pitch turns by {amount(whole, 'rad')} on the way; or shorten it"
        other = path._replace(points=points + offset * pitch)
        reach, height, swing, first = other.points[0].tolist()
        try:
            at = np.array(list(joints_at(machine, reach, height, pitch=first).values()))
        except InputError:
            continue
        if arm.swing >= 0:
            at[arm.swing] = swing
        if followed_path(machine, other, at).all:
            return f"it can with a pitch of {amount(first, 'rad')} at its beginning; or shorten it"
    return "shorten it, or begin it elsewhere"


def _longs(points: np.ndarray) -> np.ndarray:
    """How long legs are, m; rad where the tip only turns."""
    ways = np.diff(points, axis=0)
    moved = np.hypot(ways[:, 0], ways[:, 1])
    return np.asarray(np.where(moved > 0.0, moved, np.abs(ways[:, 2:]).max(axis=1)))
