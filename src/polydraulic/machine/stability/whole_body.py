"""The numbers of a machine as one body, and its margins at many states at once."""

import numpy as np

from polydraulic._kernel import driver
from polydraulic.errors import InputError
from polydraulic.machine.frames import vector
from polydraulic.machine.newton_euler import tensor_of
from polydraulic.machine.stability.body import N_LINK, Body, edge_of, point_of, put, stand
from polydraulic.machine.stability.margins import MEASURES
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


def body_of(machine: LayoutMachine) -> Body:
    """Numbers of a machine as its kernels read them.

    Raises
    ------
    InputError
        A machine without a chassis.
    """
    chassis = chassis_of(machine)
    links = [machine.link(f.moves) for f in machine.functions]
    number = {GROUND: -1} | {link.name: k for k, link in enumerate(links)}
    tensors = [tensor_of(link) for link in links]
    slope = chassis.slope or (0.0, 0.0)
    return Body(
        np.array([number[link.parent] for link in links], dtype=np.int64),
        np.array([link.joint == "prismatic" for link in links], dtype=np.int64),
        np.array(["xyz".index(link.axis[-1]) for link in links], dtype=np.int64),
        np.array([-1.0 if link.axis[0] == "-" else 1.0 for link in links]),
        np.concatenate([vector(link.at) for link in links]),
        np.concatenate([vector(link.cg) for link in links]),
        np.array([float(link.mass) for link in links]),
        np.array([t[i, j] for t in tensors for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]),
        number[machine.tip[0]],
        vector(machine.tip[1]),
        vector(chassis.cg),
        float(chassis.mass),
        float(machine.gravity),
        float(slope[0]),
        float(slope[1]),
        len(chassis.corners),
        np.array(chassis.corners, dtype=float).ravel(),
    )


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
    body = body_of(machine)
    found = np.empty((len(positions), body.n_edge, len(MEASURES)))
    all_margins(body, _motions(positions, rates, accelerations), np.ascontiguousarray(forces), found)
    return found


def standing(
    machine: LayoutMachine, positions: np.ndarray, rates: np.ndarray, accelerations: np.ndarray, forces: np.ndarray
) -> np.ndarray:
    """Numbers of `margins.Standing`, (n_row, 16); arguments as of `standing_margins`."""
    found = np.empty((len(positions), 16))
    all_standing(body_of(machine), _motions(positions, rates, accelerations), np.ascontiguousarray(forces), found)
    return found


def _motions(*parts: np.ndarray) -> np.ndarray:
    """Rows of `all_margins`: positions, rates, accelerations, and room for links."""
    n = parts[0].shape[1]
    return np.ascontiguousarray(np.hstack([*parts, np.zeros((len(parts[0]), N_LINK * (n + 1)))]))


@driver
def all_margins(body: Body, motions: np.ndarray, forces: np.ndarray, found: np.ndarray) -> None:
    """Margins of all rows over all edges, (n_row, n_edge, 5), written into `found`."""
    n = body.parent.shape[0]
    for row in range(motions.shape[0]):
        push = point_of(forces[row], 0)
        s = stand(body, motions[row], 0, 3 * n, push, body.pitch, body.roll)
        for k in range(found.shape[1]):
            m = edge_of(body, k, s)
            found[row, k, 0] = m.distance
            found[row, k, 1] = m.dynamic_distance
            found[row, k, 2] = m.force_angle
            found[row, k, 3] = m.energy
            found[row, k, 4] = m.closing


@driver
def all_standing(body: Body, motions: np.ndarray, forces: np.ndarray, found: np.ndarray) -> None:
    """Numbers of `Standing` of all rows, (n_row, 16), written into `found`."""
    n = body.parent.shape[0]
    for row in range(motions.shape[0]):
        push = point_of(forces[row], 0)
        s = stand(body, motions[row], 0, 3 * n, push, body.pitch, body.roll)
        found[row, 0] = s.weight
        put(found[row], 1, s.cg.x, s.cg.y, s.cg.z)
        put(found[row], 4, s.velocity.x, s.velocity.y, s.velocity.z)
        put(found[row], 7, s.force.x, s.force.y, s.force.z)
        put(found[row], 10, s.moment.x, s.moment.y, s.moment.z)
        put(found[row], 13, s.upward.x, s.upward.y, s.upward.z)
