"""Closed-form spool motion against the pilot's own equation, and the breaks."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helpers.valves import changed
from polydraulic import load_scenario
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import Pilot
from polydraulic.parameters.signals import Constant, Piecewise, Sine
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.simulation.solvers.lagging_spools import curve_at
from polydraulic.simulation.solvers.spools import KnownInput, inputs_at, known_motion
from polydraulic.thesis.excavator import LINKS, spool_of


class At(NamedTuple):
    """Spools at a time, m and m/s."""

    x: np.ndarray
    v: np.ndarray


RAMPS = Piecewise(np.array([0.1, 0.3, 0.8, 0.81, 1.7]), np.array([0.0, 0.9, 0.9, -1.3, 0.2]))
WILD = Scenario("wild", 2.0, {"swing": RAMPS, "boom": Sine(1.3, 5.0), "stick": Constant(0.5)})


def late(machine):
    return changed(machine, "boom", pilot={"dead_time": 0.13})


def spool_motion(machine, scenario, t_end):
    inputs = []
    for f in machine.functions:
        signal = scenario.voltage.get(f.name, Constant()) if f.name not in scenario.locked else Constant()
        inputs.append(KnownInput(signal, f.pilot, f.valve.knots[-1], f.valve.knots[:-1]))
    return known_motion(inputs, t_end)


def at(motion, t):
    piece = max(int(np.searchsorted(motion.starts, t, side="left")) - 1, 0)
    x, v = np.empty(3), np.empty(3)
    inputs_at(motion.coefficients[piece], motion.starts[piece], t, x, v)
    return At(x, v)


@pytest.mark.parametrize("scenario", [WILD, load_scenario("sine")], ids=lambda scenario: scenario.name)
def test_spools_follow_their_pilots(machine, scenario):
    machine = late(machine)
    motion = spool_motion(machine, scenario, 2.0)
    pilots = [machine.function(link).pilot for link in LINKS]
    tau, gain = np.array([p.time_constant for p in pilots]), np.array([p.gain for p in pilots])
    travel = spool_of(machine).end

    def rate(t, x):
        return (np.clip(gain * step_inputs(machine, scenario, np.array([t]))[0], -travel, travel) - x) / tau

    times = np.linspace(0.0, 2.0, 21)
    tight = solve_ivp(rate, (0.0, 2.0), np.zeros(3), t_eval=times, rtol=1e-9, atol=1e-12, max_step=2e-3)
    found = [at(motion, t) for t in times]
    assert np.array([s.x for s in found]) == pytest.approx(tight.y.T, abs=1e-8)
    inside = [t for t in times if np.abs(motion.starts - t).min() > 1e-3]
    slopes = [(np.array(at(motion, t + 1e-5).x) - np.array(at(motion, t - 1e-5).x)) / 2e-5 for t in inside]
    assert np.array([at(motion, t).v for t in inside]) == pytest.approx(np.array(slopes), abs=1e-6)


def test_breaks_are_where_spools_pass_knots(machine):
    motion = spool_motion(machine, WILD, 2.0)
    assert motion.breaks[-1] == 2.0
    assert np.all(np.diff(motion.breaks) > 0.0)
    levels = np.array(machine.functions[0].valve.knots[:-1])
    for t in np.setdiff1d(motion.breaks, motion.starts):
        nearest = min(np.abs(np.abs(x) - levels).min() for x in at(motion, t).x)
        assert nearest < 1e-12
    fine = np.linspace(0.0, 2.0, 4001)
    travel = np.array([at(motion, t).x for t in fine])
    passed = sum(np.count_nonzero(np.diff(np.sign(travel - sign * k), axis=0)) for k in levels[1:] for sign in (-1, 1))
    assert np.isin(motion.breaks, motion.starts, invert=True).sum() >= passed


@pytest.mark.parametrize("share", [0.5, 0.99, 1.0 - 1e-6])
def test_a_knot_that_is_passed_twice_within_a_piece_is_found_twice(share):
    """However little before it turns back a spool has passed it."""
    fall = Piecewise(np.array([0.0, 1e-3, 2.0]), np.array([0.0, 1.0, -1.0]))
    one = KnownInput(fall, Pilot(1.0, 0.3, 0.0), 2.0)
    fine = np.linspace(0.0, 1.0, 200_001)
    x = curve_at(*known_motion([one], 2.0)[:2], 0, fine)
    level = share * x.max()
    breaks = known_motion([one._replace(knots=(level,))], 2.0).breaks
    inside = breaks[(breaks > 2e-3) & (breaks < 1.0)]
    assert (np.diff(x > level).sum(), len(inside)) == (2, 2)
    assert inside[0] < fine[x.argmax()] < inside[1]
    assert curve_at(*known_motion([one], 2.0)[:2], 0, inside) == pytest.approx(level, rel=1e-12)


def test_locked_spools_stay(machine):
    scenario = Scenario("boom", 1.0, {"boom": Constant(0.3), "swing": Constant(0.3)}, ("swing", "stick"))
    assert at(spool_motion(machine, scenario, 1.0), 0.7).x[0] == 0.0
