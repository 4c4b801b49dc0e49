"""Forces of a run, as columns: of actuators, of friction, and what each joint's pin carries.

Newton and Euler from the tips to the ground: what the links behind a joint need to move as they do, less gravity and what pushes at the
tip, passes from its parent through the actuator and the pin. The pin carries all but the force of the cylinder (of a bucket's linkage, of
its coupler). Its moment about the joint's axis is what acts on the joint itself: a motor's torque, less friction, and what an end stop gives.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from polydraulic.machine.drives import Motor
from polydraulic.machine.frames import Frames, link_frames, placed
from polydraulic.machine.newton_euler import Wrench, axis_of, needed_wrenches
from polydraulic.parameters.layout.geometry import knee_at, rocker
from polydraulic.parameters.layout.parts import COORDINATES, FourBar, LinkParameters, MachineFunction, Pins
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import AddedColumn, Columns

_ACROSS = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}


def force_columns(
    machine: LayoutMachine,
    module: Any,
    plant: Any,
    rows: np.ndarray,
    columns: Columns,
    forces: np.ndarray,
    locked: tuple[str, ...],
) -> Iterator[AddedColumn]:
    """Columns of forces of the functions that are not locked.

    Parameters
    ----------
    machine : LayoutMachine
    module, plant
        As prepared for the run.
    rows : (n_row, n_column) array
        Recorded.
    columns : Columns
        What stands where in them.
    forces : (n_row, 3) array, N
        At the tip.
    locked : tuple of str

    Yields
    ------
    AddedColumn
        ``FUNCTION.cylinder_force``, p_a A_a - p_b A_b of all its cylinders, in N, or ``.motor_torque``, at the joint, in N m (``.motor_force``
        in N of a rack): positive towards positive positions. ``.friction_torque`` (``.friction_force`` of a prismatic joint): against positive rates.
        ``.pin_force_x``, ``_y``, ``_z`` in N and ``.pin_moment_x``, ``_y``, ``_z`` in N m, about the joint: of the parent on the link,
        along the ground's axes, without the force of a cylinder or coupler; of the step that begins at a row, so that a stop that is met
        then gives the mean of its blow over the step.
    """

    def of(quantity: str) -> np.ndarray:
        return rows[:, [columns.place[f"{f}.{quantity}"] for f in machine.names]]

    found = np.empty((len(rows), 3 * len(machine.names)))
    module.torques(plant, np.ascontiguousarray(rows), forces, found)
    frames = link_frames(machine, of("angle"))
    passed = needed_wrenches(machine, frames, of("rate"), found[:, 2::3], forces)
    for place, f in enumerate(machine.functions):
        if f.name in locked:
            continue
        oil, drive = found[:, 3 * place], getattr(plant, f.name).drive
        slides = machine.link(f.moves).joint == "prismatic"
        kind, unit = ("force", "N") if slides else ("torque", "N m")
        push = oil
        if isinstance(drive, Motor):
            yield AddedColumn(f"{f.name}.motor_{kind}", unit, oil)
        else:
            p_a, p_b = (rows[:, columns.place[f"{f.name}.{p}"]] for p in ("p_a", "p_b"))
            push = np.where(oil == 0.0, 0.0, p_a * drive.area_a - p_b * drive.area_b)  # none within its play
            yield AddedColumn(f"{f.name}.cylinder_force", "N", push)
        yield AddedColumn(f"{f.name}.friction_{kind}", unit, found[:, 3 * place + 1])
        pin = _without_actuator(machine, f, frames, passed[f.name], push, oil)
        for name, values, of_unit in (("pin_force", pin.force, "N"), ("pin_moment", pin.moment, "N m")):
            for c, direction in enumerate(COORDINATES):
                yield AddedColumn(f"{f.name}.{name}_{direction}", of_unit, values[:, c])


def _without_actuator(
    machine: LayoutMachine, f: MachineFunction, frames: Frames, passed: Wrench, push: np.ndarray, oil: np.ndarray
) -> Wrench:
    """What is left for the pin; `push` of the cylinders and `oil` at the joint towards positive positions."""
    link, origin = machine.link(f.moves), frames[f.moves][1]
    axis = axis_of(link, frames)
    if f.actuator == "ram":  # along the axis through the joint
        return passed._replace(force=passed.force - push[:, None] * axis)
    if isinstance(f.pins, Pins):
        base, rod = placed(frames, link.parent, f.pins.base), placed(frames, link.name, f.pins.rod)
        at, along = rod - origin, rod - base
    elif isinstance(f.pins, FourBar):
        along = _from_knee(f.pins, link, frames)
        at = placed(frames, link.name, f.pins.pin) - origin
    else:
        return passed
    along = along / np.linalg.norm(along, axis=1)[:, None]
    lever = (np.cross(at, along) * axis).sum(1)  # a force along the cylinder or the coupler gives the oil's torque
    force = (oil / lever)[:, None] * along
    return Wrench(passed.force - force, passed.moment - np.cross(at, force))


def _from_knee(pins: FourBar, link: LinkParameters, frames: Frames) -> np.ndarray:
    """The coupler from knee to pin, along the ground's axes."""
    parent, own = frames[link.parent][0], frames[link.name][0]
    first, second = _ACROSS[link.axis[-1]]
    first, second = (second, first) if link.axis[0] == "-" else (first, second)
    turned = np.swapaxes(parent, -1, -2) @ own
    angles = np.arctan2(turned[:, second, first], turned[:, first, first])
    linkage, coupler = rocker(pins, link), np.zeros((len(angles), 3))
    for row, angle in enumerate(angles):
        reached = knee_at(linkage, float(angle))
        assert reached is not None  # `machine.conditions` has looked between the stops
        knee, pin = reached
        coupler[row, first], coupler[row, second] = pin[0] - knee[0], pin[1] - knee[1]
    return np.einsum("tij,tj->ti", parent, coupler)
