"""Directions of faults: those of the catalogue that the sensors at hand may show, and their scores."""

import numpy as np
import pytest

from helpers.watched_logs import blocks, known, log_of
from polydraulic import load_machine
from polydraulic.watch.block import scores_of
from polydraulic.watch.directions import directions_of
from polydraulic.watch.watched import plan_of


@pytest.mark.parametrize("name", ["wheel_loader", "cat215b", "excavator_22t"])
def test_every_fault_that_sensors_may_show_is_watched_for(name):
    machine = load_machine(name)
    found = directions_of(machine, frozenset(f"{f}.spool" for f in machine.names))
    names = {d.name for d in found}
    assert {f"{c.name}.pump_worn" for c in machine.circuits} <= names
    assert {
        f"{f}.{what}" for f in machine.names for what in ("leak_across", "leak_out", "spool_slow", "spool_sticks")
    } <= names
    assert {n for n in names if n.endswith(".bias")} == {f"{f}.spool.bias" for f in machine.names}
    assert {d.name for d in found if d.harmless} == {"tip.payload_unknown", "oil.cold"}


def test_sizes_are_the_smallest_that_count():
    found = {d.name: d for d in directions_of(load_machine("cat215b"), frozenset(["boom.p_a"]))[::-1]}
    assert found["boom.pump_worn"].size == 0.05
    assert found["boom.pump_relief_low"].smallest == "relief valve of the pump of boom 10 % low"
    assert found["boom.spool_slow"].smallest == "spool of boom slow: its time constant is 100 % longer"
    assert found["boom.p_a.bias"].both
    assert not found["boom.leak_across"].both


@pytest.mark.parametrize("fault", ["work.pump_worn", "lift.leak_out"])
def test_scores_of_a_faulty_log_say_how_large_the_fault_is(fault):
    of, expected = known()
    faulty = log_of(of.machine, 14, 40.0, [fault])
    scores, _ = scores_of(plan_of(of, expected.noise), blocks(of, faulty)[0], expected.scales)
    place = [d.name for d in of.directions].index(fault)
    size = scores.pull[:, place].sum() / scores.information[:, place, place].sum()
    assert size == pytest.approx(1.0, abs=0.2)
    assert np.allclose(scores.information, scores.information.swapaxes(1, 2))
