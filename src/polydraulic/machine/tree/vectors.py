"""Vectors of recorded terms: what is zero by structure is left out of all that is done with them."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from polydraulic.machine.tree.links import VECTOR
from polydraulic.machine.tree.terms import ZERO, Term

Vector = tuple[Term, Term, Term]
Matrix = tuple[Vector, Vector, Vector]
NOTHING: Vector = (ZERO, ZERO, ZERO)


class Rotation(NamedTuple):
    """A turn about one of the axes x (0), y (1), z (2)."""

    axis: int
    sin: Term
    cos: Term


def components(given: Mapping[str, Term]) -> Vector:
    """A vector of components by their names; those that are not given are zero."""
    x, y, z = (given.get(name, ZERO) for name in VECTOR)
    return x, y, z


def unit(axis: int, sign: float = 1.0) -> Vector:
    """Unit vector along an axis."""
    x, y, z = (Term(sign, None) if i == axis else ZERO for i in range(3))
    return x, y, z


def named(v: Vector, name: str) -> Vector:
    """The same with its components called `name` with x, y, z behind it."""
    x, y, z = (part.named(name + c) for part, c in zip(v, VECTOR, strict=True))
    return x, y, z


def added(*vectors: Vector) -> Vector:
    """Sum of vectors."""
    x, y, z = (sum((v[i] for v in vectors), ZERO) for i in range(3))
    return x, y, z


def scaled(factor: Term | float, v: Vector) -> Vector:
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


def matrix(rows: Sequence[Sequence[Term]]) -> Matrix:
    """Three rows of three."""
    (a, b, c) = ((row[0], row[1], row[2]) for row in rows)
    return a, b, c


def plane(axis: int) -> tuple[int, int]:
    """The two other axes, in right-handed order."""
    return (axis + 1) % 3, (axis + 2) % 3


def rotated(v: Vector, rotation: Rotation | None) -> Vector:
    """Components of a vector that turns along."""
    if rotation is None:
        return v
    (i, j), found = plane(rotation.axis), list(v)
    found[i] = rotation.cos * v[i] - rotation.sin * v[j]
    found[j] = rotation.sin * v[i] + rotation.cos * v[j]
    return found[0], found[1], found[2]


def rotated_back(v: Vector, rotation: Rotation | None) -> Vector:
    """Components of a vector in axes that are turned."""
    return v if rotation is None else rotated(v, rotation._replace(sin=-rotation.sin))
