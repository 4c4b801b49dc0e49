"""Suspects: the fault that explains most, and those that could be as well."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.watch.diagnosis import named_suspects
from polydraulic.watch.directions import directions_of
from polydraulic.watch.kernels.evidence import diagnose
from polydraulic.watch.kernels.numbers import MOST_LISTED
from polydraulic.watch.sequential import Since

DIRECTIONS = directions_of(load_machine("wheel_loader"), frozenset(["lift.p_a"]))


def seen(**amounts):
    """Sums over 20 blocks in which these directions are pulled so far, with an information of 100 each."""
    n = len(DIRECTIONS)
    pull = np.zeros(n)
    for k, d in enumerate(DIRECTIONS):
        pull[k] = 100.0 * amounts.get(d.name.replace(".", "_"), 0.0)
    return Since(pull, np.full(n, 100.0), pull**2 / 100.0, 20)


def suspects(**amounts):
    """Suspects of what these blocks say."""
    found, names = seen(**amounts), [d.name for d in DIRECTIONS]
    chances, listed = np.zeros(len(names)), np.zeros(MOST_LISTED, dtype=np.int64)
    down = np.array([d.both for d in DIRECTIONS], dtype=np.int64)
    group = np.array([names.index(name) for name in names], dtype=np.int64)
    count = diagnose(np.concatenate(found[:3]), 0, len(names), 1.0, down, group, chances, 0, listed, 0)
    return named_suspects(DIRECTIONS, found, 1.0, chances, listed[:count].tolist())


def test_the_most_likely_comes_first_with_its_size():
    first, *others = suspects(work_pump_worn=1.5, lift_leak_across=0.3)
    assert first.name == "work.pump_worn"
    assert first.size == pytest.approx(0.075)
    assert first.probability > 0.99
    assert first.title == "pump of work worn: its flow is 7.5 +- 0.5 % low"
    assert not others


def test_what_explains_as_much_is_named_as_well():
    first, *others = suspects(work_pump_worn=1.0, lift_leak_across=0.99, tip_payload_unknown=0.98)
    assert {s.name for s in (first, *others)} >= {"work.pump_worn", "lift.leak_across", "tip.payload_unknown"}
    assert first.probability < 0.8
    assert sum(s.probability for s in (first, *others)) == pytest.approx(1.0, abs=0.1)
    assert next(s for s in others if s.name == "tip.payload_unknown").harmless


def test_a_fault_that_would_go_the_other_way_is_no_suspect():
    found = suspects(work_pump_worn=-3.0, lift_p_a_bias=-1.0)
    assert found[0].name == "lift.p_a.bias"
    assert found[0].size < 0.0
    assert suspects() == []
