"""Names next to points of a picture, where they cover least."""

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.transforms import Bbox

# px at 100 dpi, from a point to the middle of a text's near edge
_DISTANCES = (
    11.0,
    18.0,
    28.0,
    40.0,
    55.0,
    75.0,
    100.0,
)
_DIRECTIONS = 20
_RASTER = np.stack(np.meshgrid(np.linspace(0.0, 1.0, 5), np.linspace(0.0, 1.0, 5)), axis=-1).reshape(-1, 2)  # of a text


class Label(NamedTuple):
    """A text and the point that it names, in the axis' coordinates."""

    text: str
    point: tuple[float, float]
    style: dict[str, Any]
    line: bool = True  # from the text to the point, where they are apart


def place_labels(axis: "Axes", labels: Sequence[Label], filled: Sequence[np.ndarray]) -> list["Bbox"]:
    """Set labels one after the other where they cover nothing, or least; a line leads to the point from those that lie apart.

    Parameters
    ----------
    axis : matplotlib Axes
        With its limits and its place in the figure as they will be.
    labels : sequence of Label
    filled : sequence of (n, 2) arrays
        Outlines that texts should stay clear of.

    Returns
    -------
    list of matplotlib Bbox
        Where the texts stand, in pixels.
    """
    from matplotlib.path import Path
    from matplotlib.patheffects import withStroke
    from matplotlib.transforms import Bbox

    transform, frame = axis.transData, axis.get_window_extent()
    paths = [Path(transform.transform(outline)) for outline in filled]
    points = np.array([transform.transform(label.point) for label in labels])
    halo, taken = [withStroke(linewidth=2.5, foreground="white", alpha=0.8)], list[Bbox]()
    for label, point in zip(labels, points, strict=True):
        text = axis.text(*label.point, label.text, ha="center", va="center", zorder=9, path_effects=halo, **label.style)
        size = np.array(text.get_window_extent().size) + 3.0
        middles = point + _offsets(size)
        low, high = middles - 0.5 * size, middles + 0.5 * size
        raster = (low[:, None] + _RASTER * size).reshape(-1, 2)
        covered = sum(path.contains_points(raster).reshape(len(middles), -1).mean(axis=1) for path in paths)
        over = sum(np.all((low < box.max) & (high > box.min), axis=1) for box in taken)
        pins = np.all((low[:, None] - 4.0 < points) & (points < high[:, None] + 4.0), axis=2).sum(axis=1)
        outside = np.any((low < frame.min) | (high > frame.max), axis=1)
        away = np.repeat(_DISTANCES, _DIRECTIONS)
        best = int(np.argmin(100.0 * over + 100.0 * outside + 6.0 * pins + 3.0 * covered + 0.02 * away))
        x, y = transform.inverted().transform(middles[best])
        text.set_position((x, y))
        taken.append(Bbox([low[best], high[best]]))
        if label.line and away[best] > _DISTANCES[0]:
            near = np.clip(point, low[best], high[best])
            ends = transform.inverted().transform([point, near])
            axis.plot(*ends.T, color=label.style.get("color", "0.4"), linewidth=0.6, alpha=0.7, zorder=8)
    return taken


def _offsets(size: np.ndarray) -> np.ndarray:
    """From a point to the middles of a text in all directions, so that its edge is as far away as wanted, (n, 2)."""
    turn = 2.0 * pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    directions = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.concatenate(
        [away * directions + 0.5 * size * np.clip(1.5 * directions, -1.0, 1.0) for away in _DISTANCES]
    )
