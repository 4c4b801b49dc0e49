"""Links without their numbers: what the text of the equations of motion is written for."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from polydraulic.errors import InputError
from polydraulic.machine.tree.link_checks import check_tree
from polydraulic.machine.tree.links import TENSOR, VECTOR, Link


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
    check_tree(links)
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
