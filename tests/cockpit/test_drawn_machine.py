"""A page places links by what it is told, and nothing else: as the drawing itself places them."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.cockpit.drawn_machine import drawing_data
from polydraulic.plotting.drawing import motion_of, places
from polydraulic.plotting.layout_shapes import layout_drawing


def turned(axis, angle):
    x = np.array(axis)
    cross = np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def placed(data, positions):
    """Frames of links as a page finds them."""
    frames = {"ground": (np.eye(3), np.zeros(3))}
    for link in data["links"]:
        turn, origin = frames[link["parent"]]
        if link["function"] is not None:
            q = positions[link["function"]]
        else:
            follows = link["follows"]
            q = np.interp(positions[follows["function"]], follows["positions"], follows["angles"])
        at = np.array(link["origin"], dtype=float)
        if link["joint"] == "prismatic":
            frames[link["name"]] = (turn, origin + turn @ (at + q * np.array(link["axis"])))
        else:
            frames[link["name"]] = (turn @ turned(link["axis"], q), origin + turn @ at)
    return frames


@pytest.mark.parametrize("name", ["cat215b_bucket", "loader_crane", "wheel_loader"])
def test_links_stand_where_the_drawing_has_them(name):
    drawing = layout_drawing(load_machine(name))
    data = drawing_data(drawing)
    rng = np.random.default_rng(5)
    low, high = np.clip(np.array(drawing.travel).T, -1.5, 1.5)
    for _ in range(5):
        positions = low + (high - low) * rng.uniform(0.05, 0.95, len(low))
        frames = placed(data, positions)
        motion = motion_of(drawing, positions[None])
        for pin, (link, at) in data["pins"].items():
            turn, origin = frames[link]
            np.testing.assert_allclose(
                origin + turn @ np.array(at), places(motion, [drawing.pins[pin]])[0, 0], atol=2e-3, err_msg=pin
            )
