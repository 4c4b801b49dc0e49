import numpy as np
import pytest

from polydraulic.machine.linkage import end_effector
from polydraulic.plotting.shapes import linkage_shapes, placed, pose

ANGLES = [(0.3, 0.5, -1.4), (-2.0, -0.6, -2.5), (1.0, 1.0, -0.5)]


@pytest.mark.parametrize(("swing", "boom", "stick"), ANGLES)
def test_the_drawn_tip_is_the_end_effector(machine, swing, boom, stick):
    shapes = linkage_shapes(machine)
    outward, upward = pose(shapes, boom, stick).tip
    x, y = placed([(outward, shapes.d)], np.zeros(2), swing)[0]
    assert (x, y, upward) == pytest.approx(end_effector(np.array([swing, boom, stick]), machine.geometry), abs=1e-12)


@pytest.mark.parametrize(("swing", "boom", "stick"), ANGLES)
def test_drawn_cylinders_have_the_length_of_their_triangle(machine, swing, boom, stick):
    shapes = linkage_shapes(machine)
    at = pose(shapes, boom, stick)
    for ram, base, rod, cylinder, turned in (
        (shapes.boom_ram, at.boom_base, at.boom_rod, machine.boom.cylinder, boom),
        (shapes.stick_ram, at.stick_base, at.stick_rod, machine.stick.cylinder, -stick),
    ):
        across = cylinder.r_base * cylinder.r_link * np.cos(cylinder.angle_offset + turned)
        length = np.sqrt(cylinder.r_base**2 + cylinder.r_link**2 - 2.0 * across)
        assert np.linalg.norm(rod - base) == pytest.approx(length)
        assert ram.barrel < length


def test_only_joints_with_stops_have_stops(machine):
    assert set(linkage_shapes(machine).stops) == {"boom", "stick"}
    swing = machine.swing._replace(stops=machine.swing.stops._replace(low=-1.0, high=2.0))
    assert linkage_shapes(machine._replace(swing=swing)).stops["swing"] == (-1.0, 2.0)
