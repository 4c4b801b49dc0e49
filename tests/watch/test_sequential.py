"""Sequential tests: as many false alarms as they are set to, at most, and few blocks to a real one."""

import numpy as np
import pytest

from polydraulic.watch.expected import Whitened
from polydraulic.watch.kernels.evidence import KEPT, gather, room_of_evidence, sum_since
from polydraulic.watch.sequential import EvidenceSums, Limits, highest, threshold_for


def limits(threshold, n=1, both=False, slow=0.0):
    return Limits(threshold, np.ones(n), np.full(n, slow), np.array([[True, both]] * n))


@pytest.mark.parametrize("information", [0.2, 1.0, 6.0])
def test_false_alarms_come_no_sooner_than_the_threshold_says(information):
    """Mean time to an alarm of healthy blocks, by simulation: at least exp(threshold) blocks."""
    rng, threshold, runs = np.random.default_rng(3), 4.0, 300
    evidence = EvidenceSums(limits(threshold, runs))
    alarmed = np.zeros(runs)
    blocks = 600
    for _ in range(blocks):
        evidence.add(rng.normal(0.0, np.sqrt(information), runs), np.full(runs, information))
        now = evidence.alarms[:, 0]
        alarmed += now
        evidence.sums[now] = 0.0
    mean_time = runs * blocks / max(alarmed.sum(), 1.0)
    assert mean_time > np.exp(threshold)


def test_a_fault_is_found_in_few_blocks_and_no_block_decides_alone():
    rng, evidence = np.random.default_rng(4), EvidenceSums(limits(10.0))
    for _ in range(50):
        evidence.add(rng.normal(0.0, 2.0, 1), np.array([4.0]))
    assert not evidence.alarms.any()
    evidence.add(np.array([1e6]), np.array([4.0]))
    assert not evidence.alarms.any()
    evidence = EvidenceSums(limits(10.0))
    while not evidence.alarms.any() and evidence.count < 30:
        evidence.add(4.0 + rng.normal(0.0, 2.0, 1), np.array([4.0]))
    assert 8 <= evidence.count <= 20
    assert evidence.began[0, 0] <= 3


def test_ways_and_rates():
    evidence = EvidenceSums(limits(5.0, 2, both=True))
    for _ in range(20):
        evidence.add(np.array([-4.0, 4.0]), np.array([4.0, 4.0]))
    assert evidence.alarms.tolist() == [[False, True], [True, False]]
    evidence = EvidenceSums(limits(5.0))
    for _ in range(20):
        evidence.add(np.array([-4.0]), np.array([4.0]))
    assert not evidence.alarms.any()
    assert threshold_for(0.1, 50, 1.0) == pytest.approx(np.log(50 * 36000.0))
    assert threshold_for(1.0, 50, 1.0) < threshold_for(0.1, 50, 1.0)


def test_evidence_is_what_was_added():
    evidence = EvidenceSums(limits(5.0))
    for _ in range(20):
        evidence.add(np.array([1.0]), np.array([2.0]))
    assert evidence.showing[0] > 5.0
    white = Whitened(np.full((20, 1), 4.0), np.full((20, 1), 4.0))
    assert highest(white, limits(5.0))[0] == 10.0


def test_memory_does_not_grow_and_goes_back_so_far():
    """Sums of all directions are what was added as far back as is kept; `test_courses` has the course of one."""
    rng, live, began = np.random.default_rng(5), np.zeros(room_of_evidence(2)), np.zeros(4, dtype=np.int64)
    pull, information = rng.normal(size=(KEPT + 50, 2)), rng.uniform(size=(KEPT + 50, 2))
    for count, white in enumerate(np.column_stack([pull, information]), 1):
        gather(white, 0, np.ones(2), np.zeros(2), np.ones(2, dtype=np.int64), 5.0, count, live, 0, began, 0)
    for first in (50, KEPT):
        seen = np.zeros(6)
        sum_since(live, 0, 2, first, KEPT + 50, seen, 0)
        added = [pull[first:], information[first:], pull[first:] ** 2 / information[first:]]
        assert np.allclose(seen.reshape(3, 2), [part.sum(axis=0) for part in added], rtol=1e-9, atol=1e-9)


def test_evidence_comes_to_an_end_where_a_fault_is_no_larger_than_what_strays():
    """A sum over blocks with information I is divided by the variance of its pull over I, 1 + slow I."""
    slow, size, known = 0.1, 0.8, 0.3
    evidence = EvidenceSums(limits(50.0, 2, slow=slow))
    for count in range(1, 300):  # up to what is remembered of the information
        evidence.add(np.array([size * known, 0.6 * known]), np.full(2, known))
        total = known * count
        expected = (np.array([size, 0.6]) - 0.5) * total / (1.0 + slow * total)
        assert evidence.sums[:, 0] == pytest.approx(expected, rel=1e-9)
        assert evidence.showing == pytest.approx(np.full(2, 0.5 * total / (1.0 + slow * total)), rel=1e-9)
    assert evidence.sums[0, 0] < (size - 0.5) / slow
    assert evidence.showing[0] < 0.5 / slow
    healthy = EvidenceSums(limits(50.0, slow=slow))
    for pull in (3.0, -8.0, 3.0):  # what comes after a new beginning knows nothing of what was before it
        healthy.add(np.array([pull]), np.array([2.0]))
    assert healthy.sums[0, 0] == pytest.approx(2.0 / (1.0 + slow * 2.0))


@pytest.mark.parametrize("before", [0, 180, 7200])
def test_a_fault_after_hours_of_straying_is_found_nearly_as_soon_as_one_after_minutes(before):
    evidence = EvidenceSums(limits(14.0, slow=0.006))
    for _ in range(before):
        evidence.add(np.array([0.55 * 10.0]), np.array([10.0]))
    assert evidence.sums[0, 0] < 14.0
    blocks = 0
    while evidence.sums[0, 0] < 14.0 and blocks < 100:
        evidence.add(np.array([2.0 * 10.0]), np.array([10.0]))
        blocks += 1
    assert blocks < 50


def test_a_block_that_counts_for_less_strays_for_less():
    evidence = EvidenceSums(limits(8.0, slow=0.5))
    for count in range(1, 6):
        evidence.add(
            np.array([1e6]), np.array([1e6])
        )  # of a fault of size 1: half of its information, of which the threshold's eighth counts
        assert evidence.sums[0, 0] == pytest.approx(count / (1.0 + 0.5 * 2.0 * count))
