"""A machine as one body: weight, centre of gravity and its velocity, and the force and moment that the ground must bear."""

import numpy as np

from polydraulic.errors import InputError
from polydraulic.machine.frames import Frames, link_frames, vector
from polydraulic.machine.newton_euler import axis_of, needed_wrenches
from polydraulic.machine.stability.margins import MEASURES, N_STANDING, all_margins
from polydraulic.parameters.layout.chassis import Chassis
from polydraulic.parameters.layout.parts import GROUND
from polydraulic.parameters.layout.schema import LayoutMachine


def chassis_of(machine: LayoutMachine) -> Chassis:
    """What a machine stands on.

    Raises
    ------
    InputError
        Its file does not say so.
    """
    if machine.chassis is None:
        raise InputError(
            f"{machine.title}: its file has no [chassis], so that nobody knows what it stands on; add its contacts, mass and centre of gravity"
        )
    return machine.chassis


def standing_margins(
    machine: LayoutMachine, positions: np.ndarray, rates: np.ndarray, accelerations: np.ndarray, forces: np.ndarray
) -> np.ndarray:
    """Margins of `margins.EdgeMargins` over all edges of a machine, (n_row, n_edge, 5).

    Parameters
    ----------
    machine : LayoutMachine
        With its payload, and a chassis.
    positions, rates, accelerations : (n_row, n_function) array
        Of the joints.
    forces : (n_row, 3) array, N
        At the tip.

    Raises
    ------
    InputError
        A machine without a chassis.
    """
    corners = np.array(chassis_of(machine).corners)
    found = np.empty((len(positions), len(corners), len(MEASURES)))
    all_margins(corners, standing(machine, positions, rates, accelerations, forces), found)
    return found


def standing(
    machine: LayoutMachine, positions: np.ndarray, rates: np.ndarray, accelerations: np.ndarray, forces: np.ndarray
) -> np.ndarray:
    """Numbers of `margins.Standing`, (n_row, 16); arguments as of `standing_margins`."""
    chassis, frames = chassis_of(machine), link_frames(machine, positions)
    still = vector(chassis.cg)
    masses, moments, momentum = _first_moments(machine, frames, rates)
    whole = masses + chassis.mass
    cg = (moments + chassis.mass * still) / whole
    upright, upward = np.array([0.0, 0.0, 1.0]), np.array(chassis.upward)
    force = np.zeros((len(positions), 3)) - chassis.mass * machine.gravity * upright
    moment = np.cross(still, force)  # about the origin
    for name, needed in needed_wrenches(machine, frames, rates, accelerations, forces).items():
        moved = machine.function(name).moves
        if machine.link(moved).parent == GROUND:
            force = force - needed.force
            moment = moment - needed.moment - np.cross(frames[moved][1], needed.force)
    moment = moment - np.cross(cg, force)
    force = force + whole * machine.gravity * (upright - upward)  # weight acts at the centre of gravity
    found = np.empty((len(positions), N_STANDING))
    found[:, 0] = whole * machine.gravity
    found[:, 1:4], found[:, 4:7] = cg, momentum / whole
    found[:, 7:10], found[:, 10:13], found[:, 13:] = force, moment, upward
    return found


def _first_moments(machine: LayoutMachine, frames: Frames, rates: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass of all links, mass times place, and momentum, (n_row, 3)."""
    zero = np.zeros((len(rates), 3))
    spins, speeds = {GROUND: zero}, {GROUND: zero}
    mass, moments, momentum = 0.0, zero, zero
    for place, f in enumerate(machine.functions):
        link, (turn, origin) = machine.link(f.moves), frames[f.moves]
        along = axis_of(link, frames) * rates[:, place, None]
        spin, speed = spins[link.parent], speeds[link.parent]
        speed = speed + np.cross(spin, origin - frames[link.parent][1])
        if link.joint == "revolute":
            spin = spin + along
        else:
            speed = speed + along
        spins[link.name], speeds[link.name] = spin, speed
        centre = turn @ vector(link.cg)
        mass += link.mass
        moments = moments + link.mass * (origin + centre)
        momentum = momentum + link.mass * (speed + np.cross(spin, centre))
    return mass, moments, momentum
