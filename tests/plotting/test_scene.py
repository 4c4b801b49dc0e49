import dataclasses

import numpy as np
import pytest

from helpers.made_runs import made_run, small_crane
from polydraulic.plotting.frames import frames_of
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.plotting.scene import moving_artists, scene


def test_a_scene_shows_its_frame(machine, whole):
    drawing = layout_drawing(machine)
    figure, update = scene(frames_of(whole, drawing.names, 10.0), drawing)
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
    high = machine.function("boom").stops.high
    at_stop = dataclasses.replace(
        whole["exact"], columns={**whole["exact"].columns, "boom.angle": np.full(121, high - 1e-3)}
    )
    colors = {}
    for name, run in (("free", whole["exact"]), ("stopped", at_stop)):
        drawing = layout_drawing(machine)
        figure, update = scene(frames_of({name: run}, drawing.names, 10.0), drawing)
        update(3)
        colors[name] = [line.get_color() for line in figure.axes[0].lines if line.get_linewidth() == 2.4]
    assert len(colors["free"]) == 4
    assert colors["free"].count("#c0392b") == 0
    assert colors["stopped"].count("#c0392b") == 1


def test_any_layout_is_drawn_where_its_run_is():
    crane = small_crane()
    run, drawing = made_run(crane), layout_drawing(crane)
    figure, update = scene(frames_of({"made": run}, crane.names, 10.0), drawing)
    update(4)
    side, top, *strips = figure.axes
    turn = run["slew.angle"][8]
    outward = (run["effector.x"][8] - 0.4) * np.cos(turn) + (run["effector.y"][8] + 0.1) * np.sin(turn)
    (pins,) = [line for line in side.lines if line.get_marker() == "o"]
    assert np.column_stack(pins.get_data())[-1] == pytest.approx([outward, run["effector.z"][8]])
    (trail,) = [line for line in top.lines if len(line.get_xdata()) == 5]
    assert np.column_stack(trail.get_data())[-1] == pytest.approx([run["effector.x"][8], run["effector.y"][8]])
    position = 1e3 * run["reach.position"][8]
    assert strips[2].get_title(loc="left") == f"reach position  {position:.1f} mm"


def test_a_joint_that_slides_is_marked_at_its_stop():
    crane = small_crane()
    run = made_run(crane)
    figure, update = scene(frames_of({"made": run}, crane.names, 20.0), layout_drawing(crane))

    def red(k):
        update(k)
        return sum(line.get_color() == "#c0392b" for axis in figure.axes for line in axis.lines)

    lowest = np.flatnonzero(np.isclose(run["reach.position"], 0.0))
    assert red(0) == 3  # all begin at their first stops
    assert len(lowest) > 1
    assert red(int(lowest[1])) >= 1
    assert red(2) == 0


def test_titles_of_many_functions_stay_in_their_places():
    """Twelve joints: three rows of strips, whose titles do not run into each other."""
    crane = small_crane()
    functions = tuple(crane.functions[0]._replace(name=f"a_rather_long_name_{k}", moves=f"link_{k}") for k in range(12))
    links = tuple(
        crane.links[1]._replace(name=f"link_{k}", parent=f"link_{k - 1}" if k else "ground") for k in range(12)
    )
    circuit = crane.circuits[0]._replace(functions=tuple(f.name for f in functions))
    many = crane._replace(links=links, functions=functions, circuits=(circuit,), tip=("link_11", {"x": 1.0}))
    figure, update = scene(frames_of({"made": made_run(many)}, many.names, 10.0), layout_drawing(many))
    update(3)
    strips = figure.axes[2:]
    assert len(strips) == 13
    titles = [axis._left_title.get_window_extent() for axis in strips]
    assert not any(a.overlaps(b) for k, a in enumerate(titles) for b in titles[:k])
