import itertools

import numpy as np
from matplotlib.figure import Figure

from polydraulic.plotting.labels import Label, _chosen, _Places, place_labels


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


def test_a_text_stays_off_lines_that_are_drawn():
    axis = Figure(figsize=(8.0, 6.0), dpi=100).add_axes((0.0, 0.0, 1.0, 1.0))
    axis.set_xlim(0.0, 8.0)
    axis.set_ylim(0.0, 6.0)
    (first,) = place_labels(axis, [Label("tip", (4.0, 3.0), {})], [])
    middle = axis.transData.inverted().transform(0.5 * (first.min + first.max))
    through = middle + np.array([[0.0, -2.0], [0.0, 2.0]])
    (box,) = place_labels(axis, [Label("tip", (4.0, 3.0), {})], [], [through])
    x = axis.transData.transform(middle)[0]
    assert first.min[0] < x < first.max[0]
    assert not box.min[0] <= x <= box.max[0]


def test_a_text_makes_room_for_one_that_comes_later():
    """The first takes the place that costs nothing; the second has no other, so that the first goes where it costs a little."""

    def places(*lows, cost):
        low = np.array(lows, float)
        tail = low[:, None] + np.zeros((len(low), 2, 2))
        return _Places(low, low + 10.0, tail, np.zeros(len(low), bool), np.array(cost))

    first, second = places((0.0, 0.0), (50.0, 0.0), cost=[0.0, 1.0]), places((5.0, 5.0), cost=[0.0])
    assert _chosen([first]) == [0]
    assert _chosen([first, second]) == [1, 0]
