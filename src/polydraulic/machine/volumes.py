"""What a joint's position says of the oil in its actuator: levers, and the volumes of both sides."""

from functools import lru_cache

import numpy as np

from polydraulic.machine.drives import Motor, Ram, prepare_drive
from polydraulic.parameters.layout.geometry import lever
from polydraulic.parameters.layout.parts import LinkParameters, MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine

_GRID = 721  # positions at which levers are known, straight between


def levers(machine: LayoutMachine, f: MachineFunction, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Volume that a radian or metre draws from line A and gives to line B, in the shape of the positions."""
    link, drive = machine.link(f.moves), prepare_drive(f, machine.link(f.moves))
    if isinstance(drive, Motor):
        return np.full(np.shape(position), drive.displacement), np.full(np.shape(position), drive.displacement)
    if isinstance(drive, Ram):
        return np.full(np.shape(position), drive.area_a), np.full(np.shape(position), drive.area_b)
    grid, arms = _arms(_Geometry(f, link))
    arm = np.interp(position, grid, arms)
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


class _Geometry:
    """A function and its link, the same as any others with the same text: pins are mappings, which have no hash."""

    def __init__(self, f: MachineFunction, link: LinkParameters) -> None:
        self.f, self.link = f, link
        self.text = repr((f.actuator, f.drive, f.pins, f.stops, link))

    def __hash__(self) -> int:
        return hash(self.text)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Geometry) and self.text == other.text


@lru_cache(maxsize=64)
def _arms(of: _Geometry) -> tuple[np.ndarray, np.ndarray]:
    """Positions, and levers there in m: hundreds of them, which are asked for again and again."""
    grid = lever_grid(of.f)
    return grid, np.array([abs(lever(of.f, of.link, angle) or 0.0) for angle in grid.tolist()])


def lever_grid(f: MachineFunction) -> np.ndarray:
    """Positions from stop to stop, between which levers are straight lines."""
    return np.linspace(f.stops.low, f.stops.high, _GRID)
