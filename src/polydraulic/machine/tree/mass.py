"""Mass and its moments: of one link, turned, moved, and of all that hangs on a joint together.

Second moments (the integral of x y over the mass) stand for inertia: they turn and move with fewer operations. The inertia about
the axis about which a link turns, `polar`, is kept apart, since turning leaves it alone.
"""

from typing import NamedTuple

from polydraulic.machine.tree.frames import LinkFrame, parameter
from polydraulic.machine.tree.links import TENSOR, VECTOR
from polydraulic.machine.tree.shapes import Shape
from polydraulic.machine.tree.terms import ZERO, Recorder, Term
from polydraulic.machine.tree.vectors import (
    NOTHING,
    Matrix,
    Vector,
    added,
    components,
    matrix,
    named,
    plane,
    rotated,
    scaled,
)

NO_MATRIX: Matrix = (NOTHING, NOTHING, NOTHING)


class Mass(NamedTuple):
    """Mass in kg, first moment in kg m and second moment in kg m2 about one point."""

    mass: Term
    first: Vector
    second: Matrix
    polar: Term


NO_MASS = Mass(ZERO, NOTHING, NO_MATRIX, ZERO)


def own_mass(shape: Shape, terms: Recorder) -> Mass:
    """Mass of a link about its joint, in its own axes; all of it is fixed."""
    mass = parameter(terms, shape.name, "mass") if shape.mass else ZERO
    centre = components({c: parameter(terms, shape.name, "cg", c) for c in shape.cg})
    given = {c: parameter(terms, shape.name, "inertia", c) for c in shape.inertia}
    xx, yy, zz = (given.get(c, ZERO) * 0.5 for c in ("xx", "yy", "zz"))
    xy, xz, yz = (-given.get(c, ZERO) for c in TENSOR[3:])
    about_centre = matrix([[yy + zz - xx, xy, xz], [xy, xx + zz - yy, yz], [xz, yz, xx + yy - zz]])
    return named_mass(moved_mass(Mass(mass, NOTHING, about_centre, ZERO), centre), f"{shape.name}_own")


def together(*masses: Mass) -> Mass:
    """Several masses about one point."""
    return Mass(
        sum((m.mass for m in masses), ZERO),
        added(*(m.first for m in masses)),
        matrix([added(*(m.second[i] for m in masses)) for i in range(3)]),
        sum((m.polar for m in masses), ZERO),
    )


def moved_mass(m: Mass, offset: Vector, name: str = "") -> Mass:
    """About a point from which the present one is at `offset`; `polar` is left behind.

    Parameters
    ----------
    m : Mass
    offset : Vector
    name : str, optional
        For the first moments about that point.
    """
    step = scaled(m.mass, offset)
    first = added(m.first, step)
    if name:
        first = named(first, f"{name}_m")
    second = [[_moved_second(m, offset, step, first, i, j) for j in range(3)] for i in range(3)]
    return Mass(m.mass, first, matrix(second), ZERO)


def moved_polar(m: Mass, frame: LinkFrame, axis: int, name: str) -> Term:
    """`polar` about the parent's joint: the distance of two joints in the plane of turning is fixed, whatever the angles."""
    i, j = plane(axis)
    square = frame.span[i] * frame.span[i] + frame.span[j] * frame.span[j]
    fold = (frame.offset[i] * m.first[i] + frame.offset[j] * m.first[j]).named(f"{name}_fold")
    return m.polar + m.mass * square + 2.0 * fold


def _moved_second(m: Mass, offset: Vector, step: Vector, first: Vector, i: int, j: int) -> Term:
    if i > j:
        i, j = j, i
    if offset[i].fixed and offset[j].fixed:
        return m.second[i][j] + (offset[i] * m.first[j] + offset[j] * m.first[i]) + step[i] * offset[j]
    return m.second[i][j] + (offset[i] * m.first[j] + first[i] * offset[j])


def rotated_mass(m: Mass, frame: LinkFrame, name: str) -> Mass:
    """From a link's own axes into its base, with `polar` about the axis of the turn."""
    if frame.rotation is None:
        return m
    axis, sin, cos = frame.rotation
    i, j = plane(axis)
    a, b, e = m.second[i][i], m.second[j][j], m.second[i][j]
    slant = (sin * (a - b).named(f"{name}_slender") + cos * (2.0 * e)).named(f"{name}_slant")
    found = {
        (i, i): a - sin * slant,
        (j, j): b + sin * slant,
        (i, j): cos * slant - e,
        (i, axis): cos * m.second[i][axis] - sin * m.second[j][axis],
        (j, axis): sin * m.second[i][axis] + cos * m.second[j][axis],
        (axis, axis): m.second[axis][axis],
    }
    second = [[found[p, q] if (p, q) in found else found[q, p] for q in range(3)] for p in range(3)]
    return Mass(m.mass, rotated(m.first, frame.rotation), matrix(second), a + b)


def named_mass(m: Mass, name: str) -> Mass:
    """The same, called by the name of the link on which it hangs."""
    m.mass.named(f"{name}_m")
    m.polar.named(f"{name}_polar")
    named(m.first, f"{name}_m")
    for i, p in enumerate(VECTOR):
        named(m.second[i], f"{name}_m{p}")
    return m


def angular_momentum(m: Mass, direction: Vector, axis: int) -> Vector:
    """Per unit of rate about `direction`, which is along an axis, about the joint."""
    sign = direction[axis]
    parts = [-sign * m.second[k][axis] for k in range(3)]
    parts[axis] = sign * m.polar
    return parts[0], parts[1], parts[2]


def moment_of_field(gradient: Matrix, m: Mass) -> Vector:
    """Moment of an acceleration that grows linearly from the joint: the integral of r x (gradient r) over the mass."""
    w, s = gradient, m.second

    def about(k: int) -> Term:
        i, j = plane(k)
        return (
            (w[j][j] - w[i][i]) * s[i][j]
            + w[j][i] * s[i][i]
            - w[i][j] * s[j][j]
            + w[j][k] * s[k][i]
            - w[i][k] * s[k][j]
        )

    return about(0), about(1), about(2)
