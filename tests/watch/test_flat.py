"""Sensors that do not move although their function works."""

import numpy as np

from helpers.watched_logs import blocks, known, log_of
from polydraulic.watch.block import scores_of
from polydraulic.watch.flat import longest_flat, too_long
from polydraulic.watch.kernels.stays import FLAT, MOVES, RESTS
from polydraulic.watch.watched import plan_of


def states_of(of, expected, readings):
    states = scores_of(plan_of(of, expected.noise), readings, expected.scales)[1]
    return dict(zip(of.columns, states.T, strict=True))


def test_a_sensor_that_holds_is_flat_while_its_function_works():
    of, expected = known()
    log = log_of(of.machine, 15, 30.0, ["lift.angle.freeze from 5 s"])
    readings, _ = blocks(of, log)
    states = states_of(of, expected, readings)
    assert MOVES not in states["lift.angle"][6:]
    assert FLAT in states["lift.angle"]
    assert MOVES in states["tilt.angle"]
    still = {name: np.zeros_like(values) for name, values in readings.items()}
    assert all(np.all(s == RESTS) for s in states_of(of, expected, still).values())


def test_rest_neither_counts_nor_ends_a_run():
    runs = longest_flat({"a": np.array([FLAT, FLAT, RESTS, FLAT, MOVES, FLAT]), "b": np.array([MOVES, RESTS])})
    assert runs == {"a": 3, "b": 0}
    assert [too_long(n) for n in (0, 1, 4)] == [5, 5, 14]
