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
_ALONG = np.linspace(0.0, 1.0, 17)  # of a line from a text to its point
_SWEEPS = 8  # over all texts, each put where it is best while the others stay
_NEAR = 4.0  # px, of a line to a pin or of a drawn line's samples

# what a place costs: texts on texts, texts beyond the picture, texts on pins, lines on texts, on lines and on pins, texts on drawn lines and on what is filled
_TEXT, _OUTSIDE, _PIN, _LINE_ON_TEXT, _CROSSING, _LINE_ON_PIN, _DRAWN, _FILLED = (
    100.0,
    100.0,
    6.0,
    8.0,
    6.0,
    3.0,
    3.0,
    3.0,
)
_AWAY = 0.03  # for each px from the point


class Label(NamedTuple):
    """A text and the point that it names, in the axis' coordinates."""

    text: str
    point: tuple[float, float]
    style: dict[str, Any]


class _Places(NamedTuple):
    """Where a label may stand, px; all of n places."""

    low: np.ndarray  # (n, 2) corners of the text
    high: np.ndarray
    tail: np.ndarray  # (n, len(_ALONG), 2) points of the line from the text to its point
    has_line: np.ndarray  # (n,)
    cost: np.ndarray  # (n,) of everything but other labels


def place_labels(
    axis: "Axes", labels: Sequence[Label], filled: Sequence[np.ndarray], lines: Sequence[np.ndarray] = ()
) -> list["Bbox"]:
    """Set labels where together they cover nothing, or least; a line leads to the point from those that lie apart.

    They are set one after the other, then each again while the others stay, until none finds a better place.

    Parameters
    ----------
    axis : matplotlib Axes
        With its limits and its place in the figure as they will be.
    labels : sequence of Label
    filled, lines : sequences of (n, 2) arrays
        Outlines and lines that texts should stay clear of.

    Returns
    -------
    list of matplotlib Bbox
        Where the texts stand, in pixels.
    """
    from matplotlib.path import Path
    from matplotlib.patheffects import withStroke
    from matplotlib.transforms import Bbox

    transform = axis.transData
    paths = [Path(transform.transform(outline)) for outline in filled]
    drawn = [_sampled(transform.transform(line)) for line in lines]
    points = np.array([transform.transform(label.point) for label in labels]).reshape(-1, 2)
    halo = [withStroke(linewidth=2.5, foreground="white", alpha=0.8)]
    texts = [
        axis.text(*label.point, label.text, ha="center", va="center", zorder=9, path_effects=halo, **label.style)
        for label in labels
    ]
    places = [
        _places(point, np.array(text.get_window_extent().size) + 3.0, points, paths, drawn, axis)
        for point, text in zip(points, texts, strict=True)
    ]
    chosen = _chosen(places)
    boxes = []
    for label, text, where, best, point in zip(labels, texts, places, chosen, points, strict=True):
        low, high = where.low[best], where.high[best]
        x, y = transform.inverted().transform(0.5 * (low + high))
        text.set_position((x, y))
        boxes.append(Bbox([low, high]))
        if where.has_line[best]:
            ends = transform.inverted().transform([point, where.tail[best, 0]])
            axis.plot(*ends.T, color=label.style.get("color", "0.4"), linewidth=0.6, alpha=0.7, zorder=8)
    return boxes


def _places(
    point: np.ndarray,
    size: np.ndarray,
    points: np.ndarray,
    paths: Sequence[Any],
    drawn: Sequence[np.ndarray],
    axis: "Axes",
) -> _Places:
    """All places of a label round its point, and what each of them costs whatever the other labels do."""
    frame, away = axis.get_window_extent(), np.repeat(_DISTANCES, _DIRECTIONS)
    middles = point + _offsets(size)
    low, high = middles - 0.5 * size, middles + 0.5 * size
    near = np.clip(point, low, high)
    tail = near[:, None] + _ALONG[:, None] * (point - near[:, None])
    has_line = away > _DISTANCES[0]
    raster = (low[:, None] + _RASTER * size).reshape(-1, 2)
    covered = sum(path.contains_points(raster).reshape(len(middles), -1).mean(axis=1) for path in paths)
    crossed = sum(np.any(_in_boxes(line, low - 1.0, high + 1.0), axis=1) for line in drawn)
    pins = _in_boxes(points, low - _NEAR, high + _NEAR).sum(axis=1)
    others = points[np.abs(points - point).max(axis=1) > _NEAR]
    met = (np.abs(tail[:, :, None] - others).max(axis=3) < _NEAR).any(axis=1).sum(axis=1) * has_line
    outside = np.any((low < frame.min) | (high > frame.max), axis=1)
    cost = _OUTSIDE * outside + _PIN * pins + _LINE_ON_PIN * met + _FILLED * covered + _DRAWN * crossed
    return _Places(low, high, tail, has_line, cost + _AWAY * away)


def _chosen(places: Sequence[_Places]) -> list[int]:
    """Which place each label takes."""
    chosen: list[int] = []
    for where in places:
        chosen.append(int(np.argmin(_with_others(where, places, chosen))))
    for _ in range(_SWEEPS):
        before = list(chosen)
        for k, where in enumerate(places):
            others = [(other, best) for j, (other, best) in enumerate(zip(places, chosen, strict=True)) if j != k]
            cost = _with_others(where, [other for other, _ in others], [best for _, best in others])
            best = int(np.argmin(cost))
            chosen[k] = best if cost[best] < cost[chosen[k]] else chosen[k]
        if chosen == before:
            break
    return chosen


def _with_others(where: _Places, others: Sequence[_Places], chosen: Sequence[int]) -> np.ndarray:
    """What the places of a label cost next to others where they stand; those behind the last that is chosen stand nowhere yet."""
    cost = where.cost.copy()
    for other, best in zip(others, chosen, strict=False):
        low, high, tail = other.low[best], other.high[best], other.tail[best]
        cost += _TEXT * np.all((where.low < high) & (where.high > low), axis=1)
        cost += (
            _LINE_ON_TEXT * where.has_line * np.any(np.all((where.tail > low) & (where.tail < high), axis=2), axis=1)
        )
        if other.has_line[best]:
            cost += _LINE_ON_TEXT * np.any(_in_boxes(tail, where.low, where.high), axis=1)
            cost += _CROSSING * where.has_line * _cross(where.tail[:, 0], where.tail[:, -1], tail[0], tail[-1])
    return cost


def _in_boxes(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Which points (m, 2) lie in which boxes (n, 2), (n, m)."""
    inside: np.ndarray = np.all((low[:, None] < points) & (points < high[:, None]), axis=2)
    return inside


def _cross(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Which of the lines from a to b, (n, 2) each, cross that from c to d, (n,)."""

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        turn: np.ndarray = (q - p)[..., 0] * (r - p)[..., 1] - (q - p)[..., 1] * (r - p)[..., 0]
        return turn

    apart: np.ndarray = (side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0)
    return apart


def _sampled(line: np.ndarray) -> np.ndarray:
    """Points along a line of corners (n, 2), px, no farther apart than a few pixels."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], 2 + int(length[-1] / _NEAR))
    return np.column_stack([np.interp(at, length, line[:, k]) for k in (0, 1)])


def _offsets(size: np.ndarray) -> np.ndarray:
    """From a point to the middles of a text in all directions, so that its edge is as far away as wanted, (n, 2)."""
    turn = 2.0 * pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    directions = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.concatenate(
        [away * directions + 0.5 * size * np.clip(1.5 * directions, -1.0, 1.0) for away in _DISTANCES]
    )
