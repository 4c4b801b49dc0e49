"""Windows simulated side by side."""

import numpy as np
import pytest

from helpers.operator_log import operator_log
from polydraulic import load_machine
from polydraulic.identification.equations.shooting.runs import first_states, shoot, window_slopes
from polydraulic.identification.equations.shooting.windows import cut_windows
from polydraulic.parameters.layout.schema import position_columns

NAME = "wheel_loader"
STATE = ("p_a", "p_b", "angle", "rate")


def true_states(machine, log, windows):
    """States of the log at the starts of windows."""
    rows = np.searchsorted(log["time"], windows.time - 1e-6)
    slides = {"angle": "position", "rate": "speed"}
    names = [f"{f}.{q}" if f"{f}.{q}" in log.names else f"{f}.{slides[q]}" for q in STATE for f in machine.names]
    return log.matrix(names)[rows]


def test_the_true_machine_from_its_true_states_gives_the_log():
    machine, log = load_machine(NAME), operator_log(NAME, noise=0.0)
    windows = cut_windows(machine, log, [*position_columns(machine), "tilt.p_a", "tilt.spool"], seconds=1.0, most=8)
    rows = shoot(machine, windows, true_states(machine, log, windows))
    assert rows is not None
    scale = np.ptp(windows.measured, axis=(0, 1))
    # commands between rows are cubics, the operator's are not quite
    assert np.abs(rows - windows.measured).max(axis=(0, 1)) == pytest.approx(0.0, abs=0.02 * scale.max())
    assert np.median(np.abs(rows - windows.measured) / scale) < 1e-4


def test_states_without_pressures_come_near_the_true_ones():
    machine, log = load_machine(NAME), operator_log(NAME, noise=0.0)
    windows = cut_windows(machine, log, position_columns(machine), seconds=1.0, most=16)
    n, found, truth = len(machine.names), first_states(machine, windows), true_states(machine, log, windows)
    assert np.median(np.abs(found - truth)[:, : 2 * n]) < 5e5  # Pa
    assert np.allclose(found[:, 2 * n : 3 * n], truth[:, 2 * n : 3 * n], atol=5e-3)


def test_slopes_are_those_of_central_differences():
    machine, log = load_machine(NAME), operator_log(NAME, noise=0.0)
    windows = cut_windows(machine, log, position_columns(machine), seconds=1.0, most=8)
    states = true_states(machine, log, windows)
    here = shoot(machine, windows, states)
    path = "functions.tilt.pilot.gain"
    value = machine.function("tilt").pilot.gain
    found = window_slopes(machine, windows, states, here, [path], np.array([0.1 * value]))
    ahead, behind = (shoot(machine.with_values({path: value * f}), windows, states) for f in (1.0005, 0.9995))
    central = (ahead - behind) / (1e-3 * value)
    assert found.numbers.shape == (*here.shape, 1)
    assert np.median(np.abs(found.numbers[..., 0] - central)) < 1e-3 * np.abs(central).max()
    angle = 2 * len(machine.names)  # that of the first joint moves with its start
    assert np.allclose(found.states[:, :, 0, angle], 1.0, atol=0.05)
