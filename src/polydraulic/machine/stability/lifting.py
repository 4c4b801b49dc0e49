"""What a machine can lift in given poses, by the rule of ISO 10567 for excavators.

The lift capacity is the lower of 75 % of the load that tips the machine on level, firm ground and 87 % of the load that its hydraulics hold: one
function lifts at the working pressure, the pump's or the line's relief valve, and all others hold at those of their lines.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.machine.frames import link_frames, placed, vector
from polydraulic.machine.stability.statics import function_levers, static_torques
from polydraulic.machine.stability.whole_body import chassis_of
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine

TIPPING_SHARE, HYDRAULIC_SHARE = 0.75, 0.87
_TRIAL = 1000.0  # kg: torques are linear in the payload


class LiftLimits(NamedTuple):
    """Loads at the tip in kg, inf where nothing limits them, and what does; (n_row,) each.

    Attributes
    ----------
    tipping, hydraulic : arrays, kg
    edge, function : arrays of int
        Over which edge it tips, and which function gives way.
    capacity : array, kg
        By the rule.
    by_tipping : array of bool
        Which of the two limits it.
    """

    tipping: np.ndarray
    edge: np.ndarray
    hydraulic: np.ndarray
    function: np.ndarray
    capacity: np.ndarray
    by_tipping: np.ndarray


def lift_limits(machine: LayoutMachine, positions: np.ndarray, lifting: str) -> LiftLimits:
    """Limits in poses.

    Parameters
    ----------
    machine : LayoutMachine
        With a chassis; its slope is not read.
    positions : (n_row, n_function) array, rad or m
    lifting : str
        The function that lifts.

    Raises
    ------
    InputError
        A machine without a chassis or gravity.
    """
    if machine.gravity <= 0.0:
        raise InputError("gravity = 0: nothing is lifted without")
    tipping, edge = _tipping_loads(machine, positions)
    hydraulic, function = _hydraulic_loads(machine, positions, lifting)
    by_tipping = TIPPING_SHARE * tipping <= HYDRAULIC_SHARE * hydraulic
    capacity = np.where(by_tipping, TIPPING_SHARE * tipping, HYDRAULIC_SHARE * hydraulic)
    return LiftLimits(tipping, edge, hydraulic, function, capacity, by_tipping)


def _tipping_loads(machine: LayoutMachine, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Loads at which the common centre of gravity is above an edge: the least, and which edge, (n_row,) each."""
    chassis, frames = chassis_of(machine), link_frames(machine, positions)
    corners = np.array(chassis.corners)[:, :2]
    way = np.roll(corners, -1, axis=0) - corners
    inward = np.column_stack([-way[:, 1], way[:, 0]]) / np.linalg.norm(way, axis=1)[:, None]

    def inside(points: np.ndarray) -> np.ndarray:
        return np.asarray(((points[:, None, :2] - corners) * inward).sum(axis=2))

    kept = chassis.mass * inside(np.broadcast_to(vector(chassis.cg), (len(positions), 3)))
    for link in machine.links:
        turn, origin = frames[link.name]
        kept = kept + link.mass * inside(origin + turn @ vector(link.cg))
    outside = -inside(placed(frames, *machine.tip))
    loads = np.divide(kept, outside, out=np.full_like(kept, np.inf), where=outside > 0.0)
    loads = np.where(kept <= 0.0, 0.0, loads)  # it tips by itself
    return loads.min(axis=1), loads.argmin(axis=1)


def _hydraulic_loads(machine: LayoutMachine, positions: np.ndarray, lifting: str) -> tuple[np.ndarray, np.ndarray]:
    """Loads that all functions hold: the least, and whose, (n_row,) each."""
    bare = static_torques(machine, positions)
    more = (static_torques(machine, positions, _TRIAL) - bare) / _TRIAL
    loads = np.empty_like(bare)
    for place, f in enumerate(machine.functions):
        of, back = function_levers(machine, f, positions[:, place]), machine.tank.return_pressure
        most = working_pressure(machine, f) if f.name == lifting else f.line.relief
        up, down = most * of.a - back * of.b, most * of.b - back * of.a
        slope = more[:, place]
        room = np.where(slope > 0.0, up - bare[:, place], down + bare[:, place])
        steep = np.abs(slope) > 1e-9 * machine.gravity  # m; below, the load hangs on the joint itself
        own = np.divide(room, np.abs(slope), out=np.full_like(room, np.inf), where=steep)
        holds = (bare[:, place] <= up) & (-bare[:, place] <= down)
        loads[:, place] = np.where(holds, np.maximum(own, 0.0), 0.0)
    return loads.min(axis=1), loads.argmin(axis=1)


def working_pressure(machine: LayoutMachine, f: MachineFunction) -> float:
    """Pressure with which a function lifts, Pa: of its pump's relief valve, or of its line's if that opens first."""
    pump = next(c.pump for c in machine.circuits if f.name in c.functions)
    return min(pump.relief, f.line.relief)
