"""Inputs that are known in advance, and the parts of a run."""

import numpy as np
import pytest

from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant, Piecewise, Sine
from polydraulic.simulation.layout.methods.known import breaks_of, first_piece, known_parts
from polydraulic.simulation.solvers.spools import inputs_at

FORCE = {"x": Piecewise(np.array([0.2, 0.5, 0.9]), np.array([0.0, 4e3, -1e3])), "z": Sine(2e3, 3.0)}


def test_forces_are_known_at_any_time_and_steps_end_at_their_corners(crane):
    scenario = Scenario("pushed", 1.5, {"lift": Constant(0.3)}, loads=Loads(FORCE))
    (part,) = known_parts(crane, scenario, 1.5)
    assert {0.2, 0.5, 0.9, 1.5} <= set(breaks_of(part))
    x, v = np.empty((2, 6))
    for t in np.linspace(0.0, 1.5, 31):
        piece = first_piece(part.motion, t)
        inputs_at(part.motion.coefficients[piece], part.motion.starts[piece], t, x, v)
        assert x[3:] == pytest.approx(scenario.loads.forces(np.array([t]))[0], abs=1e-9)
        assert v[5] == pytest.approx(6e3 * np.cos(3.0 * t))
        assert x[0] == x[2] == 0.0


def test_a_spool_stops_steps_at_its_own_knots(crane):
    (part,) = known_parts(crane, Scenario("lift", 1.0, {"lift": Constant(0.8)}), 1.0)
    pilot, knots = crane.function("lift").pilot, np.array(crane.function("lift").valve.knots[1:-1])
    passed = pilot.dead_time - pilot.time_constant * np.log1p(-knots / (0.8 * pilot.gain))
    assert breaks_of(part) == pytest.approx([pilot.dead_time, *passed, 1.0])


def test_a_payload_parts_the_run_when_it_comes_and_goes(crane):
    loads = Loads(payload=Payload((0.25, 0.5, 3.0), (200.0, 0.0, 100.0)))
    parts = [*known_parts(crane, Scenario("loaded", 2.0, {}, loads=loads), 2.0)]
    assert [(part.start, part.end) for part in parts] == [(0.0, 0.25), (0.25, 0.5), (0.5, 2.0)]
    masses = [part.machine.link("arm").mass for part in parts]
    assert masses == [120.0, 320.0, 120.0]
    assert [breaks_of(part)[-1] for part in parts] == [0.25, 0.5, 2.0]
    assert parts[0].module is parts[1].module
