"""Animations: what is in them, not how they look."""

import dataclasses
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from helpers.made_runs import made_run, small_crane
from polydraulic.errors import InputError
from polydraulic.parameters.load import load_machine
from polydraulic.plotting.animation import write_animation
from polydraulic.plotting.drawing import motion_of, places, seen
from polydraulic.plotting.frames import frames_of
from polydraulic.plotting.layout_shapes import layout_drawing


def embedded(page):
    return json.loads(re.search(r"^const D = (.*);$", page, re.MULTILINE)[1])


def test_the_page_holds_the_runs_and_needs_no_network(machine, whole, tmp_path):
    write_animation(whole, machine, tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text()
    data = embedded(page)
    assert not re.search(r"https?:|src=|href=|@import|url\(", page)
    assert (data["title"], data["frames"], data["rate"]) == ("task", 13, 20.0)
    assert [run["name"] for run in data["runs"]] == ["exact", "iterative"]
    positions = np.array(data["runs"][1]["positions"])
    drawing = layout_drawing(machine)
    frames = frames_of(whole, drawing.names, 20.0)
    assert positions == pytest.approx(frames.positions[1], abs=1e-5)
    assert all(len(channel["values"]) == 2 for channel in data["channels"])
    assert all(len(values) == 13 for channel in data["channels"] for values in channel["values"])
    for channel, shown in zip(frames.channels, data["channels"], strict=True):
        largest = max(np.abs(v).max() for v in channel.values)
        for values, rounded in zip(channel.values, shown["values"], strict=True):
            assert rounded == pytest.approx(values, abs=1e-3 * largest)
    assert [ram["barrel"] for ram in data["rams"]] == [ram.barrel for ram in drawing.rams]
    assert [(s["joint"], s["low"], s["high"]) for s in data["stops"]] == [s[:3] for s in drawing.stops]
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


@pytest.mark.parametrize("build", [small_crane, lambda: load_machine("cat215b_bucket")])
def test_the_page_of_any_layout_has_its_names_and_finite_numbers(build, tmp_path):
    machine = build()
    runs = {"first": made_run(machine), "second": made_run(machine, scale=0.9)}
    write_animation(runs, machine, tmp_path / "run.html", rate=10.0)
    data = embedded((tmp_path / "run.html").read_text())
    groups = list(dict.fromkeys(channel["group"] for channel in data["channels"]))
    assert groups == [*machine.names, "pumps and tip"]
    assert data["frames"] == 11
    assert len(data["links"]) == len(machine.links) + sum(f.actuator == "four_bar" for f in machine.functions)
    numbers = list(numbers_in(data))
    assert len(numbers) > 500
    assert np.all(np.isfinite(numbers))
    linked = {spot[0] for part in (*data["bodies"], {"spots": data["pins"]}) for spot in part["spots"]}
    assert linked <= set(range(-2, len(data["links"])))


def test_a_page_plays_in_a_browser(tmp_path):
    """The page's own placing of links, in a browser without a screen: its tip is the run's, at a time between two frames."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser")
    if browser is None:
        pytest.skip("no browser here")
    machine = load_machine("cat215b_bucket")
    run = made_run(machine)
    write_animation({"made": run}, machine, tmp_path / "run.html", rate=20.0)
    page = (tmp_path / "run.html").read_text()
    asked = """
    const k = 7, spots = [], at = onScreen(D.runs[0], k, "side"), above = onScreen(D.runs[0], k, "top");
    document.body.setAttribute("data-found", JSON.stringify([D.pins.map(at.spot), above.spot(D.pins.at(-1)), hull([[0, 0], [2, 0]], [1, 0.5]).length]));
    </script>"""
    (tmp_path / "asked.html").write_text(page.replace("</script>", asked))
    command = [
        browser,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--virtual-time-budget=2000",
        "--dump-dom",
        f"{tmp_path}/asked.html",
    ]
    shown = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    pins, tip, corners = json.loads(re.search(r'data-found="([^"]*)"', shown)[1])
    drawing = layout_drawing(machine)
    motion = motion_of(drawing, frames_of({"made": run}, machine.names, 20.0).positions[0])
    assert np.array(pins) == pytest.approx(
        seen(motion, "side", places(motion, list(drawing.pins.values())))[7], abs=1e-3
    )
    assert tip == pytest.approx([run["effector.x"][7], run["effector.y"][7]], abs=1e-3)
    assert corners == 24 + 2  # half of each circle, and both points where it meets the straight sides


def numbers_in(data):
    if isinstance(data, dict):
        data = list(data.values())
    if isinstance(data, list):
        for item in data:
            yield from numbers_in(item)
    elif isinstance(data, float | int):
        yield data
