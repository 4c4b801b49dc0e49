"""Whether links are a tree, with numbers that rigid bodies can have, in which every joint has something to move."""

import keyword
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.machine.tree.links import AXES, JOINTS, MAX_LINKS, TENSOR, VECTOR, Link

_ROUNDING = 1e-9  # of a principal moment of inertia, by which rounded numbers may miss a condition
_SINGULAR = 1e-12  # of the mass matrix, scaled to a diagonal of ones: below, digits are all lost
_POSES = 3


def check_tree(links: Sequence[Link]) -> None:
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
    frozen = tuple(Link(*map(_frozen, link)) for link in links)
    try:
        hash(frozen)
    except TypeError:  # a list where a word belongs: the checks say which
        _check(frozen)
    else:
        _check_frozen(frozen)


def _frozen(value: Any) -> Any:
    """What stands for a field of a link where it must be hashable."""
    return tuple(value.items()) if isinstance(value, Mapping) else value


def _check(frozen: Sequence[Link]) -> None:
    links = [link._replace(at=dict(link.at), cg=dict(link.cg), inertia=dict(link.inertia)) for link in frozen]
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
        _check_inertia(link, _turning(link.name, links))
    _check_resistance(links)


_check_frozen = lru_cache(maxsize=64)(_check)  # a machine that is run again is the same


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
                raise InputError(
                    f"link {link.name}: {what} has no component {component!r}; it has {', '.join(allowed)}"
                )
            if not math.isfinite(value):
                raise InputError(f"link {link.name}: {what} {component} is {value!r}, which is no number")
    if link.mass is None:
        if link.cg:
            raise InputError(f"link {link.name} has a centre of gravity but no mass; give a mass, or leave cg out")
    elif not (math.isfinite(link.mass) and link.mass > 0.0):
        raise InputError(
            f"link {link.name}: mass {link.mass!r} kg; must be above 0, or left out for a link without mass"
        )


def _turning(name: str, links: Sequence[Link]) -> set[str]:
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
    low, middle, high = np.linalg.eigvalsh(_tensor(link)).tolist()
    shown = f"{low:.6g}, {middle:.6g} and {high:.6g} kg m2"
    if low < -_ROUNDING * high:
        raise InputError(f"link {link.name}: principal moments of inertia are {shown}; none may be below 0")
    if high > (low + middle) * (1.0 + _ROUNDING):
        raise InputError(
            f"link {link.name}: principal moments of inertia are {shown}; in a rigid body none is larger than the other two "
            "together; check the components, and declare all of them for a link that turns about several directions"
        )


def _check_resistance(links: Sequence[Link]) -> None:
    """The mass matrix must not be singular: not in all of a few positions without symmetry."""
    joints = [link for link in links if link.joint != "fixed"]
    culprit = 0
    for pose in range(1, _POSES + 1):
        mass = _mass_matrix(links, [math.sqrt(2.0 + i) * pose % 3.0 for i in range(len(joints))])
        own = np.diag(mass)
        if np.any(own == 0.0):
            culprit = int(np.argmin(own))
            continue
        size = np.sqrt(own)
        values, vectors = np.linalg.eigh(mass / np.outer(size, size))
        if values[0] > _SINGULAR:
            return
        culprit = int(np.argmax(np.abs(vectors[:, 0])))
    link = joints[culprit]
    wanted = "mass" if link.joint == "prismatic" else f"mass off its axis, or inertia {(link.axis or '')[-1] * 2}"
    raise InputError(
        f"link {link.name}: nothing resists the motion of its joint; give {link.name}, or what hangs on it, {wanted}"
    )


def _mass_matrix(links: Sequence[Link], q: Sequence[float]) -> np.ndarray:
    """Mass matrix in one position, by the velocities that the joints give to each link."""
    n, column = len(q), 0
    total = np.zeros((n, n))
    # of each link: how it is turned, velocity of its origin and angular velocity by joint
    known: dict[str | None, tuple[np.ndarray, ...]] = {None: (np.eye(3), np.zeros((3, n)), np.zeros((3, n)))}
    for link in links:
        turn, linear, angular = known[link.parent]
        linear, angular = _carried(linear, angular, turn @ _vector(link.at)), angular.copy()
        if link.axis is not None:
            along = _vector({link.axis[-1]: -1.0 if link.axis[0] == "-" else 1.0})
            if link.joint == "revolute":
                angular[:, column] = turn @ along
                turn = turn @ _rotation(along, q[column])
            else:
                linear = _carried(linear, angular, q[column] * (turn @ along))
                linear[:, column] = turn @ along
            column += 1
        known[link.name] = (turn, linear, angular)
        centre = _without_rounding(_carried(linear, angular, turn @ _vector(link.cg)))
        spin = _without_rounding(turn.T @ angular)
        total += (link.mass or 0.0) * centre.T @ centre + spin.T @ _tensor(link) @ spin
    return total


def _carried(linear: np.ndarray, angular: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Velocities at the end of an arm."""
    return linear - _across(arm) @ angular


def _without_rounding(velocities: np.ndarray) -> np.ndarray:
    """What lies on an axis does not move with it."""
    return np.where(np.abs(velocities) < _SINGULAR * np.max(np.abs(velocities)), 0.0, velocities)


def _vector(given: Mapping[str, float]) -> np.ndarray:
    return np.array([given.get(c, 0.0) for c in VECTOR])


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    cross = _across(axis)
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def _across(vector: np.ndarray) -> np.ndarray:
    """The matrix that takes a vector to the cross product of `vector` and it; `np.cross` is ten times as slow for so few numbers."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _tensor(link: Link) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = (link.inertia.get(c, 0.0) for c in TENSOR)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
