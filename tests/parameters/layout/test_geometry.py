"""Levers of pins and linkages, held to how lengths change in space."""

import math

import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import load_machine
from polydraulic.machine.frames import link_frames, placed
from polydraulic.parameters.layout.geometry import knee_at, lever, plane, rocker


def length(machine, function, angle):
    """From base to rod pin, from the places of the links in space."""
    positions = np.array([f.initial.angle for f in machine.functions])
    positions[machine.names.index(function.name)] = angle
    frames = link_frames(machine, positions)
    link = machine.link(function.moves)
    return float(
        np.linalg.norm(placed(frames, link.parent, function.pins.base) - placed(frames, link.name, function.pins.rod))
    )


@pytest.mark.parametrize("axis", ["x", "-x", "y", "-y", "z", "-z"])
def test_a_lever_is_the_slope_of_the_length(tmp_path, axis):
    machine = load_machine(write_crane(tmp_path))
    point = {"x": 0.7, "y": -0.2, "z": -0.1}
    base = {"x": 0.2, "y": 0.15, "z": 0.6}
    links = tuple(link._replace(axis=axis) if link.name == "boom" else link for link in machine.links)
    function = machine.function("lift")._replace(pins=machine.function("lift").pins._replace(base=base, rod=point))
    machine = machine._replace(links=links)
    for angle in np.linspace(-1.0, 1.0, 7):
        slope = (length(machine, function, angle + 1e-6) - length(machine, function, angle - 1e-6)) / 2e-6
        assert lever(function, machine.link("boom"), angle) == pytest.approx(slope, abs=1e-8)


def test_a_bucket_linkage_keeps_the_lengths_of_rocker_and_coupler():
    machine = load_machine("cat215b_bucket")
    f, link = machine.function("bucket"), machine.link("bucket")
    r = rocker(f.pins, link)
    for angle in np.linspace(*f.stops, 25):
        knee, pin = knee_at(r, angle)
        assert math.dist(knee, r.hinge) == pytest.approx(r.rocker, abs=1e-12)
        assert math.dist(knee, pin) == pytest.approx(math.dist(*_at_zero(f, link)), abs=1e-12)
        ram = [math.dist(knee_at(r, angle + h)[0], r.base) for h in (-1e-6, 1e-6)]
        assert lever(f, link, angle) == pytest.approx((ram[1] - ram[0]) / 2e-6, abs=1e-7)


def _at_zero(f, link):
    u0, v0 = plane(link.at, link.axis)
    knee = plane(f.pins.knee, link.axis)
    return (knee[0] - u0, knee[1] - v0), plane(f.pins.pin, link.axis)


def test_the_knee_is_where_the_file_says_while_the_joint_is_at_zero():
    machine = load_machine("cat215b_bucket")
    f, link = machine.function("bucket"), machine.link("bucket")
    knee, _ = knee_at(rocker(f.pins, link), 0.0)
    assert knee == pytest.approx(_at_zero(f, link)[0], abs=1e-12)
