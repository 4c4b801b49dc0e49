"""Equations of motion of a tree, recorded: mass matrix, Coriolis and centrifugal torques, gravity torques, potential energy.

Everything is said of the mass that hangs on a joint as a whole, its composite, about the joint and in the joint's base. A unit
acceleration of a joint gives its composite momentum: force and moment, which run down the chain and are the entries of the
mass matrix where they meet an axis, and the gravity torque where they meet the vertical. Velocities give each composite an
acceleration that is linear in place: that of its joint, and a gradient times the distance from it. A joint adds to
the gradient of its parent what its own turning adds, felt by its own composite alone; so each joint's part runs down the
chain, too, and no link is looked at twice.
"""

from collections.abc import Sequence
from typing import NamedTuple

from polydraulic.machine.tree.frames import LinkFrame, from_parent, parent_frame, to_parent
from polydraulic.machine.tree.links import VECTOR
from polydraulic.machine.tree.mass import (
    NO_MASS,
    NO_MATRIX,
    Mass,
    angular_momentum,
    moment_of_field,
    moved_mass,
    moved_polar,
    named_mass,
    own_mass,
    rotated_mass,
    together,
)
from polydraulic.machine.tree.shapes import Shape
from polydraulic.machine.tree.terms import ZERO, Recorder, Term
from polydraulic.machine.tree.vectors import (
    NOTHING,
    Matrix,
    Vector,
    added,
    applied,
    cross,
    dot,
    matrix,
    named,
    plane,
    scaled,
    unit,
)


def entry_name(i: int, j: int, n: int) -> str:
    """Name of row i and column j, counted from 0, in a mass matrix of n joints."""
    return f"m{i + 1}{j + 1}" if n < 10 else f"m{i + 1}_{j + 1}"


class TreeEquations(NamedTuple):
    """All that moves the joints, by numbers of joints that are not fixed."""

    mass: dict[tuple[int, int], Term]  # upper triangle
    bias: list[Term]
    gravity: list[Term]
    potential: Term


class _Field(NamedTuple):
    """How velocities accelerate what hangs on a joint: angular rate and acceleration, gradient, acceleration of the joint."""

    rate: Vector
    angular: Vector
    gradient: Matrix
    at_joint: Vector


class _Push(NamedTuple):
    """A force, and its moment about a joint."""

    force: Vector
    moment: Vector


_STILL = _Field(NOTHING, NOTHING, NO_MATRIX, NOTHING)
_NO_PUSH = _Push(NOTHING, NOTHING)


def equations_of(shapes: Sequence[Shape], frames: dict[str, LinkFrame], terms: Recorder) -> TreeEquations:
    """Record the equations of motion; rates are read as fields of `rate`.

    Parameters
    ----------
    shapes : sequence of Shape
    frames : dict from name to LinkFrame
    terms : Recorder
    """
    composites, ground = _composites(shapes, frames, terms)
    gravity = terms.leaf("gravity", "gravity", fixed=True)
    joints = [shape for shape in shapes if shape.joint != "fixed"]
    parents = {shape.name: shape.parent for shape in shapes}
    ups = _verticals(shapes, frames)
    mass, weight = {}, []
    for column, shape in enumerate(joints):
        terms.section = f"momentum of what hangs on {shape.name}"
        frame = frames[shape.name]
        push = _unit_momentum(shape, frame, composites[shape.name])
        weight.append((gravity * dot(ups[shape.name], push.force)).named(f"{shape.name}_gravity"))
        mass[column, column] = _diagonal(shape, composites[shape.name])
        name = shape.name
        while (parent := parents[name]) is not None:
            push = _down(push, frames[name], frames[parent])
            name = parent
            row = next((i for i, other in enumerate(joints) if other.name == name), None)
            if row is not None:
                mass[row, column] = _along(joints[row], frames[name], push)
    bias = _bias(shapes, frames, composites, terms)
    terms.section = "energy"
    return TreeEquations(
        {(i, j): term.named(entry_name(i, j, len(joints))) for (i, j), term in sorted(mass.items()) if not term.zero},
        bias,
        weight,
        gravity * ground.first[2],
    )


def _composites(shapes: Sequence[Shape], frames: dict[str, LinkFrame], terms: Recorder) -> tuple[dict[str, Mass], Mass]:
    """What hangs on each joint, and all of it about the ground's origin."""
    # what children bring arrives in the base that they share with a link, or in the link's own axes
    in_base, in_axes = {s.name: NO_MASS for s in shapes}, {s.name: NO_MASS for s in shapes}
    ground, found = NO_MASS, {}
    for shape in reversed(shapes):
        terms.section = f"mass that hangs on {shape.name}"
        frame = frames[shape.name]
        own = together(own_mass(shape, terms), in_axes[shape.name])
        whole = named_mass(together(rotated_mass(own, frame, shape.name), in_base[shape.name]), shape.name)
        found[shape.name] = whole
        parent = parent_frame(shape, frames)
        far = moved_mass(whole, frame.offset, f"{shape.name}_far")
        if parent.rotation is not None and parent.base == frame.base:
            far = far._replace(polar=moved_polar(whole, frame, parent.rotation.axis, shape.name))
        if shape.parent is None:
            ground = together(ground, far)
        elif frame.base == parent.base:
            in_base[shape.parent] = together(in_base[shape.parent], far)
        else:
            in_axes[shape.parent] = together(in_axes[shape.parent], far)
    return found, ground


def _verticals(shapes: Sequence[Shape], frames: dict[str, LinkFrame]) -> dict[str, Vector]:
    """Direction upwards in the base of each link."""
    found: dict[str | None, Vector] = {None: unit(2)}
    for shape in shapes:
        parent = parent_frame(shape, frames)
        found[shape.name] = from_parent(found[shape.parent], frames[shape.name], parent)
    return {shape.name: found[shape.name] for shape in shapes}


def _unit_momentum(shape: Shape, frame: LinkFrame, whole: Mass) -> _Push:
    if shape.joint == "prismatic":
        return _Push(scaled(whole.mass, frame.axis), cross(whole.first, frame.axis))
    assert frame.rotation is not None
    return _Push(cross(frame.axis, whole.first), angular_momentum(whole, frame.axis, frame.rotation.axis))


def _diagonal(shape: Shape, whole: Mass) -> Term:
    return whole.mass if shape.joint == "prismatic" else whole.polar


def _along(shape: Shape, frame: LinkFrame, push: _Push) -> Term:
    return dot(frame.axis, push.force if shape.joint == "prismatic" else push.moment)


def _down(push: _Push, frame: LinkFrame, parent: LinkFrame) -> _Push:
    """About the parent's joint, in its base."""
    moment = added(push.moment, cross(frame.offset, push.force))
    return _Push(to_parent(push.force, frame, parent), to_parent(moment, frame, parent))


def _bias(
    shapes: Sequence[Shape], frames: dict[str, LinkFrame], composites: dict[str, Mass], terms: Recorder
) -> list[Term]:
    """Torques that velocities alone need."""
    fields: dict[str | None, _Field] = {None: _STILL}
    here, own = {}, {}
    for shape in shapes:
        terms.section = f"what the motion of {shape.name} adds"
        parent = parent_frame(shape, frames)
        frame = frames[shape.name]
        here[shape.name] = _entered(fields[shape.parent], frame, parent, shape.name)
        fields[shape.name], own[shape.name] = _with_own(shape, frame, here[shape.name], composites[shape.name], terms)
    arrived = {shape.name: _NO_PUSH for shape in shapes}
    torques: dict[str, Term] = {}
    for shape in reversed(shapes):
        terms.section = f"what motion needs at {shape.name}"
        name, frame, whole = shape.name, frames[shape.name], composites[shape.name]
        push = arrived[name]
        if shape.joint != "fixed":
            pushes = (push, *_of_field(here[name], whole))
            torques[name] = sum((_along(shape, frame, one) for one in pushes), ZERO).named(f"{name}_bias")
        if shape.parent is not None:
            total = _joined(push, own[name])
            total = _Push(named(total.force, f"{name}_f"), named(total.moment, f"{name}_n"))
            arrived[shape.parent] = _joined(arrived[shape.parent], _down(total, frame, frames[shape.parent]))
    return [torques[shape.name] for shape in shapes if shape.joint != "fixed"]


def _joined(a: _Push, b: _Push) -> _Push:
    return _Push(added(a.force, b.force), added(a.moment, b.moment))


def _entered(field: _Field, frame: LinkFrame, parent: LinkFrame, name: str) -> _Field:
    """The parent's field in a link's base, with the acceleration at the link's joint."""
    gradient, rate, angular, at_joint = field.gradient, field.rate, field.angular, field.at_joint
    if frame.base != parent.base:
        rate, angular = from_parent(rate, frame, parent), from_parent(angular, frame, parent)
        at_joint, gradient = from_parent(at_joint, frame, parent), _gradient(rate, angular)
    at_joint = named(added(at_joint, applied(gradient, frame.offset)), f"{name}_a")
    return _Field(rate, angular, gradient, at_joint)


def _gradient(rate: Vector, angular: Vector) -> Matrix:
    """Of the acceleration of a body that turns: angular x r + rate x (rate x r)."""
    square = [part * part for part in rate]
    rows = [[rate[i] * rate[j] for j in range(3)] for i in range(3)]
    for k in range(3):
        i, j = plane(k)
        rows[k][k] = -(square[i] + square[j])
        rows[i][j] = rows[i][j] - angular[k]
        rows[j][i] = rows[j][i] + angular[k]
    return matrix(rows)


def _with_own(shape: Shape, frame: LinkFrame, here: _Field, whole: Mass, terms: Recorder) -> tuple[_Field, _Push]:
    """Field of what hangs on a link, and what the link's own motion adds to it, as force and moment."""
    if shape.joint == "fixed":
        return here, _NO_PUSH
    own = scaled(terms.leaf(f"rate.{shape.name}", f"{shape.name}_rate"), frame.axis)
    if shape.joint == "prismatic":
        coriolis = scaled(2.0, cross(here.rate, own))
        field = here._replace(at_joint=added(here.at_joint, coriolis))
        return field, _Push(scaled(whole.mass, coriolis), cross(whole.first, coriolis))
    # of the gradients with and without the own rate u, the difference: u (2 rate + u)' - u . (2 rate + u)
    both = added(scaled(2.0, here.rate), own)
    rows = [[own[i] * both[j] for j in range(3)] for i in range(3)]
    along = dot(own, both).named(f"{shape.name}_spin")
    for k in range(3):
        rows[k][k] = rows[k][k] - along
    more = matrix(rows)
    field = _Field(
        added(here.rate, own),
        added(here.angular, cross(here.rate, own)),
        matrix([named(added(here.gradient[i], more[i]), f"{shape.name}_w{VECTOR[i]}") for i in range(3)]),
        here.at_joint,
    )
    return field, _Push(applied(more, whole.first), moment_of_field(more, whole))


def _of_field(field: _Field, whole: Mass) -> tuple[_Push, _Push]:
    """What it takes to accelerate a mass as its joint is, and by the gradient."""
    return (
        _Push(scaled(whole.mass, field.at_joint), cross(whole.first, field.at_joint)),
        _Push(applied(field.gradient, whole.first), moment_of_field(field.gradient, whole)),
    )
