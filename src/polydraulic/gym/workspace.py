"""What tasks know of a machine: its levers and joints, poses that it can stand in and reach, lines along which it can move its tip."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.gym.kinematics import joint_speeds, slew_sign, tip_at_joints, tip_jacobian
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import start_vector
from polydraulic.simulation.stepping.levers import full_lever

_POSES, _TRIED, _STARTS = 4096, 256, 32  # reached, tried as ends of lines, where episodes begin
_SLEW = np.pi / 3.0  # rad, to either side, of joints that turn all the way round
_INNER = 0.1  # of the travel, at each end, where no pose lies
_NEAR = 0.3  # of the largest reach, where the machine itself stands
_SETTLING, _WATCHED, _STILL = 3.0, 1.0, 2e-3  # s, s, rad or m
_STEP = 0.02  # m, of a line
_SHORTEST, _LONGEST = 0.5, 4.0  # m
_SLOWEST, _FASTEST = 0.1, 0.3  # m/s, along a line
STROKE, ROUND = (
    5.0,
    0.6,
)  # s, that a full stroke takes at full lever in machines of this kind; rad/s of joints that turn all the way round
_SHARE = 0.5  # of that speed, which a line may ask of a joint

Settle = Callable[
    [np.ndarray, float], np.ndarray
]  # (m, n_state) states and s -> states after so long with centred levers


class Lines(NamedTuple):
    """Level lines along which a machine can draw its tip: first (n, 3) and last (n, 3) point in m, and how fast, (n,) m/s."""

    first: np.ndarray
    last: np.ndarray
    speed: np.ndarray


class Workspace(NamedTuple):
    """A machine as tasks know it.

    Attributes
    ----------
    machine : LayoutMachine
    low, high : (n_function,) arrays, rad or m
        End stops; of joints that turn all the way round, how far they are turned here.
    turns : (n_function,) array of bool
        Whether a joint turns all the way round.
    full : (n_function,) array, V
        Full lever.
    travel : (n_function,) array, m
        Of the spools.
    relief : (n_function,) array, Pa
        Of the lines.
    slews : float
        See `kinematics.slew_sign`.
    tips : (n_pose, 3) array, m
        Places that the tip can reach.
    starts : (n_start, n_state) array
        The machine at rest, in several poses.
    start_tips : (n_start, 3) array, m
    lines : Lines
        From each start inward; none if they were not asked for.
    """

    machine: LayoutMachine
    low: np.ndarray
    high: np.ndarray
    turns: np.ndarray
    full: np.ndarray
    travel: np.ndarray
    relief: np.ndarray
    slews: float
    tips: np.ndarray
    starts: np.ndarray
    start_tips: np.ndarray
    lines: Lines


def workspace_of(
    machine: LayoutMachine, settle: Settle, *, lines: bool = False, depth: float | None = None
) -> Workspace:
    """Look where a machine can be, and let it come to rest in some of these poses.

    Parameters
    ----------
    machine : LayoutMachine
    settle : function
        Moves the machine with centred levers.
    lines : bool
        Whether starts are to be those of lines.
    depth : float, m, optional
        Height of all lines, as the ground's z.

    Raises
    ------
    InputError
        A depth at which there is no line, a machine that comes to rest nowhere.
    """
    stops = np.array([(f.stops.low, f.stops.high) for f in machine.functions])
    initial = np.array([f.initial.angle for f in machine.functions])
    revolute = np.array([machine.link(f.moves).joint == "revolute" for f in machine.functions])
    turns = revolute & (np.ptp(stops, axis=1) > 2.0 * np.pi)
    low = np.where(turns, initial - _SLEW, stops[:, 0])
    high = np.where(turns, initial + _SLEW, stops[:, 1])
    poses = _poses(machine, low, high)
    nought = np.zeros(len(poses))
    ends, length, speed = _line_poses(machine, low, high, poses, depth) if lines else (poses, nought, nought)
    states, still = _at_rest(machine, ends[:_STARTS], settle)
    if not still.any():
        raise InputError(
            f"{machine.title!r} comes to rest in none of {len(states)} poses with centred levers: no task can begin"
        )
    states, length, speed = states[still], length[:_STARTS][still], speed[:_STARTS][still]
    at = _positions(machine, states)
    tips = tip_at_joints(machine, at)
    return Workspace(
        machine,
        low,
        high,
        turns,
        np.array([full_lever(f) for f in machine.functions]),
        np.array([f.valve.knots[-1] for f in machine.functions]),
        np.array([f.line.relief for f in machine.functions]),
        slew_sign(machine),
        tip_at_joints(machine, poses),
        states,
        tips,
        Lines(tips, tips + length[:, None] * _inward(machine, at), speed),
    )


def _poses(machine: LayoutMachine, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Joint positions away from stops in which the tip is not where the machine stands, (n, n_function)."""
    share = np.random.default_rng(0).uniform(_INNER, 1.0 - _INNER, (2 * _POSES, len(low)))
    poses = low + (high - low) * share
    reach = np.linalg.norm(_outward(machine, tip_at_joints(machine, poses)), axis=1)
    return poses[reach > _NEAR * reach.max()][:_POSES]


def _outward(machine: LayoutMachine, tips: np.ndarray) -> np.ndarray:
    """From the first joint to the tip, level, (n, 2) in m."""
    at = machine.link(machine.functions[0].moves).at
    return np.asarray(tips[:, :2] - (at.get("x", 0.0), at.get("y", 0.0)))


def _inward(machine: LayoutMachine, positions: np.ndarray) -> np.ndarray:
    """Level direction from the tip to the machine in the plane of its arm, (n, 3)."""
    heading = slew_sign(machine) * positions[:, 0]
    plane = np.column_stack([np.cos(heading), np.sin(heading)])
    away = np.sign((_outward(machine, tip_at_joints(machine, positions)) * plane).sum(axis=1, keepdims=True))
    return np.column_stack([-away * plane, np.zeros(len(positions))])


def _line_poses(
    machine: LayoutMachine, low: np.ndarray, high: np.ndarray, poses: np.ndarray, depth: float | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poses at the outer ends of level lines, the longest first; how long these are, m, and how fast joints can follow, m/s."""
    poses = poses[:_TRIED]
    if depth is not None:
        rise = depth - tip_at_joints(machine, poses)[:, 2]
        poses, gone, _ = _drawn(machine, low, high, poses, np.sign(rise)[:, None] * (0.0, 0.0, 1.0), np.abs(rise))
        poses = poses[gone > np.abs(rise) - 1e-9]
    length = speed = np.zeros(0)
    if len(poses):
        most = np.full(len(poses), _LONGEST)
        _, length, speed = _drawn(machine, low, high, poses, _inward(machine, poses), most, _SLOWEST)
    long = length >= _SHORTEST
    if not long.any():
        heights = tip_at_joints(machine, _poses(machine, low, high))[:, 2]
        at = (
            "at any height"
            if depth is None
            else f"at depth = {depth:g} m; its tip reaches heights from {heights.min():.2f} to {heights.max():.2f} m"
        )
        raise InputError(f"{machine.title!r} can draw its tip along no level line of {_SHORTEST} m {at}")
    order = np.argsort(-length[long], kind="stable")
    return poses[long][order], length[long][order], speed[long][order]


def _drawn(
    machine: LayoutMachine,
    low: np.ndarray,
    high: np.ndarray,
    poses: np.ndarray,
    direction: np.ndarray,
    length: np.ndarray,
    slowest: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Draw tips along lines as long as joints stay away from their stops and can follow: where they end, how far they have come, how fast."""
    room = _INNER / 2.0 * (high - low)
    free = high - low
    if slew_sign(machine):
        free = np.concatenate([[0.0], free[1:]])
    first, poses, gone = tip_at_joints(machine, poses), poses.copy(), np.zeros(len(poses))
    speed, able = np.full(len(poses), _FASTEST), _SHARE * full_speeds(machine, low, high)
    going = np.ones(len(poses), dtype=bool)
    for _ in range(int(length.max() / _STEP) + 1):
        step = np.minimum(_STEP, length[going] - gone[going])
        on = gone[going] + step
        wanted, tried = first[going] + on[:, None] * direction[going], poses[going]
        for _ in range(2):
            tried = tried + joint_speeds(tip_jacobian(machine, tried), wanted - tip_at_joints(machine, tried), free)
        inside = ((tried > low + room) & (tried < high - room)).all(axis=1)
        good = inside & (np.linalg.norm(wanted - tip_at_joints(machine, tried), axis=1) < 5e-3)
        turned = np.abs(tried - poses[going]) / np.maximum(step, 1e-9)[:, None]  # rad or m of a joint for each m
        fast = np.minimum(speed[going], (able / np.maximum(turned, 1e-9)).min(axis=1))
        good &= fast >= slowest
        at = np.flatnonzero(going)
        speed[at[good]] = fast[good]
        poses[at[good]], gone[at[good]] = tried[good], on[good]
        going[at] = good & (on < length[going] - 1e-9)
        if not going.any():
            break
    return poses, gone, speed


def full_speeds(machine: LayoutMachine, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """What joints do at full lever, roughly, (n_function,) rad/s or m/s; from travels as those of `Workspace`."""
    stops = np.array([f.stops.high - f.stops.low for f in machine.functions])
    return np.where(stops > high - low + 1e-9, ROUND, (high - low) / STROKE)


def _at_rest(machine: LayoutMachine, poses: np.ndarray, settle: Settle) -> tuple[np.ndarray, np.ndarray]:
    """States after a while in these poses with centred levers, and which of them stand still."""
    place = columns_of(machine).place
    states = np.tile(start_vector(machine), (len(poses), 1))
    states[:, [place[f"{f}.angle"] for f in machine.names]] = poses
    before = settle(states, _SETTLING)
    states = settle(before, _WATCHED)
    crept = np.abs(_positions(machine, states) - _positions(machine, before)).max(axis=1)
    return states, np.isfinite(states).all(axis=1) & (crept < _STILL)


def _positions(machine: LayoutMachine, states: np.ndarray) -> np.ndarray:
    place = columns_of(machine).place
    return np.asarray(states[:, [place[f"{f}.angle"] for f in machine.names]])
