"""What a joint's position says of the oil in its actuator: levers, and the volumes of both sides."""

import numpy as np

from polydraulic.machine.drives import Motor, Ram, prepare_drive
from polydraulic.parameters.layout.geometry import lever
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine

_GRID = 721  # positions at which levers are known, straight between


def levers(machine: LayoutMachine, f: MachineFunction, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Volume that a radian or metre draws from line A and gives to line B, in the shape of the positions."""
    link, drive = machine.link(f.moves), prepare_drive(f, machine.link(f.moves))
    if isinstance(drive, Motor):
        return np.full(np.shape(position), drive.displacement), np.full(np.shape(position), drive.displacement)
    if isinstance(drive, Ram):
        return np.full(np.shape(position), drive.area_a), np.full(np.shape(position), drive.area_b)
    grid = lever_grid(f)
    arm = np.interp(position, grid, [abs(lever(f, link, angle) or 0.0) for angle in grid.tolist()])
    return arm * drive.area_a, arm * drive.area_b


def side_volumes(machine: LayoutMachine, f: MachineFunction, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Volumes of the actuator's two sides, but for a constant, in m3 and the shape of the positions; what one gains the other loses."""
    if f.pins is None:
        a, b = levers(machine, f, position)
        return a * position, -b * position
    grid = lever_grid(f)
    a, b = levers(machine, f, grid)
    step = np.diff(grid)
    grown = [np.concatenate([[0.0], np.cumsum(0.5 * (side[1:] + side[:-1]) * step)]) for side in (a, b)]
    return np.interp(position, grid, grown[0]), -np.interp(position, grid, grown[1])


def lever_grid(f: MachineFunction) -> np.ndarray:
    """Positions from stop to stop, between which levers are straight lines."""
    return np.linspace(f.stops.low, f.stops.high, _GRID)
