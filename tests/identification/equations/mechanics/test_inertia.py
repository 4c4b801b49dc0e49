"""Torques that links need are linear in their masses and moments."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.identification.equations.mechanics.inertia import (
    inertial_numbers,
    inertial_values,
    torque_regressor,
)
from polydraulic.machine.frames import link_frames
from polydraulic.machine.newton_euler import axis_of, needed_wrenches


@pytest.mark.parametrize("name", ["loader_crane", "cat215b_bucket", "wheel_loader"])
def test_regressor_times_numbers_is_what_newton_and_euler_need(name):
    machine, rng = load_machine(name), np.random.default_rng(0)
    n = len(machine.names)
    position, rate, acceleration = rng.normal(size=(3, 40, n))
    numbers = inertial_numbers(machine)
    found = torque_regressor(machine, numbers, position, rate, acceleration, machine.gravity) @ inertial_values(
        machine, numbers
    )
    frames = link_frames(machine, position)
    wrenches = needed_wrenches(machine, frames, rate, acceleration, np.zeros((40, 3)))
    for k, f in enumerate(machine.functions):
        link = machine.link(f.moves)
        passed = wrenches[f.name].force if link.joint == "prismatic" else wrenches[f.name].moment
        needed = np.sum(axis_of(link, frames) * passed, axis=1)
        assert np.allclose(found[:, k], needed, rtol=0.0, atol=1e-9 * np.abs(needed).max())


def test_numbers_are_those_that_the_layout_declares_or_that_follow():
    texts = [number.text for number in inertial_numbers(load_machine("loader_crane"))]
    assert [t for t in texts if t.startswith("outer")] == [
        "outer mass",
        "outer h.x",
        "outer J.xx",
        "outer J.yy",
        "outer J.zz",
    ]
    assert "inner J.xz" in texts  # of a centre of gravity off both axes


def test_moments_are_about_the_joint():
    machine = load_machine("loader_crane").with_values({"links.outer.cg.x": 2.0})
    numbers = inertial_numbers(machine)
    values = dict(zip([n.text for n in numbers], inertial_values(machine, numbers), strict=True))
    link = machine.link("outer")
    assert values["outer h.x"] == 2.0 * link.mass
    assert values["outer J.yy"] == pytest.approx(link.inertia["yy"] + 4.0 * link.mass)
    assert values["outer J.xx"] == pytest.approx(link.inertia["xx"])
