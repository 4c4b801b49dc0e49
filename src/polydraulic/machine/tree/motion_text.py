"""The text of the mechanics of a tree: named tuples and kernels, by the names of its links.

The text depends on the layout alone, byte for byte. The file that takes it has `MOTION_IMPORTS` at its top and defines `Joints` and
`Held`: one float, or one bool, for each link that is not fixed, in kinematic order. The text defines

- `Constants`, products of parameters, and `prepare_motion(links, gravity)`, plain Python, which fills them;
- `Turns` and `turns(q)`: sines and cosines of angles, ways of prismatic joints;
- `Mass`, `Motion` and `motion(turn, rate, constants)`: mass matrix, torques of motion and of gravity, which acts along -z of the ground;
- `times(mass, v)`, `solve_motion(mass, held, right)`, `kinetic(mass, rate)` and `potential(turn, constants)`;
- `place_LINK(turn, x, y, z, constants)` and `push_LINK(turn, x, y, z, fx, fy, fz, constants)` of the links asked for, where the point is
  given in the link's frame, its place and the force in the ground's.
"""

from collections.abc import Sequence

from polydraulic.errors import InputError
from polydraulic.machine.tree.constants_text import constants_text, prepare_text, shapes_text
from polydraulic.machine.tree.equations import TreeEquations, equations_of
from polydraulic.machine.tree.frames import axes_of_a_link
from polydraulic.machine.tree.link_checks import check_tree
from polydraulic.machine.tree.links import Link
from polydraulic.machine.tree.points import chain_of, place_of, point_leaves, torques_of
from polydraulic.machine.tree.shapes import Shape, shape_of
from polydraulic.machine.tree.solve_text import mass_text, solve_text, times_text
from polydraulic.machine.tree.statements import Constants, body, call, returned
from polydraulic.machine.tree.terms import ZERO, Recorder, Term

MOTION_IMPORTS = (
    "from typing import NamedTuple",
    "from polydraulic._kernel import kernel",
    "from polydraulic.elementary import SinCos, sincos",
    "from polydraulic.machine.tree.shapes import Shape, links_of_shape",
)


def moving(links: Sequence[Link]) -> list[str]:
    """Names of the links that are not fixed: the fields of `Joints` and `Held`."""
    return [link.name for link in links if link.joint != "fixed"]


def motion_text(links: Sequence[Link], *, points: Sequence[str] = ()) -> str:
    """Source of the mechanics of a tree.

    Parameters
    ----------
    links : sequence of Link
        Their numbers are checked, and do not enter.
    points : sequence of str
        Links of which `place_LINK` and `push_LINK` are wanted.

    Raises
    ------
    InputError
        If the links are no tree, or a number of theirs is impossible.
    """
    check_tree(links)
    shapes, names = [shape_of(link) for link in links], moving(links)
    for name in points:
        if name not in [link.name for link in links]:
            known = ", ".join(link.name for link in links)
            raise InputError(f"points of {name!r} are asked for, which is no link; links are {known}")
    terms, constants = Recorder(), Constants()
    frames = axes_of_a_link(shapes, terms)
    equations = equations_of(shapes, frames, terms)
    kernels = [_motion_text(names, equations, constants), _potential_text(equations, constants)]
    for name in points:
        chain = chain_of(name, shapes)
        terms.section = f"a point of {name}"
        point, force = point_leaves(terms, ""), point_leaves(terms, "f")
        kernels.append(_place_text(name, place_of(chain, frames, point), constants))
        kernels.append(_push_text(name, names, torques_of(chain, frames, point, force), constants))
    places = list(equations.mass)
    parts = [
        shapes_text(shapes),
        constants_text(constants, "Constants"),
        prepare_text(constants, "Constants", "prepare_motion"),
        _turns_text([shape for shape in shapes if shape.joint != "fixed"]),
        mass_text(names, places),
        _MOTION_CLASS,
        *([_PLACE_CLASS] if points else []),
        *kernels,
        times_text(names, places),
        solve_text(names, places),
    ]
    return "\n\n\n".join(parts) + "\n"


_MOTION_CLASS = '''class Motion(NamedTuple):
    """Mass matrix, and the torques in N m, or forces in N, that motion and gravity need."""

    mass: Mass
    bias: Joints  # Coriolis and centrifugal
    gravity: Joints'''

_PLACE_CLASS = '''class Place(NamedTuple):
    """A point in m, in the ground's frame."""

    x: float
    y: float
    z: float'''


def _turns_text(joints: Sequence[Shape]) -> str:
    fields = "\n".join(f"    {s.name}: {'SinCos' if s.joint == 'revolute' else 'float'}" for s in joints)
    reads = [f"sincos(q.{s.name})" if s.joint == "revolute" else f"q.{s.name}" for s in joints]
    return f'''class Turns(NamedTuple):
    """Sines and cosines of angles, ways in m."""

{fields}


@kernel
def turns(q):
    """Turns of the joints at angles in rad and ways in m."""
{returned(call("Turns", reads))}'''


def _motion_text(names: Sequence[str], equations: TreeEquations, constants: Constants) -> str:
    n, entries = len(names), list(equations.mass.values())

    def result(texts: list[str]) -> str:
        mass, bias, gravity = texts[: len(entries)], texts[len(entries) : -n], texts[-n:]
        return call("Motion", [call("Mass", mass), call("Joints", bias), call("Joints", gravity)])

    return f'''@kernel
def motion(turn, rate, constants):
    """Mass matrix and torques at a position and motion."""
    # Of a link: sin_ and cos_ of its angle against the first of the links that turn about parallel axes; in the axes of
    # what carries that one: _x from the parent's joint to its own, _mx and _mxx first and second moments of all mass
    # behind its joint, _far_mx the first about the parent's joint, _polar inertia about its axis; by motion alone: _ax
    # acceleration of its joint, _wxx the gradient of it, _fx and _nx force and moment that this takes.
{body([*entries, *equations.bias, *equations.gravity], result, constants)}'''


def _potential_text(equations: TreeEquations, constants: Constants) -> str:
    return f'''@kernel
def potential(turn, constants):
    """Potential energy in J, from the height of the ground's origin."""
{body([equations.potential], lambda texts: texts[0], constants)}'''


def _place_text(name: str, place: Sequence[Term], constants: Constants) -> str:
    return f'''@kernel
def place_{name}(turn, x, y, z, constants):
    """Place of a point of {name}, given in its frame, in the ground's frame; m."""
{body(place, lambda texts: call("Place", texts), constants)}'''


def _push_text(name: str, names: Sequence[str], torques: dict[str, Term], constants: Constants) -> str:
    roots = [torques.get(joint, ZERO) for joint in names]
    return f'''@kernel
def push_{name}(turn, x, y, z, fx, fy, fz, constants):
    """Torques of a force in N along the ground's axes at a point in m of {name}, given in its frame."""
{body(roots, lambda texts: call("Joints", texts), constants)}'''
