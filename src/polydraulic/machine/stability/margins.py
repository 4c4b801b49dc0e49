"""How far a machine is from tipping over an edge of what it stands on: four measures of one state, as kernels.

- The static distance: from the line of gravity through the common centre of gravity to the edge, seen along gravity.
- The dynamic distance: the moment about the edge that keeps the machine down, inertia of what moves and loads at the tip included, over its
  weight. It is the static distance of a machine at rest, and zero where a machine begins to tip.
- The force-angle measure: the angle from the edge, seen from the centre of gravity, to the net force that acts there, times that moment
  (E. Papadopoulos and D. A. Rey, Vehicle System Dynamics 33, 2000). It falls with the height of the centre of gravity, too.
- The energy measure: what it takes to turn the machine about the edge until its centre of gravity stands above it.

All are positive on the safe side.
"""

from math import atan2, sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel


class Vector(NamedTuple):
    """Along the axes of the machine's ground frame."""

    x: float
    y: float
    z: float


class Standing(NamedTuple):
    """A machine as it stands: all of it as one body.

    Attributes
    ----------
    weight : float, N
    cg, velocity : Vector, m and m/s
        Of the common centre of gravity.
    force, moment : Vector, N and N m
        All but the ground's reaction, inertia included, at the centre of gravity.
    upward : Vector
        Against gravity, of length 1.
    """

    weight: float
    cg: Vector
    velocity: Vector
    force: Vector
    moment: Vector
    upward: Vector


class EdgeMargins(NamedTuple):
    """Margins over one edge.

    Attributes
    ----------
    distance, dynamic_distance : float, m
    force_angle : float, N m
    energy : float, J
    closing : float, m/s
        How fast the static distance becomes smaller.
    """

    distance: float
    dynamic_distance: float
    force_angle: float
    energy: float
    closing: float


MEASURES = EdgeMargins._fields
N_STANDING = 16  # floats of a `Standing`


@kernel
def _dot(a: Vector, b: Vector) -> float:
    """Product of two vectors."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@kernel
def _cross(a: Vector, b: Vector) -> Vector:
    """What is across two vectors."""
    return Vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@kernel
def _without(a: Vector, along: Vector) -> Vector:
    """A vector without its part along a unit vector."""
    part = _dot(a, along)
    return Vector(a.x - part * along.x, a.y - part * along.y, a.z - part * along.z)


@kernel
def edge_margins(begin: Vector, end: Vector, s: Standing) -> EdgeMargins:
    """Margins over the edge from one contact to the next, counter-clockwise as seen from above.

    Parameters
    ----------
    begin, end : Vector, m
    s : Standing
    """
    way = Vector(end.x - begin.x, end.y - begin.y, end.z - begin.z)
    scale = 1.0 / sqrt(_dot(way, way) + 1e-300)
    edge = Vector(scale * way.x, scale * way.y, scale * way.z)
    to_edge = _without(Vector(end.x - s.cg.x, end.y - s.cg.y, end.z - s.cg.z), edge)  # l of the paper
    far2 = _dot(to_edge, to_edge) + 1e-300
    far = sqrt(far2)
    across = _without(s.upward, edge)
    upright = sqrt(_dot(across, across) + 1e-300)
    inward = _cross(s.upward, edge)  # level, of the length `upright`
    distance = -_dot(to_edge, inward) / upright
    closing = -_dot(s.velocity, inward) / upright
    turning = _dot(s.moment, edge)
    couple = _cross(to_edge, Vector(turning * edge.x, turning * edge.y, turning * edge.z))
    force = _without(s.force, edge)
    net = Vector(force.x + couple.x / far2, force.y + couple.y / far2, force.z + couple.z / far2)  # f* of the paper
    keeping = _dot(edge, _cross(to_edge, net))
    angle = atan2(keeping, _dot(to_edge, net))
    raised = s.weight * (far * upright + _dot(to_edge, across))
    return EdgeMargins(
        distance,
        keeping / (s.weight * upright),
        angle * abs(keeping),
        raised if distance >= 0.0 else -raised,
        closing,
    )


@driver
def all_margins(corners: np.ndarray, standing: np.ndarray, found: np.ndarray) -> None:
    """Margins of all rows over all edges.

    Parameters
    ----------
    corners : (n_edge, 3) array, m
        Counter-clockwise; edge k goes from corner k to the next.
    standing : (n_row, 16) array
        Numbers of a `Standing`, row by row.
    found : (n_row, n_edge, 5) array
        Numbers of `EdgeMargins`, written.
    """
    count = corners.shape[0]
    for row in range(standing.shape[0]):
        v = standing[row]
        s = Standing(
            v[0],
            Vector(v[1], v[2], v[3]),
            Vector(v[4], v[5], v[6]),
            Vector(v[7], v[8], v[9]),
            Vector(v[10], v[11], v[12]),
            Vector(v[13], v[14], v[15]),
        )
        for k in range(count):
            after = k + 1 if k + 1 < count else 0
            begin = Vector(corners[k, 0], corners[k, 1], corners[k, 2])
            end = Vector(corners[after, 0], corners[after, 1], corners[after, 2])
            m = edge_margins(begin, end, s)
            found[row, k, 0] = m.distance
            found[row, k, 1] = m.dynamic_distance
            found[row, k, 2] = m.force_angle
            found[row, k, 3] = m.energy
            found[row, k, 4] = m.closing
