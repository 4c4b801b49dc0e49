"""What tasks know of a machine: its levers and joints, places that its tip can reach, poses at rest, lines along which it can move its tip."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.machine.reach.lines import SHORTEST, Followed, level_lines
from polydraulic.machine.reach.poses import ReachedPoses, reached_poses
from polydraulic.machine.reach.tip import slew_sign, tip_at_joints
from polydraulic.machine.reach.travels import JointTravels, inward, travels_of
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.input_check import full_lever
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import start_vector

_STARTS = 32
_SETTLING, _WATCHED, _STILL = 3.0, 1.0, 2e-3  # s, s, rad or m

Settle = Callable[[np.ndarray, float], np.ndarray]  # (m, n_state) states, s -> states after so long, levers centred


class Lines(NamedTuple):
    """Level lines, one from each start.

    Attributes
    ----------
    first, last : (n_start, 3) arrays, m
    speed : (n_start,) array, m/s
        At which joints can follow.
    """

    first: np.ndarray
    last: np.ndarray
    speed: np.ndarray


class Workspace(NamedTuple):
    """A machine as tasks know it.

    Attributes
    ----------
    machine : LayoutMachine
    travels : JointTravels
        Of its joints.
    lever : (n_function,) array, V
        Full lever.
    spool : (n_function,) array, m
        Full travel of the spools.
    relief : (n_function,) array, Pa
        Of the lines.
    slews : float
        See `slew_sign`.
    tips : (n_pose, 3) array, m
        Places that the tip can reach.
    starts : (n_start, n_state) array
        The machine at rest, in several poses.
    start_tips : (n_start, 3) array, m
    lines : Lines or None
        If they were asked for.
    """

    machine: LayoutMachine
    travels: JointTravels
    lever: np.ndarray
    spool: np.ndarray
    relief: np.ndarray
    slews: float
    tips: np.ndarray
    starts: np.ndarray
    start_tips: np.ndarray
    lines: Lines | None


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
        No line, or none at that depth; a machine that comes to rest nowhere.
    """
    travels = travels_of(machine)
    reached = reached_poses(travels)
    found = _lines(travels, reached, depth) if lines else None
    ends = (reached.positions if found is None else found.poses)[:_STARTS]
    states, still = _at_rest(machine, ends, settle)
    if not still.any():
        raise InputError(
            f"{machine.title!r} comes to rest in none of {len(states)} poses with centred levers: no task can begin"
        )
    at = _positions(machine, states[still])
    start_tips, way = tip_at_joints(machine, at), inward(machine, at)
    return Workspace(
        machine,
        travels,
        np.array([full_lever(f) for f in machine.functions]),
        np.array([f.valve.knots[-1] for f in machine.functions]),
        np.array([f.line.relief for f in machine.functions]),
        slew_sign(machine),
        reached.tips,
        states[still],
        start_tips,
        None
        if found is None
        else Lines(
            start_tips,
            start_tips + found.length[:_STARTS][still][:, None] * way,
            found.speed[:_STARTS][still],
        ),
    )


def _lines(travels: JointTravels, reached: ReachedPoses, depth: float | None) -> Followed:
    found = level_lines(travels, reached.positions, depth)
    if not len(found.poses):
        at = "" if depth is None else f" at depth = {depth:g} m"
        heights = reached.tips[:, 2]
        raise InputError(
            f"{travels.machine.title!r} can draw its tip along no level line of {SHORTEST} m{at}; "
            f"its tip reaches heights from {heights.min():.2f} to {heights.max():.2f} m"
        )
    return found


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
