"""How far a machine is from tipping over an edge of what it stands on: four measures of one state, as kernels.

- The static distance: from the line of gravity through the common centre of gravity to the edge, seen along gravity.
- The dynamic distance: the moment about the edge that keeps the machine down, inertia of what moves and loads at the tip included, over its
  weight. It is the static distance of a machine at rest, and zero where a machine begins to tip.
- The force-angle measure: the angle from the edge, seen from the centre of gravity, to the net force that acts there, times that moment
  (E. Papadopoulos and D. A. Rey, Vehicle System Dynamics 33, 2000). It falls with the height of the centre of gravity, too.
- The energy measure: what it takes to turn the machine about the edge until its centre of gravity stands above it.

All are positive on the safe side.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import direction
from polydraulic.machine.stability.vectors import Vector, cross_product, dot_product, part_across


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


@kernel
def edge_margins(begin: Vector, end: Vector, s: Standing) -> EdgeMargins:
    """Margins over the edge from one contact to the next, counter-clockwise as seen from above.

    Parameters
    ----------
    begin, end : Vector, m
    s : Standing
    """
    way = Vector(end.x - begin.x, end.y - begin.y, end.z - begin.z)
    scale = 1.0 / sqrt(dot_product(way, way) + 1e-300)
    edge = Vector(scale * way.x, scale * way.y, scale * way.z)
    to_edge = part_across(Vector(end.x - s.cg.x, end.y - s.cg.y, end.z - s.cg.z), edge)  # l of the paper
    far2 = dot_product(to_edge, to_edge) + 1e-300
    far = sqrt(far2)
    across = part_across(s.upward, edge)
    upright = sqrt(dot_product(across, across) + 1e-300)
    inward = cross_product(s.upward, edge)  # level, of the length `upright`
    distance = -dot_product(to_edge, inward) / upright
    closing = -dot_product(s.velocity, inward) / upright
    turning = dot_product(s.moment, edge)
    couple = cross_product(to_edge, Vector(turning * edge.x, turning * edge.y, turning * edge.z))
    force = part_across(s.force, edge)
    net = Vector(force.x + couple.x / far2, force.y + couple.y / far2, force.z + couple.z / far2)  # f* of the paper
    keeping = dot_product(edge, cross_product(to_edge, net))
    angle = direction(keeping, dot_product(to_edge, net))
    raised = s.weight * (far * upright + dot_product(to_edge, across))
    return EdgeMargins(
        distance,
        keeping / (s.weight * upright),
        angle * abs(keeping),
        raised if distance >= 0.0 else -raised,
        closing,
    )
