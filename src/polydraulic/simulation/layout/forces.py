"""Forces of a run, as columns: of actuators, of friction, and what each joint's pin carries.

Newton and Euler from the tips to the ground: what the links behind a joint need to move as they do, less gravity and what pushes at the
tip, passes from its parent through the actuator and the pin. The pin carries all but the force of the cylinder (of a bucket's linkage, of
its coupler). Its moment about the joint's axis is what acts on the joint itself: a motor's torque, less friction, and what an end stop gives.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from polydraulic.machine.drives import Motor
from polydraulic.machine.frames import Frames, link_frames, placed, vector
from polydraulic.parameters.layout.geometry import knee_at, rocker
from polydraulic.parameters.layout.parts import COORDINATES, GROUND, FourBar, LinkParameters, MachineFunction, Pins
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import AddedColumn, Columns

_ACROSS = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}


class _Wrench(NamedTuple):
    """Force, and moment about a joint, on a link along the ground's axes; (n_row, 3) each."""

    force: np.ndarray
    moment: np.ndarray


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
) -> dict[str, _Wrench]:
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
    needed: dict[str, _Wrench] = {}
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
        needed[link.name] = _Wrench(force, moment)
    for f in reversed(machine.functions):
        link = machine.link(f.moves)
        if link.parent != GROUND:
            own, before = needed[link.name], needed[link.parent]
            arm = frames[link.name][1] - frames[link.parent][1]
            moment = before.moment + own.moment + np.cross(arm, own.force)
            needed[link.parent] = _Wrench(before.force + own.force, moment)
    return {f.name: needed[f.moves] for f in machine.functions}


def _without_actuator(
    machine: LayoutMachine, f: MachineFunction, frames: Frames, passed: _Wrench, push: np.ndarray, oil: np.ndarray
) -> _Wrench:
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
    return _Wrench(passed.force - force, passed.moment - np.cross(at, force))


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


def axis_of(link: LinkParameters, frames: Frames) -> np.ndarray:
    """Direction of a joint's positive motion along the ground's axes, (n_row, 3)."""
    sign = -1.0 if link.axis[0] == "-" else 1.0
    return np.asarray(sign * frames[link.parent][0][:, :, COORDINATES.index(link.axis[-1])])


def _centripetal(spin: np.ndarray, arm: np.ndarray) -> np.ndarray:
    return np.cross(spin, np.cross(spin, arm))


def tensor_of(link: LinkParameters) -> np.ndarray:
    """Inertia about a link's centre of gravity, (3, 3) in kg m2."""
    found = np.zeros((3, 3))
    for key, value in link.inertia.items():
        i, j = (COORDINATES.index(c) for c in key)
        found[i, j] = found[j, i] = value
    return found
