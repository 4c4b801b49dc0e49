"""Points of links, recorded: where one is in the ground's frame, and what torques a force there is worth."""

from collections.abc import Sequence

from polydraulic.machine.tree.frames import LinkFrame, from_parent, parent_frame, to_parent
from polydraulic.machine.tree.shapes import Shape
from polydraulic.machine.tree.terms import Recorder, Term
from polydraulic.machine.tree.vectors import Vector, added, cross, dot, named, rotated


def chain_of(name: str, shapes: Sequence[Shape]) -> list[Shape]:
    """A link and those that it hangs on, down to the ground."""
    by_name = {shape.name: shape for shape in shapes}
    found = [by_name[name]]
    while (parent := found[-1].parent) is not None:
        found.append(by_name[parent])
    return found


def place_of(chain: Sequence[Shape], frames: dict[str, LinkFrame], point: Vector) -> Vector:
    """A point of the first link of a chain, given in its own axes, in the ground's frame.

    Parameters
    ----------
    chain : sequence of Shape
        See `chain_of`.
    frames : dict from name to LinkFrame
    point : Vector, m
    """
    found = _from_joint(point, chain[0].name, frames)
    for shape in chain:
        found = _from_parent(found, shape, frames)
    return found


def torques_of(chain: Sequence[Shape], frames: dict[str, LinkFrame], point: Vector, force: Vector) -> dict[str, Term]:
    """Torque, or force, at each joint of a chain of a force at a point of its first link, by name.

    Parameters
    ----------
    chain : sequence of Shape
        See `chain_of`.
    frames : dict from name to LinkFrame
    point : Vector, m
        In the link's own axes.
    force : Vector, N
        In the ground's frame.
    """
    forces: dict[str | None, Vector] = {None: force}
    for shape in reversed(chain):
        here = from_parent(forces[shape.parent], frames[shape.name], parent_frame(shape, frames))
        forces[shape.name] = named(here, f"force_{shape.name}_")
    found, from_joint = {}, _from_joint(point, chain[0].name, frames)
    for shape in chain:
        frame, here = frames[shape.name], forces[shape.name]
        if shape.joint == "revolute":
            found[shape.name] = dot(frame.axis, cross(from_joint, here)).named(f"torque_{shape.name}")
        elif shape.joint == "prismatic":
            found[shape.name] = dot(frame.axis, here)
        from_joint = _from_parent(from_joint, shape, frames)
    return found


def point_leaves(terms: Recorder, prefix: str) -> Vector:
    """Three arguments of a kernel."""
    x, y, z = (terms.leaf(f"{prefix}{c}", f"{prefix}{c}") for c in "xyz")
    return x, y, z


def _from_joint(point: Vector, name: str, frames: dict[str, LinkFrame]) -> Vector:
    """A point given in a link's own axes, from its joint, in its base."""
    return named(rotated(point, frames[name].rotation), f"from_{name}_")


def _from_parent(point: Vector, shape: Shape, frames: dict[str, LinkFrame]) -> Vector:
    """A point given from a link's joint, from its parent's."""
    frame = frames[shape.name]
    found = to_parent(added(frame.offset, point), frame, parent_frame(shape, frames))
    return named(found, f"from_{shape.parent or 'ground'}_")
