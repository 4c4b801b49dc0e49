"""Angles that begin anew after a full turn go on."""

import numpy as np
import pytest

from polydraulic.measure.checks.turns import Turns

ANGLE = np.concatenate([np.linspace(0.0, 900.0, 400), np.linspace(900.0, -500.0, 700)])  # degrees


def continued(turns, value, size):
    parts = [turns.add(value[at : at + size]) for at in range(0, len(value), size)]
    anew = [at * size + places for at, (_, places) in enumerate(parts)]
    return np.concatenate([part for part, _ in parts]), np.concatenate(anew)


@pytest.mark.parametrize("low", [0.0, -180.0])
@pytest.mark.parametrize("size", [1, 7, 5000])
@pytest.mark.parametrize("turn", [360.0, 2.0 * np.pi])
def test_an_angle_goes_on_past_its_turns_whatever_the_blocks(low, size, turn):
    value = ANGLE / 360.0 * turn
    read = np.mod(value - low / 360.0 * turn, turn) + low / 360.0 * turn
    found, anew = continued(Turns(turn), read, size)
    assert np.allclose(found - found[0], value - value[0])
    assert np.array_equal(anew, np.flatnonzero(np.abs(np.diff(read)) > 0.5 * turn) + 1)


@pytest.mark.parametrize("size", [1, 7, 5000])
def test_an_angle_that_goes_on_by_itself_is_as_it_was(size):
    read = ANGLE.copy()
    read[300:320] += 300.0  # more than one turn is read: this is something else
    found, anew = continued(Turns(360.0), read, size)
    assert np.array_equal(found, read)
    assert not anew.size


def test_an_angle_that_went_on_does_not_jump_back_where_more_than_a_turn_is_read():
    found, anew = continued(Turns(360.0), np.array([200.0, 350.0, 10.0, 200.0, 374.0, 370.0]), 3)
    assert found.tolist() == [200.0, 350.0, 370.0, 560.0, 734.0, 730.0]
    assert anew.tolist() == [2]
