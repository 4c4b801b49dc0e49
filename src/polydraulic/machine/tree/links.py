"""A tree of links: what hangs where by which joint, and the numbers of each link.

The frame of a link has its origin in its joint, and is parallel to the parent's frame where the joint stands at zero. A vector or
tensor holds the components that the layout declares; the others are zero by structure, and cost nothing. Whether a component
is declared is a matter of the layout, never of its value: a declared 0.0 stays in the equations.
"""

import keyword
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError

MAX_LINKS = 12
JOINTS = ("revolute", "prismatic", "fixed")
AXES = ("x", "y", "z", "-x", "-y", "-z")
VECTOR = ("x", "y", "z")
TENSOR = ("xx", "yy", "zz", "xy", "xz", "yz")
_ROUNDING = 1e-9  # of a principal moment of inertia, by which rounded numbers may miss a condition
_NONE: Mapping[str, float] = MappingProxyType({})


class Link(NamedTuple):
    """A rigid body and the joint by which it hangs on its parent.

    Attributes
    ----------
    name : str
    parent : str or None
        None for the ground.
    joint : "revolute", "prismatic" or "fixed"
    axis : str or None
        "x", "y" or "z" of the parent's frame, or "-x", "-y", "-z": direction of positive motion. None for a fixed joint.
    at : mapping, m
        Place of the joint in the parent's frame, by "x", "y", "z".
    mass : float or None, kg
        None for a link without mass.
    cg : mapping, m
        Centre of gravity in the link's frame, by "x", "y", "z".
    inertia : mapping, kg m2
        Tensor about the centre of gravity in the link's frame, by "xx", "yy", "zz", "xy", "xz", "yz"; its entry xy is minus the
        integral of x y over the mass.
    """

    name: str
    parent: str | None
    joint: str
    axis: str | None = None
    at: Mapping[str, float] = _NONE
    mass: float | None = None
    cg: Mapping[str, float] = _NONE
    inertia: Mapping[str, float] = _NONE


class Shape(NamedTuple):
    """A link without its numbers: all that the text of the equations of motion depends on."""

    name: str
    parent: str | None
    joint: str
    axis: str | None
    at: tuple[str, ...]
    mass: bool
    cg: tuple[str, ...]
    inertia: tuple[str, ...]


def shape_of(link: Link) -> Shape:
    """What of a link is declared, without any number."""
    return Shape(
        link.name,
        link.parent,
        link.joint,
        link.axis,
        tuple(c for c in VECTOR if c in link.at),
        link.mass is not None,
        tuple(c for c in VECTOR if c in link.cg),
        tuple(c for c in TENSOR if c in link.inertia),
    )


def links_of_shape(links: Sequence[Link], shapes: Sequence[Shape]) -> dict[str, Link]:
    """Links by name, their numbers as floats, after a check that equations written for `shapes` are theirs.

    Raises
    ------
    InputError
        If a link differs from its shape in more than numbers, or a number is impossible.
    """
    check_links(links)
    for link, shape in zip(links, shapes, strict=False):
        if shape_of(link) != shape:
            raise InputError(
                f"link {link.name}: the equations of motion are written for {shape}, not for {shape_of(link)}; "
                "write them for these links"
            )
    if len(links) != len(shapes):
        raise InputError(f"{len(links)} links for equations of motion of {len(shapes)}; write them for these links")
    return {
        link.name: link._replace(
            at=_floats(link.at),
            cg=_floats(link.cg),
            inertia=_floats(link.inertia),
            mass=None if link.mass is None else float(link.mass),
        )
        for link in links
    }


def _floats(values: Mapping[str, float]) -> dict[str, float]:
    return {component: float(value) for component, value in values.items()}


def check_links(links: Sequence[Link]) -> None:
    """Check that links are a tree, parents before children, with numbers that a rigid body can have.

    Parameters
    ----------
    links : sequence of Link, 1 to 12
        In kinematic order.

    Raises
    ------
    InputError
        Naming the link, the value and what is allowed.
    """
    if not 1 <= len(links) <= MAX_LINKS:
        raise InputError(f"{len(links)} links; a machine has 1 to {MAX_LINKS}")
    names = [link.name for link in links]
    for place, link in enumerate(links):
        _check_name(link.name)
        if link.name in names[:place]:
            raise InputError(f"link {link.name} is there twice; give each link a name of its own")
        _check_parent(link, names[:place], names)
        _check_joint(link)
        _check_numbers(link)
    if all(link.joint == "fixed" for link in links):
        raise InputError("no link can move; at least one joint must be revolute or prismatic")
    for link in links:
        _check_something_moves(link, links)
        _check_inertia(link, turning(link.name, links))


def _check_name(name: str) -> None:
    taken = keyword.iskeyword(name) or name in ("count", "index")  # of any tuple
    if taken or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,39}", name):
        raise InputError(
            f"link {name!r}: a name is 1 to 40 ASCII letters, digits or underscores, begins with a letter, "
            "and is no word of Python"
        )


def _check_parent(link: Link, before: Sequence[str], names: Sequence[str]) -> None:
    if link.parent is None or link.parent in before:
        return
    if link.parent == link.name:
        raise InputError(f"link {link.name} hangs on itself; its parent is another link, or none for the ground")
    if link.parent in names:
        raise InputError(
            f"link {link.name} hangs on {link.parent}, which comes later: links form a tree without cycles, "
            "and stand in kinematic order, parents first"
        )
    raise InputError(f"link {link.name} hangs on {link.parent!r}, which is no link; links are {', '.join(names)}")


def _check_joint(link: Link) -> None:
    if link.joint not in JOINTS:
        raise InputError(f"link {link.name}: joint {link.joint!r}; must be one of {', '.join(JOINTS)}")
    if link.joint == "fixed" and link.axis is not None:
        raise InputError(f"link {link.name}: a fixed joint has no axis, but {link.axis!r} is given; leave it out")
    if link.joint != "fixed" and link.axis not in AXES:
        raise InputError(f"link {link.name}: axis {link.axis!r}; must be one of {', '.join(AXES)}")


def _check_numbers(link: Link) -> None:
    for what, values, allowed in (
        ("at", link.at, VECTOR),
        ("cg", link.cg, VECTOR),
        ("inertia", link.inertia, TENSOR),
    ):
        for component, value in values.items():
            if component not in allowed:
                raise InputError(f"link {link.name}: {what} has no component {component!r}; it has {', '.join(allowed)}")
            if not math.isfinite(value):
                raise InputError(f"link {link.name}: {what} {component} is {value!r}, which is no number")
    if link.mass is None:
        if link.cg:
            raise InputError(f"link {link.name} has a centre of gravity but no mass; give a mass, or leave cg out")
    elif not (math.isfinite(link.mass) and link.mass > 0.0):
        raise InputError(f"link {link.name}: mass {link.mass!r} kg; must be above 0, or left out for a link without mass")


def _check_something_moves(link: Link, links: Sequence[Link]) -> None:
    behind = {link.name}
    for other in links:
        if other.parent in behind:
            behind.add(other.name)
    moved = [other for other in links if other.name in behind]
    heavy = any(other.mass is not None for other in moved)
    if link.joint == "prismatic" and not heavy:
        raise InputError(f"link {link.name} has no mass, and nothing behind it has; give it a mass")
    if link.joint == "revolute" and not heavy and not any(other.inertia for other in moved):
        raise InputError(f"link {link.name} has neither mass nor inertia, and nothing behind it has; give it a mass")


def turning(name: str, links: Sequence[Link]) -> set[str]:
    """Directions, "x", "y" or "z", about which revolute joints turn a link, its own and those it hangs on."""
    by_name = {link.name: link for link in links}
    found: set[str] = set()
    at: str | None = name
    while at is not None:
        link = by_name[at]
        if link.joint == "revolute" and link.axis is not None:
            found.add(link.axis[-1])
        at = link.parent
    return found


def _check_inertia(link: Link, axes: Iterable[str]) -> None:
    """Principal moments of a body are not negative, and none is larger than the other two together.

    A link that only ever turns about one direction may declare its inertia about that direction alone.
    """
    if not link.inertia:
        return
    given = {c: link.inertia.get(c, 0.0) for c in TENSOR}
    for c in ("xx", "yy", "zz"):
        if given[c] < 0.0:
            raise InputError(f"link {link.name}: inertia {c} is {given[c]!r} kg m2; must not be below 0")
    if set(link.inertia) <= {axis + axis for axis in axes} and len(link.inertia) == 1 == len(set(axes)):
        return
    tensor = np.array(
        [
            [given["xx"], given["xy"], given["xz"]],
            [given["xy"], given["yy"], given["yz"]],
            [given["xz"], given["yz"], given["zz"]],
        ]
    )
    low, middle, high = np.linalg.eigvalsh(tensor).tolist()
    shown = f"{low:.6g}, {middle:.6g} and {high:.6g} kg m2"
    if low < -_ROUNDING * high:
        raise InputError(f"link {link.name}: principal moments of inertia are {shown}; none may be below 0")
    if high > (low + middle) * (1.0 + _ROUNDING):
        raise InputError(
            f"link {link.name}: principal moments of inertia are {shown}; in a rigid body none is larger than the other two "
            "together; check the components, and declare all of them for a link that turns about several directions"
        )
