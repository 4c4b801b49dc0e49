"""Where the tip is, and how it moves with the joints: in the ground's axes, and in those of the arm.

The axes of the arm are outward, to the left and up. They turn with a first joint about an upright axis; without one they are those of the ground.
"""

import numpy as np

from polydraulic.elementary import sincos_of
from polydraulic.machine.frames import AXES, link_frames, placed, vector
from polydraulic.machine.newton_euler import axis_of
from polydraulic.parameters.layout.parts import GROUND, LinkParameters, MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine

_DAMPING = 0.02  # of the inverse, in shares of the largest reach of a joint


def tip_at_joints(machine: LayoutMachine, positions: np.ndarray) -> np.ndarray:
    """Places of the tip, (..., 3) in m, at joint positions (..., n_function) in rad or m.

    A point that is carried from link to link, by the operations of `simulation.lane_blocks.place_tips`: the same bits.
    """
    functions = {f.moves: place for place, f in enumerate(machine.functions)}
    here: list[np.ndarray | float] = vector(machine.tip[1]).tolist()
    for link in reversed(tip_links(machine)):
        q = (-1.0 if link.axis[0] == "-" else 1.0) * positions[..., functions[link.name]]
        axis = AXES[link.axis[-1]]
        if link.joint == "prismatic":
            here[axis] = here[axis] + q
        else:
            first, second = (axis + 1) % 3, (axis + 2) % 3
            sin, cos = sincos_of(q)
            here[first], here[second] = cos * here[first] - sin * here[second], sin * here[first] + cos * here[second]
        here = [x + at for x, at in zip(here, vector(link.at).tolist(), strict=True)]
    found = np.empty((3, *positions.shape[:-1]))
    for place, x in enumerate(here):
        found[place] = x
    return np.moveaxis(found, 0, -1)


def tip_jacobian(machine: LayoutMachine, positions: np.ndarray) -> np.ndarray:
    """Speed of the tip for each joint's, (..., 3, n_function) in m or 1 per second of m or rad; positions as for `tip_at_joints`."""
    frames = link_frames(machine, positions)
    tip, carriers = placed(frames, *machine.tip), tip_links(machine)
    found = np.zeros((*tip.shape, len(machine.functions)))
    for place, f in enumerate(machine.functions):
        link = machine.link(f.moves)
        if link in carriers:
            axis, origin = axis_of(link, frames), frames[link.name][1]
            found[..., place] = axis if link.joint == "prismatic" else np.cross(axis, tip - origin)
    return found


def joint_speeds(jacobian: np.ndarray, speed: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Joint speeds that move the tip as wanted: least squares, damped where the arm is stretched.

    Parameters
    ----------
    jacobian : (n, 3, n_function) array
    speed : (n, 3) array, m/s
    free : (n_function,) or (n, n_function) array
        How much each joint is to do of it, for example its travel; 0 for one that stands.

    Returns
    -------
    (n, n_function) array, rad/s or m/s
    """
    weighed = jacobian * free[..., None, :]
    square = weighed @ np.swapaxes(weighed, -1, -2)
    damping = _DAMPING**2 * np.trace(square, axis1=-2, axis2=-1) + 1e-12
    square = square + damping[..., None, None] * np.eye(3)
    forces = np.linalg.solve(square, speed[..., None])
    return np.asarray((np.swapaxes(weighed, -1, -2) @ forces)[..., 0] * free)


def tip_links(machine: LayoutMachine) -> list[LinkParameters]:
    """Links from the ground to the one that carries the tip."""
    found = [machine.link(machine.tip[0])]
    while found[0].parent != GROUND:
        found.insert(0, machine.link(found[0].parent))
    return found


def slewing_function(machine: LayoutMachine) -> MachineFunction | None:
    """The function that turns the arm about an upright axis, the first; None of a machine without one."""
    first = machine.functions[0]
    link = machine.link(first.moves)
    return first if link.parent == GROUND and link.joint == "revolute" and link.axis[-1] == "z" else None


def slew_sign(machine: LayoutMachine) -> float:
    """1 or -1 if the first joint turns the arm about an upright axis, to the left or to the right; 0 otherwise."""
    slews = slewing_function(machine)
    if slews is None:
        return 0.0
    return -1.0 if machine.link(slews.moves).axis[0] == "-" else 1.0


def to_arm(heading: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """A vector (3, n) of the ground's axes in those of the arm, which has turned by `heading` (n,) rad."""
    c, s = np.cos(heading), np.sin(heading)
    return np.stack([c * vector[0] + s * vector[1], c * vector[1] - s * vector[0], vector[2]])
