"""Passes through two circuits that a crossover joins: how many settle, and what lanes rely on."""

import numba
import numpy as np
import pytest

from helpers.crossover_made import BEHIND_GIVING, STATUS, attempted, bracket_all, off, random_states, solved
from helpers.series_made import STATES
from polydraulic.machine.circuits.crossover.circuit import joined_4
from polydraulic.machine.circuits.crossover.nodes import CrossoverOrifice
from polydraulic.machine.circuits.crossover.passes import joined_begin, joined_pass, joined_path
from polydraulic.machine.circuits.series.check import PROVED
from polydraulic.machine.valve import Orifices

PLAIN = bool(numba.config.DISABLE_JIT)


@pytest.mark.parametrize(("exponent", "share"), [(0.0, 0.99), (1.0, 0.93)])
def test_nearly_all_states_of_real_valves_settle(machine, exponent, share):
    states = random_states(machine, "real", exponent, 40 if PLAIN else 2000, 7)
    found = attempted(states, exponent > 0.0)
    assert np.mean(found[:, BEHIND_GIVING]) >= share
    settled = found[:, BEHIND_GIVING] > 0.0
    if exponent == 0.0:
        assert np.mean(found[settled, STATUS] == PROVED) >= share


@pytest.mark.parametrize("kind", STATES)
def test_passes_that_know_torque_limits_do_the_same_to_pumps_without_one(machine, kind):
    states = random_states(machine, kind, 0.0, 10 if PLAIN else 500, 8)
    assert np.array_equal(attempted(states), attempted(states, torque=True))


def test_what_has_settled_stays(machine):
    states = random_states(machine, "real", 0.0, 5, 9)
    crosses, inlets, bypasses, ports, gives, takes = states
    for i in range(5):
        k = [Orifices(a, b, 0.0) for a, b in zip(inlets[i], bypasses[i], strict=True)]
        v = joined_4(CrossoverOrifice(*crosses[i]), *k, *ports[i], gives, takes)
        r, x = joined_path(v), joined_begin(gives, takes)
        for _ in range(40):
            x = joined_pass(x, r, v.ports, gives, takes, False, False)
        assert x.still
        again = joined_pass(x, r, v.ports, gives, takes, False, False)
        for name in ("q_gives", "q_takes", "crosses", "w", "arrives", "still"):
            assert getattr(again, name) == getattr(x, name)


@pytest.mark.parametrize("kind", STATES)
def test_what_is_proved_is_what_brackets_find(machine, kind):
    """The brackets are those of the package itself, asked for every state; the judge of `test_crossover` knows neither."""
    states = random_states(machine, kind, 0.0, 20 if PLAIN else 2000, 10)
    found = attempted(states)
    true = solved(states, bracket_all)
    proved = found[:, STATUS] == PROVED
    assert np.mean(proved) > 0.5
    assert off(found, true, states)[proved].max() <= 1e-12
