"""In which axes each link is calculated, and what turning and moving between them takes.

Links that turn about parallel axes one behind the other share the axes of the first one's parent, and each is turned against
these by the sum of the angles: nothing is turned twice. Where the direction of the axis changes, new axes begin: those of
the last link that turned. So a vector of a link stands either in its own axes, where its numbers are fixed, or in those it
shares, its base.
"""

from collections.abc import Sequence
from typing import NamedTuple

from polydraulic.machine.tree.links import VECTOR
from polydraulic.machine.tree.shapes import Shape
from polydraulic.machine.tree.terms import ZERO, Term, Terms

Vector = tuple[Term, Term, Term]
Matrix = tuple[Vector, Vector, Vector]
NOTHING: Vector = (ZERO, ZERO, ZERO)
ONE = Term(1.0, None)


class Rotation(NamedTuple):
    """A turn about one of the axes x (0), y (1), z (2)."""

    axis: int
    sin: Term
    cos: Term


class Frame(NamedTuple):
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


GROUND = Frame(None, None, None, NOTHING, NOTHING, NOTHING)


def frames_of(shapes: Sequence[Shape], terms: Terms) -> dict[str, Frame]:
    """Frames of all links, by name.

    Parameters
    ----------
    shapes : sequence of Shape
    terms : Terms
        Records what absolute angles and offsets take; it reads joints as fields of `turn`.
    """
    found: dict[str, Frame] = {}
    for shape in shapes:
        terms.section = f"directions and place of {shape.name}"
        found[shape.name] = _frame(shape, GROUND if shape.parent is None else found[shape.parent], terms)
    return found


def _frame(shape: Shape, parent: Frame, terms: Terms) -> Frame:
    name, direction = shape.name, NOTHING
    if shape.axis is not None:
        direction = unit("xyz".index(shape.axis[-1]), -1.0 if shape.axis[0] == "-" else 1.0)
    span = components(VECTOR, {c: parameter(terms, name, "at", c) for c in shape.at})
    if shape.joint == "prismatic":
        way = terms.leaf(f"turn.{name}", f"{name}_way")
        span = added(span, times(way, direction))
    if shape.joint != "revolute":
        base, rotation, turner = parent.base, parent.rotation, parent.turner
    else:
        axis = next(i for i in range(3) if not direction[i].zero)
        sin, cos = terms.leaf(f"turn.{name}.sin", f"{name}_sin"), terms.leaf(f"turn.{name}.cos", f"{name}_cos")
        sign, base, turner = direction[axis], parent.base, name
        rotation = Rotation(axis, sin * sign, cos)
        if parent.rotation is not None and parent.rotation.axis == axis:
            before = parent.rotation
            sum_sin = (before.sin * sign * cos + before.cos * sin).named(f"sin_{name}")
            sum_cos = (before.cos * cos - before.sin * sign * sin).named(f"cos_{name}")
            rotation = Rotation(axis, sum_sin * sign, sum_cos)
        elif parent.rotation is not None:
            base = parent.turner
    shared = base == parent.base
    offset = turned(span, parent.rotation) if shared else span
    return Frame(
        base,
        rotation,
        turner,
        turned(direction, parent.rotation) if shared else direction,
        named(offset, f"{name}_"),
        span,
    )


def parameter(terms: Terms, link: str, group: str, component: str = "") -> Term:
    """A number of a link, which is fixed."""
    if not component:
        return terms.leaf(f'links["{link}"].{group}', f"{link}_{group}", fixed=True)
    return terms.leaf(f'links["{link}"].{group}["{component}"]', f"{link}_{group}_{component}", fixed=True)


def components(names: Sequence[str], given: dict[str, Term]) -> Vector:
    """Three components; those that are not given are zero."""
    x, y, z = (given.get(name, ZERO) for name in names)
    return x, y, z


def unit(axis: int, sign: float = 1.0) -> Vector:
    """Unit vector along an axis."""
    x, y, z = (ONE * sign if i == axis else ZERO for i in range(3))
    return x, y, z


def named(v: Vector, name: str) -> Vector:
    """The same with its components called `name` with x, y, z behind it."""
    x, y, z = (part.named(name + c) for part, c in zip(v, VECTOR, strict=True))
    return x, y, z


def added(*vectors: Vector) -> Vector:
    """Sum of vectors."""
    x, y, z = (sum((v[i] for v in vectors), ZERO) for i in range(3))
    return x, y, z


def times(factor: Term | float, v: Vector) -> Vector:
    """Multiple of a vector."""
    return factor * v[0], factor * v[1], factor * v[2]


def dot(a: Vector, b: Vector) -> Term:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def applied(m: Matrix, v: Vector) -> Vector:
    """Matrix times vector."""
    return dot(m[0], v), dot(m[1], v), dot(m[2], v)


def plane(axis: int) -> tuple[int, int]:
    """The two other axes, in right-handed order."""
    return (axis + 1) % 3, (axis + 2) % 3


def turned(v: Vector, rotation: Rotation | None) -> Vector:
    """From a link's own axes into its base."""
    if rotation is None:
        return v
    (i, j), found = plane(rotation.axis), list(v)
    found[i] = rotation.cos * v[i] - rotation.sin * v[j]
    found[j] = rotation.sin * v[i] + rotation.cos * v[j]
    return found[0], found[1], found[2]


def turned_back(v: Vector, rotation: Rotation | None) -> Vector:
    """From the base into a link's own axes."""
    return v if rotation is None else turned(v, rotation._replace(sin=-rotation.sin))


def to_parent(v: Vector, frame: Frame, parent: Frame) -> Vector:
    """From a link's base into its parent's."""
    return v if frame.base == parent.base else turned(v, parent.rotation)


def from_parent(v: Vector, frame: Frame, parent: Frame) -> Vector:
    """From the base of a link's parent into its own."""
    return v if frame.base == parent.base else turned_back(v, parent.rotation)
