"""Sensors that do not move although their function works."""

import numpy as np

from helpers.watched_logs import blocks, known, log_of
from polydraulic.watch.flat import FLAT, MOVES, RESTS, flat_blocks, longest_flat, too_long


def test_a_sensor_that_holds_is_flat_while_its_function_works():
    of, expected = known()
    log = log_of(of.machine, 15, 30.0, ["lift.angle.freeze from 5 s"])
    readings, _ = blocks(of, log)
    states = flat_blocks(of.machine, readings, of.shape, expected.noise)
    assert MOVES not in states["lift.angle"][6:]
    assert FLAT in states["lift.angle"]
    assert MOVES in states["tilt.angle"]
    still = {name: np.zeros_like(values) for name, values in readings.items()}
    assert all(np.all(s == RESTS) for s in flat_blocks(of.machine, still, of.shape, expected.noise).values())


def test_rest_neither_counts_nor_ends_a_run():
    runs = longest_flat({"a": np.array([FLAT, FLAT, RESTS, FLAT, MOVES, FLAT]), "b": np.array([MOVES, RESTS])})
    assert runs == {"a": 3, "b": 0}
    assert [too_long(n) for n in (0, 1, 4)] == [5, 5, 14]
