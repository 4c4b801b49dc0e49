"""Sections of Table 3, and networks grown in them."""

import numpy as np
import pytest

from polydraulic import build_flow
from polydraulic.thesis.historical import SECTIONS, flows_at, grow_outlets, grow_series, sections, series_flows
from polydraulic.thesis.three_links import points_with_faces

INCH = 0.0254


def test_sections_cover_table_3(machine):
    found = sections(machine)
    assert list(found) == list(SECTIONS)
    assert found["D"].swing == pytest.approx((0.188 * INCH, 0.376 * INCH))
    assert found["D"].stick == pytest.approx((0.188 * INCH, 0.564 * INCH))
    area = sum((s.swing[1] - s.swing[0]) * (s.stick[1] - s.stick[0]) for s in found.values())
    assert area == pytest.approx((0.564 * INCH) ** 2)


@pytest.mark.parametrize("section", SECTIONS)
def test_idle_links_get_no_flow_and_active_ones_do(machine, section):
    s = sections(machine)[section]
    box = np.array([s.swing, s.stick, (0.0, 1e6), (0.0, 1e6)])
    box[:2, 0] += 1e-9
    X = points_with_faces(box, 500, np.random.default_rng(0))
    flows = series_flows(machine, X)
    for q, active in zip(flows.T, s.active, strict=True):
        assert (q.max() > 0.0) == active


def test_points_with_faces_lie_in_the_box_and_on_every_face():
    box = np.array([(0.0, 1.0), (2.0, 5.0), (-1.0, 1.0)])
    X = points_with_faces(box, 400, np.random.default_rng(1))
    assert np.all((box[:, 0] <= X) & (box[:, 1] >= X))
    for axis in range(3):
        for end in box[axis]:
            assert np.sum(X[:, axis] == end) > 20


@pytest.mark.slow
def test_grown_networks_read_what_table_3_prints(machine):
    swing, stick = grow_series(machine, n=4000)
    used = [
        [{slot for node in network.nodes for slot in node.inputs if slot < 4} for network in model.networks]
        for model in (swing, stick)
    ]
    assert {0, 2} <= used[0][2] <= {0, 1, 2}  # C: swing's spool and pressure; the stick's spool if there are many rows
    assert used[1][1] == {1, 3}  # B: the stick's own
    assert used[0][3] == used[1][3] == {0, 1, 2, 3}  # D: all four
    assert not any((used[0][0], used[0][1], used[1][0], used[1][2], used[1][4]))
    flow = build_flow("polynomial", machine, models=[swing, stick, *grow_outlets(machine, n=1000)])
    box = np.array([(0.0, 0.188 * INCH), (0.0, 0.188 * INCH), (0.0, 2e7), (0.0, 2e7)])
    X = points_with_faces(box, 100, np.random.default_rng(2))
    assert np.all(flows_at(machine, flow, X) == flows_at(machine, "exact", X))
