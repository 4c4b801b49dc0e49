"""Where the tip of a machine can be, in the plane of its arm."""

import numpy as np

from polydraulic.parameters.layout.parts import GROUND
from polydraulic.plotting.drawing import Drawing, motion_of, places, seen

_FINE, _COARSE = 100, 500  # positions of one joint, and of all others together


def tip_places(drawing: Drawing) -> np.ndarray:
    """Places of the tip in the side view, all over the travel of the joints that carry it, (n, 2) in m.

    Each joint moves finely while the others stand on a coarse grid from stop to stop.

    Parameters
    ----------
    drawing : Drawing
    """
    joints = _carriers(drawing)
    many = _FINE if len(joints) > 1 else 10 * _FINE  # a line without gaps
    count = max(2, round(_COARSE ** (1.0 / max(len(joints) - 1, 1))))
    found = []
    for fine in joints:
        steps = [np.linspace(*_once_round(drawing, j), many if j == fine else count) for j in joints]
        mesh = np.meshgrid(*steps, indexing="ij")
        positions = np.tile(drawing.initial, (mesh[0].size, 1))
        positions[:, joints] = np.stack([values.ravel() for values in mesh], axis=-1)
        motion = motion_of(drawing._replace(followers=(), links=drawing.links[: len(drawing.names)]), positions)
        found.append(seen(motion, "side", places(motion, [drawing.tip]))[:, 0])
    return np.concatenate(found)


def _once_round(drawing: Drawing, joint: int) -> tuple[float, float]:
    low, high = drawing.travel[joint]
    turns = drawing.links[joint].joint == "revolute" and high - low > 2.0 * np.pi
    return (-np.pi, np.pi) if turns else (low, high)


def _carriers(drawing: Drawing) -> list[int]:
    """Joints between the ground and the tip, without one that only turns the plane of the arm."""
    order = {link.name: place for place, link in enumerate(drawing.links)}
    found, name = [], drawing.tip.link
    while name != GROUND:
        found.append(order[name])
        name = drawing.links[order[name]].parent
    return [joint for joint in sorted(found) if not (drawing.slews and joint == 0)] or [0]


def tip_area(points: np.ndarray, cells: int = 150) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places as an area: x (n,), y (m,) of cells' centres, and how much of each can be reached, (m, n), 0 to 1."""
    from scipy.ndimage import binary_closing, binary_dilation, binary_erosion, gaussian_filter

    low, high = points.min(axis=0), points.max(axis=0)
    cell = max(float((high - low).max()) / cells, 1e-6)
    edges = [np.arange(a - 4.0 * cell, b + 5.0 * cell, cell) for a, b in zip(low, high, strict=True)]
    hit = np.histogramdd(points, bins=edges)[0] > 0
    area = binary_closing(hit, np.ones((3, 3)), iterations=2)
    if not binary_erosion(area, np.ones((3, 3))).any():  # a line, which must be seen
        area = binary_dilation(area, np.ones((3, 3)))
    area = gaussian_filter(area.astype(float), 0.7)
    x, y = (0.5 * (e[1:] + e[:-1]) for e in edges)
    return x, y, area.T
