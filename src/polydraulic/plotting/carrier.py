"""What arms stand on, for the eye alone: tracks, upper structure and cab of an excavator, or a block."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from polydraulic.parameters.layout.parts import GROUND
from polydraulic.plotting.drawing import PLANE, Outline, Spot

INK, UPPER, CAB, GLASS, TRACK = "#34495e", "#e3e6ea", "#f4f6f8", "#d5e6f3", "#c9ced6"
DEPTH = 1.65  # of the ground below the boom foot, at the scale 1, where no file says where a machine stands
Point3 = Sequence[float] | np.ndarray
_REACH = 8.9  # m, of an excavator at the scale 1


def scale_of(reach: float) -> float:
    """Scale of a machine with this reach in m."""
    return reach / _REACH


def excavator_bodies(
    upper: str, axis: Point3, foot: Point3, scale: float, lowest: float = 0.0, depth: float | None = None
) -> tuple[Outline, ...]:
    """Tracks, upper structure and cab.

    Parameters
    ----------
    upper : str
        The link that turns.
    axis : (3,), m
        Its joint in the ground's frame.
    foot : (3,), m
        The boom's joint in the frame of `upper`.
    scale : float
        1 for a machine of 18 t.
    lowest : float, m
        Height of the lowest pin on the upper structure, from the boom's foot.
    depth : float, m, optional
        Of the ground below the boom's foot; in proportion if not given.
    """
    ahead, s = foot[0] + 0.55 * scale, scale
    k = 1.0 if depth is None else depth / (DEPTH * s)  # what is below the foot is as tall as the ground lets it be
    bottom = min(-0.72 * k * s, lowest - 0.05 * s)

    def still(corners: Sequence[tuple[float, float]]) -> tuple[Spot, ...]:
        return tuple(Spot(PLANE, (s * x, 0.0, axis[2] + foot[2] + s * z)) for x, z in corners)

    def turning(corners: Sequence[tuple[float, float]]) -> tuple[Spot, ...]:
        return tuple(Spot(upper, (x, 0.0, foot[2] + z)) for x, z in corners)

    def above(link: str, corners: Sequence[tuple[float, float]]) -> tuple[Spot, ...]:
        x0, y0 = (axis[0], axis[1]) if link == GROUND else (0.0, 0.0)
        return tuple(Spot(link, (x0 + x, y0 + y, 0.0)) for x, y in corners)

    def scaled(*corners: tuple[float, float]) -> list[tuple[float, float]]:
        return [(s * x, s * y) for x, y in corners]

    sole, wheel, upmost = -DEPTH * k, -1.35 * k, -0.87 * k
    track = [(-1.75, sole), (-2.05, wheel), (-1.85, upmost), (1.85, upmost), (2.05, wheel), (1.75, sole)]
    body = scaled((-2.72, -0.1), (-2.6, 0.42), (-1.3, 0.5), (-0.35, 0.5), (0.3, 0.3))
    front = [(ahead - 0.25 * s, 0.14 * s), (ahead, -0.3 * s), (ahead, bottom)]
    hood = scaled((-2.55, -1.25), (-2.72, -0.7), (-2.72, 0.7), (-2.55, 1.25))
    tracks, middle, whole = scaled((-1.5, -0.9), (0.9, 1.5)), scaled((-0.6, 0.6)), scaled((-1.25, 1.25))
    cab, panes = scaled((0.45, 1.2)), scaled((0.43, 1.22))
    return (
        _body(still(track), TRACK, across=tracks),
        _body(still([(-0.2, upmost), (0.2, upmost), (0.2, bottom / s), (-0.2, bottom / s)]), INK, across=middle),
        _body(turning([(-2.6 * s, bottom), *body, *front]), UPPER, across=whole),
        _body(turning(scaled((-0.42, -0.3), (-0.42, 1.3), (0.42, 1.3), (0.78, 0.35), (0.78, -0.3))), CAB, across=cab),
        _body(
            turning(scaled((-0.3, 0.42), (-0.3, 1.18), (0.35, 1.18), (0.62, 0.42))), GLASS, edge="none", across=panes
        ),
        _body(above(GROUND, scaled((-2.0, -1.5), (2.0, -1.5), (2.0, -0.9), (-2.0, -0.9))), TRACK, view="top"),
        _body(above(GROUND, scaled((-2.0, 0.9), (2.0, 0.9), (2.0, 1.5), (-2.0, 1.5))), TRACK, view="top"),
        _body(above(upper, [*hood, (ahead, 1.25 * s), (ahead, -1.25 * s)]), UPPER, view="top"),
        _body(
            above(upper, [*scaled((-0.45, 0.45), (-0.45, 1.2)), (ahead, 1.2 * s), (ahead, 0.45 * s)]), GLASS, view="top"
        ),
    )


def block(low: Point3, high: Point3, axis: Point3) -> tuple[Outline, ...]:
    """A block between two corners in the ground's frame, (3,) each in m; `axis` is where the side view begins, m."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    side = tuple(Spot(PLANE, (x - axis[0], 0.0, z)) for x, z in ((x0, z0), (x1, z0), (x1, z1), (x0, z1)))
    top = tuple(Spot(GROUND, (x, y, z0)) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)))
    return _body(side, TRACK, across=[(y0 - axis[1], y1 - axis[1])]), _body(top, TRACK, view="top")


def _body(
    spots: tuple[Spot, ...], fill: str, view: Any = "side", edge: str = INK, across: Sequence[tuple[float, float]] = ()
) -> Outline:
    return Outline(spots, (), (view,), fill, edge, tuple(across))
