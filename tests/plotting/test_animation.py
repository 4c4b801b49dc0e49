"""Animations: what is in them, not how they look."""

import dataclasses
import json
import re

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.plotting.animation import write_animation
from polydraulic.plotting.frames import frames_of
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


def test_another_ending_is_named(machine, whole, tmp_path):
    with pytest.raises(InputError, match=r"run.mp4: an animation ends in one of \['.gif', '.html'\], not in '.mp4'"):
        write_animation(whole, machine, tmp_path / "run.mp4")
