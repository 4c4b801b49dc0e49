"""Poses of an arm whose tip is at given places: two joints that move it in its plane, the others held.

Two joints about parallel axes and their tip are a triangle of which all sides are known; it can lie on either side of the way to the place.
"""

from collections.abc import Mapping
from math import pi
from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.machine.frames import link_frames, placed
from polydraulic.machine.reach.tip import slewing_function, tip_links
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine


class ArmPoses(NamedTuple):
    """Poses for each of n places.

    Attributes
    ----------
    positions : (2, n, n_function) array, rad or m
        On either side.
    possible : (2, n) array of bool
        Whether the tip gets there between the stops.
    """

    positions: np.ndarray
    possible: np.ndarray


def arm_functions(
    machine: LayoutMachine, asked: tuple[str, str] | None = None
) -> tuple[MachineFunction, MachineFunction]:
    """The two functions that move the tip in the plane of the arm, that nearer to the ground first.

    Parameters
    ----------
    machine : LayoutMachine
    asked : (str, str), optional
        Their names; without, the first two that can.

    Raises
    ------
    InputError
        Functions that there are not, or that cannot.
    """
    carriers = [link.name for link in tip_links(machine)]
    able = [f for f in machine.functions if f.moves in carriers and _turns_in_plane(machine, f)]
    names = [f.name for f in able]
    wrong = [name for name in asked or () if name not in names]
    if wrong:
        raise InputError(f"{wrong[0]}: does not turn the tip in the plane of the arm; there are {names}")
    if asked is not None and asked[0] == asked[1]:
        raise InputError(f"{asked[0]}: name two different functions that move the tip; there are {names}")
    chosen = able[:2] if asked is None else [f for f in able if f.name in asked]
    if len(chosen) < 2:
        raise InputError(
            f"{machine.title}: a lift chart needs two functions that turn the tip about level axes, and there are {names or 'none'}"
        )
    others = [link.name for link in machine.links if link.axis[-1] == "z" and link is not _slewing_link(machine)]
    if others:
        raise InputError(
            f"links.{others[0]}: turns about z, so that the arm has no plane in which a lift chart could be drawn"
        )
    return chosen[0], chosen[1]


def _slewing_link(machine: LayoutMachine) -> object:
    slews = slewing_function(machine)
    return None if slews is None else machine.link(slews.moves)


def _turns_in_plane(machine: LayoutMachine, f: MachineFunction) -> bool:
    link = machine.link(f.moves)
    return link.joint == "revolute" and link.axis[-1] == "y"


def held_positions(machine: LayoutMachine, held: Mapping[str, float]) -> np.ndarray:
    """Positions of all joints, (n_function,): the initial ones, or those that are given.

    Raises
    ------
    InputError
        A function that there is not, or a position beyond its stops.
    """
    found = np.array([f.initial.angle for f in machine.functions])
    for name, value in held.items():
        if name not in machine.names:
            raise InputError(f"{name!r} is not a function of the machine; there are {list(machine.names)}")
        f = machine.function(name)
        unit = "m" if machine.link(f.moves).joint == "prismatic" else "rad"
        if not f.stops.low <= value <= f.stops.high:
            low, high, shown = (amount(v, unit) for v in (*f.stops, value))
            raise InputError(f"{name} = {shown}: beyond its stops, {low} to {high}")
        found[machine.names.index(name)] = value
    return found


def arm_poses(
    machine: LayoutMachine, pair: tuple[MachineFunction, MachineFunction], held: np.ndarray, places: np.ndarray
) -> ArmPoses:
    """Poses with the tip at places in the plane of the arm.

    Parameters
    ----------
    machine : LayoutMachine
    pair : (MachineFunction, MachineFunction)
        From `arm_functions`.
    held : (n_function,) array
        Positions of the other joints; that of the slewing joint is taken as 0.
    places : (n, 2) array, m
        x and z of the ground's frame, while the slewing joint is at 0.
    """
    at = [machine.names.index(f.name) for f in pair]
    base = held.copy()
    slews = slewing_function(machine)
    if slews is not None:
        base[machine.names.index(slews.name)] = 0.0
    base[at] = 0.0
    frames = link_frames(machine, base)
    signs = [1.0 if machine.link(f.moves).axis == "-y" else -1.0 for f in pair]  # turns x towards z
    first, second = (frames[f.moves][1][[0, 2]] for f in pair)
    tip = placed(frames, *machine.tip)[[0, 2]]
    inner, outer, way = second - first, tip - second, places - first
    r1, r2, far = np.hypot(*inner), np.hypot(*outer), np.hypot(*way.T)
    share = (r1 * r1 + far * far - r2 * r2) / np.maximum(2.0 * r1 * far, 1e-300)
    reached = (np.abs(share) <= 1.0) & (min(r1, r2) > 0.0)
    opening = np.arccos(np.clip(share, -1.0, 1.0))
    positions = np.tile(base, (2, len(places), 1))
    possible = np.tile(reached, (2, 1))
    for side, sign in enumerate((1.0, -1.0)):
        along = np.arctan2(way[:, 1], way[:, 0]) + sign * opening
        knee = r1 * np.column_stack([np.cos(along), np.sin(along)])
        on = way - knee
        turned = along - np.arctan2(inner[1], inner[0])
        bent = np.arctan2(on[:, 1], on[:, 0]) - np.arctan2(outer[1], outer[0]) - turned
        for f, place, sense, angle in zip(pair, at, signs, (turned, bent), strict=True):
            positions[side, :, place], inside = _between(sense * angle, f)
            possible[side] &= inside
    return ArmPoses(positions, possible)


def _between(angle: np.ndarray, f: MachineFunction) -> tuple[np.ndarray, np.ndarray]:
    """Angles by whole turns into the range of a joint, and where that can be."""
    low, high = f.stops
    found = low + np.mod(angle - low, 2.0 * pi)
    found = np.where(np.abs(found - 2.0 * pi - low) < 1e-9, low, found)  # at the stop, but for rounding
    inside = found <= high + 1e-9
    return np.minimum(found, high), inside
