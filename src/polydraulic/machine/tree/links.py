"""A tree of links: what hangs where by which joint, and the numbers of each link.

The frame of a link has its origin in its joint, and is parallel to the parent's frame where the joint stands at zero. A vector or
tensor holds the components that the layout declares; the others are zero by structure, and cost nothing. Whether a component
is declared is a matter of the layout, never of its value: a declared 0.0 stays in the equations.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

MAX_LINKS = 12
JOINTS = ("revolute", "prismatic", "fixed")
AXES = ("x", "y", "z", "-x", "-y", "-z")
VECTOR = ("x", "y", "z")
TENSOR = ("xx", "yy", "zz", "xy", "xz", "yz")
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
