"""A load at the tip: the last link with a point mass more."""

from itertools import combinations

import numpy as np

from polydraulic.parameters.layout.parts import COORDINATES, LinkParameters, Point
from polydraulic.parameters.layout.schema import LayoutMachine


def with_payload(machine: LayoutMachine, mass: float) -> LayoutMachine:
    """Return the machine with a point mass at its tip.

    The link of the tip declares all that any such mass needs, so that machines with different loads, none included, share a layout.

    Parameters
    ----------
    machine : LayoutMachine
    mass : float, kg
        At least 0.
    """
    name, at = machine.tip
    links = tuple(_loaded(link, at, mass) if link.name == name else link for link in machine.links)
    return machine._replace(links=links)


def _loaded(link: LinkParameters, at: Point, mass: float) -> LinkParameters:
    spread = [c for c in COORDINATES if c in link.cg or c in at]
    whole = link.mass + mass
    cg, place = _vector(link.cg), _vector(at)
    middle = (link.mass * cg + mass * place) / whole if whole > 0.0 else cg
    tensor = _tensor(link) + link.mass * _point_inertia(cg - middle) + mass * _point_inertia(place - middle)
    pairs = [a + b for a, b in combinations(COORDINATES, 2) if a + b in link.inertia or (a in spread and b in spread)]
    names = ["xx", "yy", "zz", *pairs]
    return link._replace(
        mass=whole,
        cg={c: float(middle[COORDINATES.index(c)]) for c in spread},
        inertia={n: float(tensor[COORDINATES.index(n[0]), COORDINATES.index(n[1])]) for n in names},
    )


def _vector(point: Point) -> np.ndarray:
    return np.array([point.get(c, 0.0) for c in COORDINATES])


def _tensor(link: LinkParameters) -> np.ndarray:
    """Inertia about the centre of gravity, (3, 3); the entry xy is minus the integral of x y over the mass."""
    found = np.zeros((3, 3))
    for name, value in link.inertia.items():
        i, j = COORDINATES.index(name[0]), COORDINATES.index(name[1])
        found[i, j] = found[j, i] = value
    return found


def _point_inertia(d: np.ndarray) -> np.ndarray:
    """Of one kilogram at a distance, (3, 3) in m2."""
    return np.asarray(d @ d * np.eye(3) - np.outer(d, d))
