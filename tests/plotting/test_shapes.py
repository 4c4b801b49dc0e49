import numpy as np
import pytest

from polydraulic.machine.linkage import end_effector
from polydraulic.plotting.drawing import motion_of, places
from polydraulic.plotting.shapes import excavator_drawing

ANGLES = [(0.3, 0.5, -1.4), (-2.0, -0.6, -2.5), (1.0, 1.0, -0.5)]


@pytest.mark.parametrize("angles", ANGLES)
def test_the_drawn_tip_is_the_end_effector(machine, angles):
    drawing = excavator_drawing(machine)
    tip = places(motion_of(drawing, np.array([angles])), [drawing.tip])[0, 0]
    assert tip == pytest.approx(end_effector(np.array(angles), machine.geometry), abs=1e-12)


@pytest.mark.parametrize("angles", ANGLES)
def test_drawn_cylinders_have_the_length_of_their_triangle(machine, angles):
    drawing, (_, boom, stick) = excavator_drawing(machine), angles
    motion = motion_of(drawing, np.array([angles]))
    for ram, cylinder, turned in zip(
        drawing.rams, (machine.boom.cylinder, machine.stick.cylinder), (boom, -stick), strict=True
    ):
        base, rod = places(motion, [ram.base, ram.rod])[0]
        across = cylinder.r_base * cylinder.r_link * np.cos(cylinder.angle_offset + turned)
        length = np.sqrt(cylinder.r_base**2 + cylinder.r_link**2 - 2.0 * across)
        assert np.linalg.norm(rod - base) == pytest.approx(length)
        assert ram.barrel < length


def test_only_joints_with_stops_have_stops(machine):
    def stops(machine):
        return {(stop.joint, stop.view): (stop.low, stop.high) for stop in excavator_drawing(machine).stops}

    boom, stick = tuple(machine.boom.stops), tuple(machine.stick.stops)
    assert stops(machine) == {(1, "side"): boom, (2, "side"): stick}
    swing = machine.swing._replace(stops=machine.swing.stops._replace(low=-1.0, high=2.0))
    assert stops(machine._replace(swing=swing))[0, "top"] == (-1.0, 2.0)
