"""Newton and Euler along a tree of links: how each link moves, and what it needs from its parent to move so."""

from typing import NamedTuple

import numpy as np

from polydraulic.machine.frames import Frames, placed, vector
from polydraulic.parameters.layout.parts import COORDINATES, GROUND, LinkParameters
from polydraulic.parameters.layout.schema import LayoutMachine


class Wrench(NamedTuple):
    """Force, and moment about a joint, on a link along the ground's axes; (n_row, 3) each."""

    force: np.ndarray
    moment: np.ndarray


class LinkMotion(NamedTuple):
    """How a link moves, along the ground's axes; (n_row, 3) each.

    Attributes
    ----------
    spin, twist : arrays, rad/s, rad/s2
        Its angular rate and acceleration.
    at : array, m/s2
        Acceleration of its joint.
    """

    spin: np.ndarray
    twist: np.ndarray
    at: np.ndarray


def link_motions(
    machine: LayoutMachine, frames: Frames, rates: np.ndarray, accelerations: np.ndarray
) -> dict[str, LinkMotion]:
    """Motion of every link, and of the ground, from rates and accelerations (n_row, n_function) of the joints."""
    zero = np.zeros((len(rates), 3))
    found = {GROUND: LinkMotion(zero, zero, zero)}
    for place, f in enumerate(machine.functions):
        link = machine.link(f.moves)
        w, a = rates[:, place, None], accelerations[:, place, None]
        axis, parent = axis_of(link, frames), link.parent
        spin, twist, at = found[parent]
        arm = frames[link.name][1] - frames[parent][1]
        at = at + np.cross(twist, arm) + _centripetal(spin, arm)
        if link.joint == "revolute":
            twist = twist + axis * a + np.cross(spin, axis * w)
            spin = spin + axis * w
        else:
            at = at + axis * a + 2.0 * np.cross(spin, axis * w)
        found[link.name] = LinkMotion(spin, twist, at)
    return found


def needed_wrenches(
    machine: LayoutMachine, frames: Frames, rates: np.ndarray, accelerations: np.ndarray, forces: np.ndarray
) -> dict[str, Wrench]:
    """What passes from a parent to each link, by the name of its function, with that of its actuator.

    Parameters
    ----------
    machine : LayoutMachine
    frames : Frames
        Of the links.
    rates, accelerations : (n_row, n_function) array
        Of the joints.
    forces : (n_row, 3) array, N
        At the tip.
    """
    motions = link_motions(machine, frames, rates, accelerations)
    needed: dict[str, Wrench] = {}
    for f in machine.functions:
        link = machine.link(f.moves)
        turn, origin = frames[link.name]
        spin, twist, at = motions[link.name]
        centre = turn @ vector(link.cg)
        own = at + np.cross(twist, centre) + _centripetal(spin, centre)
        force = link.mass * (own + np.array([0.0, 0.0, machine.gravity]))
        tensor = turn @ tensor_of(link) @ np.swapaxes(turn, -1, -2)
        turned = np.einsum("tij,tj->ti", tensor, twist)
        whirl = np.cross(spin, np.einsum("tij,tj->ti", tensor, spin))
        moment = turned + whirl + np.cross(centre, force)
        if link.name == machine.tip[0]:
            reach = placed(frames, *machine.tip) - origin
            force, moment = force - forces, moment - np.cross(reach, forces)
        needed[link.name] = Wrench(force, moment)
    for f in reversed(machine.functions):
        link = machine.link(f.moves)
        if link.parent != GROUND:
            own, before = needed[link.name], needed[link.parent]
            arm = frames[link.name][1] - frames[link.parent][1]
            moment = before.moment + own.moment + np.cross(arm, own.force)
            needed[link.parent] = Wrench(before.force + own.force, moment)
    return {f.name: needed[f.moves] for f in machine.functions}


def axis_of(link: LinkParameters, frames: Frames) -> np.ndarray:
    """Direction of a joint's positive motion along the ground's axes, (..., 3)."""
    sign = -1.0 if link.axis[0] == "-" else 1.0
    return np.asarray(sign * frames[link.parent][0][..., COORDINATES.index(link.axis[-1])])


def _centripetal(spin: np.ndarray, arm: np.ndarray) -> np.ndarray:
    return np.cross(spin, np.cross(spin, arm))


def tensor_of(link: LinkParameters) -> np.ndarray:
    """Inertia about a link's centre of gravity, (3, 3) in kg m2."""
    found = np.zeros((3, 3))
    for key, value in link.inertia.items():
        i, j = (COORDINATES.index(c) for c in key)
        found[i, j] = found[j, i] = value
    return found
