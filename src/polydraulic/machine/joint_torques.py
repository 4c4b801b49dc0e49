"""Torques at joints, on arrays of positions and rates: what a motion needs, and what friction takes."""

import numpy as np

from polydraulic.machine.frames import link_frames
from polydraulic.machine.newton_euler import axis_of, needed_wrenches
from polydraulic.parameters.layout.schema import LayoutMachine

_FRICTION_SPREAD = 0.1  # how well friction of what moves is known


def torques_of_motion(machine: LayoutMachine, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """What actuators must give for a motion, towards positive positions, friction aside.

    Parameters
    ----------
    machine : LayoutMachine
    q, qd, qdd : (n_row, n_function) array, rad or m, and per s and s2
        Positions, rates and accelerations of joints.

    Returns
    -------
    (n_row, n_function) array, N m or N
    """
    frames = link_frames(machine, q)
    wrenches = needed_wrenches(machine, frames, qd, qdd, np.zeros((len(q), 3)))
    found = np.empty_like(q)
    for k, f in enumerate(machine.functions):
        link = machine.link(f.moves)
        carried = wrenches[f.name].moment if link.joint == "revolute" else wrenches[f.name].force
        found[:, k] = (carried * axis_of(link, frames)).sum(axis=1)
    return found


def torques_of_friction(machine: LayoutMachine, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Friction of each joint, and its standard deviation: at rest anything up to static friction.

    Parameters
    ----------
    machine : LayoutMachine
    rate : (n_row, n_function) array, rad/s or m/s

    Returns
    -------
    friction, unsure : (n_row, n_function) array, N m or N
    """
    friction, unsure = np.empty_like(rate), np.empty_like(rate)
    for k, f in enumerate(machine.functions):
        w, of = rate[:, k], f.friction
        level = of.coulomb + (of.static - of.coulomb) * np.exp(-((w / of.stribeck) ** 2))
        side = np.tanh(w / of.smoothing)
        friction[:, k] = level * side + of.viscous * w
        held = of.static / np.sqrt(3.0) * (1.0 - side**2)
        unsure[:, k] = np.hypot(_FRICTION_SPREAD * np.abs(friction[:, k]), held)
    return friction, unsure
