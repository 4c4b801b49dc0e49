"""A machine's links as the equations of motion want them: named by the functions that move them."""

from polydraulic.machine.tree.links import Link
from polydraulic.parameters.layout.parts import GROUND
from polydraulic.parameters.layout.schema import LayoutMachine


def function_of(machine: LayoutMachine, link: str) -> str:
    """Name of the function that moves a link: what the text calls the link."""
    return next(f.name for f in machine.functions if f.moves == link)


def tree_of(machine: LayoutMachine) -> list[Link]:
    """Links in kinematic order, each under the name of its function, so that joints are called what the operator moves."""
    function_of = {f.moves: f.name for f in machine.functions}
    return [
        Link(
            f.name,
            None if link.parent == GROUND else function_of[link.parent],
            link.joint,
            link.axis,
            link.at,
            link.mass if link.mass > 0.0 else None,
            link.cg if link.mass > 0.0 else {},
            link.inertia,
        )
        for f in machine.functions
        for link in (machine.link(f.moves),)
    ]
