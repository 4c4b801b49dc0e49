import dataclasses

import numpy as np
import pytest

from polydraulic.plotting.frames import frames_of
from polydraulic.plotting.scene import moving_artists, scene
from polydraulic.plotting.shapes import linkage_shapes


def test_a_scene_shows_its_frame(machine, whole):
    frames, shapes = frames_of(whole, 10.0), linkage_shapes(machine)
    figure, update = scene(frames, shapes)
    update(5)
    assert next(text.get_text() for text in figure.texts) == "  0.50 s"
    strips = figure.axes[2:]
    boom = np.degrees(whole["exact"]["boom.angle"][100])
    assert strips[1].get_title(loc="left") == f"boom angle  {boom:.1f} deg"
    assert len(strips) == 4
    assert strips[0].lines[-1].get_xdata() == pytest.approx([0.5, 0.5])
    moving = moving_artists(figure)
    assert strips[0].lines[-1] in moving
    assert strips[0].lines[0] not in moving  # curves are drawn once


def test_a_joint_at_its_stop_is_marked(machine, whole):
    high = machine.boom.stops.high
    at_stop = dataclasses.replace(
        whole["exact"], columns={**whole["exact"].columns, "boom.angle": np.full(121, high - 1e-3)}
    )
    colors = {}
    for name, run in (("free", whole["exact"]), ("stopped", at_stop)):
        figure, update = scene(frames_of({name: run}, 10.0), linkage_shapes(machine))
        update(3)
        colors[name] = [line.get_color() for line in figure.axes[0].lines if line.get_linewidth() == 2.4]
    assert len(colors["free"]) == 4
    assert colors["free"].count("#c0392b") == 0
    assert colors["stopped"].count("#c0392b") == 1
