"""Steps that are too large for a machine, by its fastest oscillation."""

import numpy as np
import pytest

from polydraulic import simulate
from polydraulic.parameters.scenario import Scenario
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.step_check import DOUBTFUL, fastest_oscillation, step_warnings


def test_one_free_joint_oscillates_as_its_inertia_and_oil_say(crane):
    ready = prepare_layout(crane, 5e-3, ("lift", "extend"))
    place = getattr(ready.module.position, "py_func", ready.module.position)
    functions = ready.module.Functions
    at = functions(*(f.initial.angle for f in crane.functions))
    inertia = place(at, functions(0.0, 0.0, 0.0), ready.plant).motion.mass.m11
    f = crane.function("slew")
    lever = f.drive.displacement * f.drive.gear_ratio
    stiffness = lever**2 * (1.0 / f.line.compliance_a + 1.0 / f.line.compliance_b)
    assert fastest_oscillation(crane, ready) == pytest.approx(np.sqrt(stiffness / inertia), rel=1e-6)


def test_a_large_step_is_named_with_what_is_usual(crane):
    ready = prepare_layout(crane, 5e-3)
    omega = fastest_oscillation(crane, ready)
    assert step_warnings(crane, ready, 0.99 * DOUBTFUL / omega) == []
    (line,) = step_warnings(crane, ready, 1.01 * DOUBTFUL / omega)
    assert "is large for this machine" in line
    assert "usual is" in line


def test_a_run_says_it_and_a_usual_one_does_not(crane):
    hang = Scenario("hang", 0.2, {})
    assert "doubtful_inputs" not in simulate(crane, "exact", hang).info
    (line,) = simulate(crane, "exact", hang, dt=0.1).info["doubtful_inputs"]
    assert line.startswith("dt = 0.1 s is large for this machine")
