"""What joints carry while nothing moves, and what their actuators can hold: torques, pressures and limits, pose by pose."""

from typing import NamedTuple

import numpy as np

from polydraulic.machine.drives import Motor, prepare_drive
from polydraulic.machine.joint_torques import torques_of_motion
from polydraulic.parameters.layout.geometry import lever
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine


class Levers(NamedTuple):
    """Torque over pressure of a function, m3 (force over pressure, m2): of line A, and of line B against it; (n_row,) each."""

    a: np.ndarray
    b: np.ndarray


def static_torques(machine: LayoutMachine, positions: np.ndarray, payload: float = 0.0) -> np.ndarray:
    """What each actuator must give so that the machine stands, towards positive positions.

    Parameters
    ----------
    machine : LayoutMachine
    positions : (n_row, n_function) array, rad or m
    payload : float, kg
        At the tip.

    Returns
    -------
    (n_row, n_function) array, N m or N
    """
    still = np.zeros_like(positions)
    return torques_of_motion(with_payload(machine, payload), positions, still, still)


def function_levers(machine: LayoutMachine, f: MachineFunction, positions: np.ndarray) -> Levers:
    """Torque over pressure of a function at positions (n_row,) of its joint; line A pushes towards positive positions.

    A linkage that cannot reach a position has no lever there, which is nan.
    """
    drive = prepare_drive(f, machine.link(f.moves))
    if isinstance(drive, Motor):
        one = np.full(len(positions), drive.displacement)
        return Levers(one, one)
    link = machine.link(f.moves)
    arms = [lever(f, link, float(position)) for position in positions]
    arm = np.abs(np.array([np.nan if value is None else value for value in arms]))
    return Levers(arm * drive.area_a, arm * drive.area_b)


def holding_pressures(machine: LayoutMachine, positions: np.ndarray, payload: float = 0.0) -> np.ndarray:
    """Pressures at A and B with which a machine stands, the lesser of both at that of the return line, (n_row, n_function, 2) in Pa.

    Parameters
    ----------
    machine : LayoutMachine
    positions : (n_row, n_function) array, rad or m
    payload : float, kg
        At the tip.
    """
    torques, rest = static_torques(machine, positions, payload), machine.tank.return_pressure
    found = np.empty((*positions.shape, 2))
    for place, f in enumerate(machine.functions):
        of = function_levers(machine, f, positions[:, place])
        excess = torques[:, place] - (of.a - of.b) * rest
        found[:, place, 0] = rest + np.maximum(excess, 0.0) / of.a
        found[:, place, 1] = rest + np.maximum(-excess, 0.0) / of.b
    return found
