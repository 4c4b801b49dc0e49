"""Margins of an exported machine: the bits of the columns of a run, on the slope that is given at each step."""

import numpy as np
import pytest

from helpers import c_machine
from polydraulic import InputError, load_machine, random_operator, simulate
from polydraulic.export.machine import machine_parts
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.parameters.layout.chassis import Slope
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.simulation.layout.stability.columns import margin_columns
from polydraulic.simulation.layout.stability.text import SLOPE


@pytest.fixture(scope="module")
def loader():
    return load_machine("wheel_loader")


def same_bits(a, b):
    return np.array_equal(np.ascontiguousarray(a).view(np.int64), np.ascontiguousarray(b).view(np.int64))


def on(machine, pitch, roll):
    return machine._replace(chassis=machine.chassis._replace(slope=Slope(pitch, roll)))


def test_the_c_code_has_the_bits_of_the_columns(loader, tmp_path):
    """A random operator who meets end stops, on level ground and on a slope that is an input."""
    c = c_machine.CMachine(loader, "exact", tmp_path, stability=True)
    outputs = [name for name, _ in machine_parts(loader, "exact", stability=True).outputs]
    margins = [name for name, _ in margin_columns(loader.chassis)]
    assert outputs[-len(margins) :] == margins
    for pitch, roll in ((0.0, 0.0), (0.2, -0.1)):
        operator = random_operator(3, 4.0, functions=loader.names)
        scenario = adapted(loader, operator)
        run = simulate(on(loader, pitch, roll), "exact", operator, stability=True)
        volts = step_inputs(scenario, operator, np.arange(run.info["steps"]) * 5e-3)
        found, status = c.run(np.column_stack([volts[:, :2], np.full(len(volts), pitch), np.full(len(volts), roll)]))
        assert not status.any()
        rows = slice(0 if pitch == 0.0 else 1, None)  # the start knows the slope of the file alone
        for name in margins:
            assert same_bits(found[rows, outputs.index(name)], run[name][rows]), name
    assert any("stop" in str(event[2]) for event in run.info["events"])


def test_slope_stands_behind_voltages_and_force(loader):
    parts = machine_parts(loader, "exact", force=True, stability=True)
    assert parts.inputs == ("lift.voltage", "tilt.voltage", "tip.force_x", "tip.force_y", "tip.force_z", *SLOPE)
    assert (parts.numbers.body.pitch, parts.numbers.body.roll) == (0.0, 0.0)


def test_a_machine_without_chassis_has_no_margins_to_export(loader):
    with pytest.raises(InputError, match=r"no \[chassis\]"):
        machine_parts(loader._replace(chassis=None), "exact", stability=True)
