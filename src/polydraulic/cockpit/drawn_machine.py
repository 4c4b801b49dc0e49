"""A drawing of a machine as data for a page: links, and what hangs on them as points of theirs."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from polydraulic.machine.frames import vector
from polydraulic.plotting.drawing import PLANE, Drawing, Outline, Spot, motion_of

_N_FOLLOWED = 101  # positions at which a follower's angle is given


def drawing_data(drawing: Drawing) -> dict[str, Any]:
    """All that is drawn of a machine, m and rad.

    Returns
    -------
    dict
        ``links`` (parents first; ``function`` is the number of what moves it, None of a follower, whose angle is linear between points of
        ``follows``), ``bodies`` (polygons, or hulls of balls where there are ``radii``; ``across`` is their breadth in space), ``rams``, ``stops``, ``pins``, ``tip``,
        ``ground``, ``corners``, ``scale``, ``slews``, ``initial`` positions. A spot is [link, [x, y, z]]; the link `PLANE` turns about the upright axis with
        the first one.
    """
    n, names = len(drawing.names), [link.name for link in drawing.links]
    links = []
    for place, link in enumerate(drawing.links):
        sign = -1.0 if link.axis[0] == "-" else 1.0
        links.append(
            {
                "name": link.name,
                "parent": link.parent,
                "joint": link.joint,
                "axis": [sign * float(c == link.axis[-1]) for c in "xyz"],
                "origin": vector(link.at).tolist(),
                "function": place if place < n else None,
                "follows": _followed(drawing, place) if place >= n else None,
            }
        )
    return {
        "links": links,
        "plane": PLANE,
        "slews": drawing.slews,
        "initial": list(drawing.initial),
        "bodies": [_body(body) for body in drawing.bodies],
        "rams": [{"base": _spot(r.base), "rod": _spot(r.rod), "barrel": r.barrel} for r in drawing.rams],
        "stops": [
            {
                "link": names[t.joint],
                "low": t.low,
                "high": t.high,
                "path": _spots(t.path),
                "ticks": [_spots(tick) for tick in t.ticks],
                "view": t.view,
            }
            for t in drawing.stops
        ],
        "pins": {name: _spot(spot) for name, spot in drawing.pins.items()},
        "tip": _spot(drawing.tip),
        "clear": [[_spot(spot), room] for spot, room in drawing.clear],
        "corners": {view: [list(corner) for corner in both] for view, both in drawing.corners.items()},
        "ground": drawing.ground,
        "scale": drawing.scale,
    }


def _followed(drawing: Drawing, place: int) -> dict[str, Any]:
    """Angles of a follower at positions of the function that it follows."""
    n = len(drawing.names)
    function = drawing.followers[place - n].joint
    positions = np.tile(np.array(drawing.initial), (_N_FOLLOWED, 1))
    positions[:, function] = np.linspace(*drawing.travel[function], _N_FOLLOWED)
    angles = motion_of(drawing, positions).positions[:, place]
    return {"function": function, "positions": positions[:, function].tolist(), "angles": angles.tolist()}


def _body(body: Outline) -> dict[str, Any]:
    return {
        "spots": _spots(body.spots),
        "radii": list(body.radii),
        "views": list(body.views),
        "fill": body.fill,
        "edge": body.edge,
        "across": [list(part) for part in body.across],
    }


def _spots(spots: Iterable[Spot]) -> list[list[Any]]:
    return [_spot(spot) for spot in spots]


def _spot(spot: Spot) -> list[Any]:
    return [spot.link, list(spot.at)]
