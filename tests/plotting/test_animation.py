"""Animations: what is in them, not how they look."""

import dataclasses
import json
import re

import numpy as np
import pytest
from PIL import Image

from polydraulic.errors import InputError
from polydraulic.plotting.animation import write_animation
from polydraulic.plotting.frames import frames_of
from polydraulic.plotting.scene import moving_artists, scene
from polydraulic.plotting.shapes import linkage_shapes


def embedded(page):
    return json.loads(re.search(r"^const D = (.*);$", page, re.MULTILINE)[1])


def test_the_page_holds_the_runs_and_needs_no_network(machine, whole, tmp_path):
    write_animation(whole, machine, tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text()
    data = embedded(page)
    assert not re.search(r"https?:|src=|href=|@import|url\(", page)
    assert (data["title"], data["frames"], data["rate"]) == ("task", 13, 20.0)
    assert [run["name"] for run in data["runs"]] == ["exact", "iterative"]
    angles = np.array(data["runs"][1]["angles"])
    frames = frames_of(whole, 20.0)
    assert angles == pytest.approx(frames.angles[1], abs=1e-5)
    assert all(len(channel["values"]) == 2 for channel in data["channels"])
    assert all(len(values) == 13 for channel in data["channels"] for values in channel["values"])
    for channel, shown in zip(frames.channels, data["channels"], strict=True):
        largest = max(np.abs(v).max() for v in channel.values)
        for values, rounded in zip(channel.values, shown["values"], strict=True):
            assert rounded == pytest.approx(values, abs=1e-3 * largest)
    shapes = linkage_shapes(machine)
    assert data["shapes"]["boom_ram"]["barrel"] == shapes.boom_ram.barrel
    assert data["shapes"]["stops"] == {link: list(ends) for link, ends in shapes.stops.items()}
    assert len(page) < 60_000


def test_names_cannot_end_the_script(machine, whole, tmp_path):
    named = dataclasses.replace(whole["exact"], info={"scenario": "</script><b>"})
    write_animation({"<!--": named}, machine, tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text()
    assert page.count("</script>") == 1
    assert embedded(page)["title"] == "</script><b>"


def test_a_gif_lasts_as_long_as_the_run(machine, whole, tmp_path):
    seen = []
    write_animation(whole, machine, tmp_path / "run.gif", rate=10.0, progress=lambda *done: seen.append(done))
    with Image.open(tmp_path / "run.gif") as image:
        durations = []
        for number in range(image.n_frames):
            image.seek(number)
            durations.append(image.info["duration"])
        assert image.n_frames > 2
        assert sum(durations) == 700
        assert image.info["loop"] == 0
        assert image.convert("RGB").getpixel((image.width - 1, image.height - 1)) == (255, 255, 255)
    assert seen == [("draw", k, 7) for k in range(1, 8)]
    assert [path.name for path in tmp_path.iterdir()] == ["run.gif"]


def test_an_interrupted_gif_leaves_nothing(machine, whole, tmp_path):
    def stop(what, done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_animation(whole, machine, tmp_path / "run.gif", progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_another_ending_is_named(machine, whole, tmp_path):
    with pytest.raises(InputError, match=r"run.mp4: an animation ends in one of \['.gif', '.html'\], not in '.mp4'"):
        write_animation(whole, machine, tmp_path / "run.mp4")


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
