import itertools

import numpy as np
from matplotlib.figure import Figure

from polydraulic.plotting.labels import Label, place_labels


def test_labels_of_a_crowd_cover_neither_each_other_nor_the_points():
    axis = Figure(figsize=(8.0, 6.0), dpi=100).add_axes((0.0, 0.0, 1.0, 1.0))
    axis.set_xlim(0.0, 8.0)
    axis.set_ylim(0.0, 6.0)
    points = 4.0 + 0.25 * np.random.default_rng(3).normal(size=(18, 2))
    boxes = place_labels(
        axis, [Label(f"pin number {k}", tuple(p), {"fontsize": 8.0}) for k, p in enumerate(points)], []
    )
    assert len(boxes) == 18
    assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
    assert all(axis.bbox.contains(*box.min) and axis.bbox.contains(*box.max) for box in boxes)
    shown = axis.transData.transform(points)
    assert not any(box.contains(*point) for box in boxes for point in shown)


def test_a_lonely_label_stands_next_to_its_point_and_off_what_is_filled():
    axis = Figure(figsize=(8.0, 6.0), dpi=100).add_axes((0.0, 0.0, 1.0, 1.0))
    axis.set_xlim(0.0, 8.0)
    axis.set_ylim(0.0, 6.0)
    below = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 3.0], [0.0, 3.0]])
    (box,) = place_labels(axis, [Label("tip", (4.0, 3.0), {})], [below])
    assert 300.0 <= box.min[1] < 330.0
    assert len(axis.lines) == 0  # no line is needed
