"""Levers that kernels give, held to the geometry in plain Python, over all kinds of drives."""

import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import load_machine
from polydraulic.elementary import sincos
from polydraulic.machine import drives
from polydraulic.machine.drives import prepare_drive
from polydraulic.parameters.layout.geometry import lever

KERNELS = {name: getattr(drives, f"drive_{name}") for name in ("motor", "ram", "cylinder", "four_bar")}


def functions(folder):
    for machine in (load_machine(write_crane(folder)), load_machine("cat215b_bucket")):
        for f in machine.functions:
            yield f, machine.link(f.moves)


def test_levers_are_areas_times_how_fast_the_cylinder_grows(tmp_path):
    for f, link in functions(tmp_path):
        drive = prepare_drive(f, link)
        for angle in np.linspace(f.stops.low, f.stops.high, 9):
            joint = sincos(angle) if link.joint == "revolute" else angle
            found = KERNELS[f.actuator](joint, drive)
            if f.actuator == "motor":
                expected = (f.drive.displacement * f.drive.gear_ratio,) * 2
            else:
                head = f.drive.number * np.pi / 4 * f.drive.bore**2
                rod = f.drive.number * np.pi / 4 * (f.drive.bore**2 - f.drive.rod**2)
                growth = lever(f, link, angle)
                expected = (growth * head, growth * rod) if growth > 0 else (-growth * rod, -growth * head)
            assert found == pytest.approx(expected, rel=1e-12), (f.name, angle)


def test_line_a_pushes_towards_positive_motion_whichever_way_the_cylinder_is_built_in(tmp_path):
    for f, link in functions(tmp_path):
        middle = 0.5 * (f.stops.low + f.stops.high)
        found = KERNELS[f.actuator](sincos(middle) if link.joint == "revolute" else middle, prepare_drive(f, link))
        assert found.a > 0.0
        assert found.b > 0.0


def test_slopes_of_levers_are_differences(tmp_path):
    for f, link in functions(tmp_path):
        drive = prepare_drive(f, link)
        slopes = getattr(drives, f"drive_{f.actuator}_slopes")

        def at(position, kernel=KERNELS[f.actuator], drive=drive, turns=link.joint == "revolute"):
            return np.array(kernel(sincos(position) if turns else position, drive))

        for angle in np.linspace(f.stops.low, f.stops.high, 9):
            found = slopes(sincos(angle) if link.joint == "revolute" else angle, drive)
            true = (at(angle + 1e-6) - at(angle - 1e-6)) / 2e-6
            assert found == pytest.approx(true, rel=1e-6, abs=1e-9), (f.name, angle)
        assert (f.actuator in ("motor", "ram")) == (tuple(found) == (0.0, 0.0))
