"""In which axes each link is calculated, and what turning and moving between them takes.

Links that turn about parallel axes one behind the other share the axes of the first one's parent, and each is turned against
these by the sum of the angles: nothing is turned twice. Where the direction of the axis changes, new axes begin: those of
the last link that turned. So a vector of a link stands either in its own axes, where its numbers are fixed, or in those it
shares, its base.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from polydraulic.machine.tree.links import VECTOR
from polydraulic.machine.tree.shapes import Shape
from polydraulic.machine.tree.terms import ZERO, Recorder, Term
from polydraulic.machine.tree.vectors import (
    NOTHING,
    Rotation,
    Vector,
    added,
    components,
    named,
    rotated,
    rotated_back,
    scaled,
    unit,
)


class LinkFrame(NamedTuple):
    """Where a link is.

    Attributes
    ----------
    base : str or None
        The link whose axes are those of its base; None for the ground.
    rotation : Rotation or None
        Of the link against its base; None where it is not turned.
    turner : str or None
        The last link in the chain that turns, itself included; None where none does: its own axes are this link's.
    axis : Vector
        Direction of positive motion of the joint, in the base.
    offset : Vector, m
        From the parent's origin to its own, in the base.
    span : Vector, m
        The same in the parent's axes.
    """

    base: str | None
    rotation: Rotation | None
    turner: str | None
    axis: Vector
    offset: Vector
    span: Vector


_GROUND = LinkFrame(None, None, None, NOTHING, NOTHING, NOTHING)


def link_frames(shapes: Sequence[Shape], terms: Recorder) -> dict[str, LinkFrame]:
    """Frames of all links, by name.

    Parameters
    ----------
    shapes : sequence of Shape
    terms : Recorder
        Records what absolute angles and offsets take; it reads joints as fields of `turn`.
    """
    found: dict[str, LinkFrame] = {}
    for shape in shapes:
        terms.section = f"directions and place of {shape.name}"
        found[shape.name] = _frame(shape, parent_frame(shape, found), terms)
    return found


def _frame(shape: Shape, parent: LinkFrame, terms: Recorder) -> LinkFrame:
    name, direction = shape.name, NOTHING
    if shape.axis is not None:
        direction = unit(VECTOR.index(shape.axis[-1]), -1.0 if shape.axis[0] == "-" else 1.0)
    span = components({c: parameter(terms, name, "at", c) for c in shape.at})
    base, rotation, turner = parent.base, parent.rotation, parent.turner
    if shape.joint == "prismatic":
        span = added(span, scaled(terms.leaf(f"turn.{name}", f"{name}_way"), direction))
    elif shape.joint == "revolute":
        turner, own = name, _own_rotation(name, direction, terms)
        if rotation is None:
            rotation = own
        elif rotation.axis == own.axis:
            rotation = _both(rotation, own, sum(direction, ZERO), name)
        else:
            base, rotation = parent.turner, own
    if base == parent.base:
        direction, offset = rotated(direction, parent.rotation), rotated(span, parent.rotation)
    else:
        offset = span
    return LinkFrame(base, rotation, turner, direction, named(offset, f"{name}_"), span)


def _own_rotation(name: str, direction: Vector, terms: Recorder) -> Rotation:
    axis = next(i for i in range(3) if not direction[i].zero)
    sin, cos = (terms.leaf(f"turn.{name}.{part}", f"{name}_{part}") for part in ("sin", "cos"))
    return Rotation(axis, sin * direction[axis], cos)


def _both(a: Rotation, b: Rotation, sign: Term, name: str) -> Rotation:
    """One turn after the other about the same axis; `sign` is that of the angle that is called by `name`."""
    sin = (sign * (a.sin * b.cos + a.cos * b.sin)).named(f"sin_{name}")
    cos = (a.cos * b.cos - a.sin * b.sin).named(f"cos_{name}")
    return Rotation(a.axis, sign * sin, cos)


def parent_frame(shape: Shape, frames: Mapping[str, LinkFrame]) -> LinkFrame:
    """Where the parent of a link is, which may be the ground."""
    return _GROUND if shape.parent is None else frames[shape.parent]


def parameter(terms: Recorder, link: str, group: str, component: str = "") -> Term:
    """A number of a link, which is fixed."""
    if not component:
        return terms.leaf(f'links["{link}"].{group}', f"{link}_{group}", fixed=True)
    return terms.leaf(f'links["{link}"].{group}["{component}"]', f"{link}_{group}_{component}", fixed=True)


def to_parent(v: Vector, frame: LinkFrame, parent: LinkFrame) -> Vector:
    """From a link's base into its parent's."""
    return v if frame.base == parent.base else rotated(v, parent.rotation)


def from_parent(v: Vector, frame: LinkFrame, parent: LinkFrame) -> Vector:
    """From the base of a link's parent into its own."""
    return v if frame.base == parent.base else rotated_back(v, parent.rotation)
