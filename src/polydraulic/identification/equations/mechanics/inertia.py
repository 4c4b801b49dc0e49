"""Torques of a tree are linear in mass, first and second moments of its links: these numbers, and what they are multiplied by.

Of a link: mass m, first moments h = m c and inertia J about its joint, along the axes of its frame. Force and moment about the joint that a link
needs to move as it does are linear in them (Atkeson, An and Hollerbach, Int. J. Robotics Research 5 (1986) 101), and so is their
part along each joint's axis. Only numbers that the layout declares, or that follow from those, have a column.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.machine.frames import link_frames
from polydraulic.machine.newton_euler import axis_of, link_motions, tensor_of
from polydraulic.parameters.layout.parts import COORDINATES, GROUND, MOMENTS, LinkParameters
from polydraulic.parameters.layout.schema import LayoutMachine

_PAIRS = {key: (COORDINATES.index(key[0]), COORDINATES.index(key[1])) for key in MOMENTS}


class Inertial(NamedTuple):
    """One number of a link: ``mass``, a first moment ``h.x`` in kg m, or inertia about the joint ``J.yy`` in kg m2."""

    link: str
    kind: str

    @property
    def text(self) -> str:
        """As people read it: ``boom h.x``."""
        return f"{self.link} {self.kind}"


def inertial_numbers(machine: LayoutMachine) -> list[Inertial]:
    """Numbers of all links, in the order of the functions."""
    found = []
    for f in machine.functions:
        link = machine.link(f.moves)
        centre = link.cg if link.mass > 0.0 else {}
        kinds = ["mass"] if link.mass > 0.0 else []
        kinds += [f"h.{c}" for c in COORDINATES if c in centre]
        kinds += [f"J.{key}" for key in MOMENTS if key in link.inertia or _follows(key, centre)]
        found += [Inertial(link.name, kind) for kind in kinds]
    return found


def inertial_values(machine: LayoutMachine, numbers: Sequence[Inertial]) -> np.ndarray:
    """Their values in a machine, (n,)."""
    found = []
    for number in numbers:
        link = machine.link(number.link)
        kind, _, key = number.kind.partition(".")
        if kind == "mass":
            found.append(link.mass)
        elif kind == "h":
            found.append(link.mass * link.cg.get(key, 0.0))
        else:
            found.append(_about_joint(link)[_PAIRS[key]])
    return np.array(found)


def torque_regressor(
    machine: LayoutMachine,
    numbers: Sequence[Inertial],
    position: np.ndarray,
    rate: np.ndarray,
    acceleration: np.ndarray,
    gravity: float,
) -> np.ndarray:
    """What each number is multiplied by in the torques that a motion needs.

    Parameters
    ----------
    machine : LayoutMachine
        Its masses do not matter.
    numbers : sequence of Inertial
    position, rate, acceleration : (n_row, n_function) array
        Of the joints.
    gravity : float, m/s2

    Returns
    -------
    (n_row, n_function, n) array
        Torque in N m, or force in N of a joint that slides, for each unit of a number.
    """
    frames = link_frames(machine, position)
    motions = link_motions(machine, frames, rate, acceleration)
    places = {f.moves: k for k, f in enumerate(machine.functions)}
    found = np.zeros((*position.shape, len(numbers)))
    for name in places:
        own = [k for k, number in enumerate(numbers) if number.link == name]
        if not own:
            continue
        force, moment = _needed(machine.link(name), frames[name][0], motions[name], gravity)
        origin, joint = frames[name][1], name
        columns = [_COLUMN[numbers[k].kind] for k in own]
        while joint != GROUND:
            link = machine.link(joint)
            axis = axis_of(link, frames)
            if link.joint == "prismatic":
                along = np.einsum("ti,tic->tc", axis, force)
            else:
                arm = np.cross(axis, origin - frames[joint][1])  # axis . (arm x force) = (axis x arm) . force
                along = np.einsum("ti,tic->tc", axis, moment) + np.einsum("ti,tic->tc", arm, force)
            found[:, places[joint], own] = along[:, columns]
            joint = link.parent
    return found


_COLUMN: Mapping[str, int] = {
    name: k for k, name in enumerate(["mass", *(f"h.{c}" for c in COORDINATES), *(f"J.{key}" for key in MOMENTS)])
}


def _needed(
    link: LinkParameters, turn: np.ndarray, motion: tuple[np.ndarray, np.ndarray, np.ndarray], gravity: float
) -> tuple[np.ndarray, np.ndarray]:
    """Force and moment about the joint for each unit of mass, h and J, along the ground's axes; (n_row, 3, 10) each."""
    spin, twist, at = motion
    own = np.swapaxes(turn, -1, -2)
    w, a, lift = (np.einsum("tij,tj->ti", own, v) for v in (spin, twist, at + np.array([0.0, 0.0, gravity])))
    force, moment = np.zeros((len(w), 3, 10)), np.zeros((len(w), 3, 10))
    force[:, :, 0] = lift
    force[:, :, 1:4] = _crossing(a) + _crossing(w) @ _crossing(w)
    moment[:, :, 1:4] = -_crossing(lift)
    moment[:, :, 4:] = _times_tensor(a) + _crossing(w) @ _times_tensor(w)
    return turn @ force, turn @ moment


def _crossing(v: np.ndarray) -> np.ndarray:
    """Matrices of v x, (n_row, 3, 3)."""
    x, y, z = v.T
    zero = np.zeros_like(x)
    return np.stack([np.stack(row, axis=-1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))], axis=-2)


def _times_tensor(v: np.ndarray) -> np.ndarray:
    """J v for each unit of an entry of J, (n_row, 3, 6)."""
    found = np.zeros((len(v), 3, len(MOMENTS)))
    for k, (i, j) in enumerate(_PAIRS.values()):
        found[:, i, k] += v[:, j]
        if i != j:
            found[:, j, k] += v[:, i]
    return found


def _follows(key: str, centre: Mapping[str, float]) -> bool:
    """Whether inertia about the joint follows from where the centre of gravity may lie."""
    if key[0] != key[1]:
        return key[0] in centre and key[1] in centre
    return any(c in centre for c in COORDINATES if c != key[0])


def _about_joint(link: LinkParameters) -> np.ndarray:
    centre = np.array([link.cg.get(c, 0.0) for c in COORDINATES])
    return tensor_of(link) + link.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
