"""The text of the slopes of what a motion needs, over positions and rates of the joints: recorded equations, differentiated.

The text stands on that of `motion_text`. The file that takes it has `MOTION_SLOPES_IMPORTS` at its top; it defines

- `SlopeConstants` and `prepare_slopes(links, gravity)`, which fills them;
- `motion_slopes(turn, rate, acceleration, x, y, z, fx, fy, fz, constants, by_position, by_rate)`: slopes of the torques
  M q'' + bias + gravity less those of a force at a point of the link that is pushed, at these accelerations. It writes row i and column j, of
  joints in their order, of two matrices, and leaves what is zero by structure as it is.
"""

from collections.abc import Sequence

from polydraulic.machine.tree.constants_text import constants_text, prepare_text, shapes_text
from polydraulic.machine.tree.derivatives import along_joint, along_rate, derivatives
from polydraulic.machine.tree.equations import equations_of
from polydraulic.machine.tree.frames import axes_of_a_link
from polydraulic.machine.tree.links import Link
from polydraulic.machine.tree.points import chain_of, point_leaves, torques_of
from polydraulic.machine.tree.shapes import Shape, shape_of
from polydraulic.machine.tree.statements import Constants, stored
from polydraulic.machine.tree.terms import ZERO, Recorder, Term

MOTION_SLOPES_IMPORTS = (
    "from typing import NamedTuple",
    "from polydraulic._kernel import driver",
    "from polydraulic.machine.tree.shapes import Shape, links_of_shape",
)


def motion_slopes_text(links: Sequence[Link], pushed: str | None = None) -> str:
    """Source of the slopes of a tree's motion.

    Parameters
    ----------
    links : sequence of Link
        Checked; their numbers do not enter.
    pushed : str, optional
        Link that a force pushes.
    """
    shapes, terms, constants = [shape_of(link) for link in links], Recorder(), Constants()
    joints = [shape for shape in shapes if shape.joint != "fixed"]
    needed = _needed(shapes, joints, pushed, terms)
    roots, places = [], []
    for column, joint in enumerate(joints):
        for what, leaves in (
            ("position", along_joint(terms, joint.name, turns=joint.joint == "revolute")),
            ("rate", along_rate(terms, joint.name)),
        ):
            terms.section = f"over the {what} of {joint.name}"
            for row, slope in enumerate(derivatives(needed, leaves)):
                if not slope.zero:
                    roots.append(slope)
                    places.append(f"by_{what}[{row}, {column}]")
    text = f'''@driver
def motion_slopes(turn, rate, acceleration, x, y, z, fx, fy, fz, constants, by_position, by_rate):
    """Slopes of what a motion needs, over positions and rates, into two matrices; N m and N, over rad, m and these over s."""
{stored(roots, places, constants)}'''
    parts = [
        shapes_text(shapes),
        constants_text(constants, "SlopeConstants"),
        prepare_text(constants, "SlopeConstants", "prepare_slopes"),
        text,
    ]
    return "\n\n\n".join(parts) + "\n"


def _needed(shapes: Sequence[Shape], joints: Sequence[Shape], pushed: str | None, terms: Recorder) -> list[Term]:
    """Torque, or force, that a motion needs at each joint, less what a force brings."""
    frames = axes_of_a_link(shapes, terms)
    equations = equations_of(shapes, frames, terms)
    force: dict[str, Term] = {}
    if pushed is not None:
        terms.section = f"force at {pushed}"
        force = torques_of(chain_of(pushed, shapes), frames, point_leaves(terms, ""), point_leaves(terms, "f"))
    found = [
        bias + gravity - force.get(joint.name, ZERO)
        for joint, bias, gravity in zip(joints, equations.bias, equations.gravity, strict=True)
    ]
    terms.section = "acceleration"
    accelerations = [terms.leaf(f"acceleration.{joint.name}", f"{joint.name}_acceleration") for joint in joints]
    for (i, j), entry in equations.mass.items():
        found[i] = found[i] + entry * accelerations[j]
        if i != j:
            found[j] = found[j] + entry * accelerations[i]
    return found
