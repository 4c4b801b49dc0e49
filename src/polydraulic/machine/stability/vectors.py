"""Vectors in space, as kernels."""

from typing import NamedTuple

from polydraulic._kernel import kernel


class Vector(NamedTuple):
    """Along the axes of the machine's ground frame."""

    x: float
    y: float
    z: float


@kernel
def dot_product(a: Vector, b: Vector) -> float:
    """Product of two vectors."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@kernel
def cross_product(a: Vector, b: Vector) -> Vector:
    """What is across two vectors."""
    return Vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@kernel
def times(factor: float, a: Vector) -> Vector:
    """A vector so many times as long."""
    return Vector(factor * a.x, factor * a.y, factor * a.z)


@kernel
def plus(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return Vector(a.x + b.x, a.y + b.y, a.z + b.z)


@kernel
def part_across(a: Vector, along: Vector) -> Vector:
    """A vector without its part along a unit vector."""
    part = dot_product(a, along)
    return Vector(a.x - part * along.x, a.y - part * along.y, a.z - part * along.z)
