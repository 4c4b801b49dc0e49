"""Offsets and jitter that healthy blocks show, found from blocks that were made with some."""

import numpy as np
import pytest

from polydraulic.watch.directions import Scores
from polydraulic.watch.expected import Whitened, learn_jitter, slow_variance, togetherness, whitened

OFFSET, JITTER = np.array([0.3, 0.0, -0.2]), np.array([0.05, 0.3, 0.2])


@pytest.fixture(scope="module")
def made():
    rng = np.random.default_rng(5)
    root = rng.normal(size=(800, 12, 3)) * np.array([4.0, 3.0, 5.0])
    information = root.swapaxes(1, 2) @ root
    amount = OFFSET + JITTER * rng.normal(size=(800, 3))
    pull = np.einsum("bij,bj->bi", information, amount)
    pull += np.einsum("bri,br->bi", root, rng.normal(size=(800, 12)))
    return Scores(pull, information)


def test_offset_and_jitter_are_found(made):
    offset, jitter = learn_jitter(made)
    assert offset == pytest.approx(OFFSET, abs=0.04)
    assert np.sqrt(jitter) == pytest.approx(JITTER, abs=0.05)


def test_whitened_scores_vary_as_much_as_they_inform(made):
    white = whitened(made, OFFSET, JITTER**2)
    z = white.pull / np.sqrt(white.information)
    assert z.std(axis=0) == pytest.approx(np.ones(3), abs=0.1)
    assert np.abs(z.mean(axis=0)).max() < 0.15
    assert togetherness(white) == pytest.approx(np.ones(3), abs=0.5)


def test_whitening_solves_its_equations(made):
    white = whitened(made, OFFSET, JITTER**2)
    left = np.eye(3) + made.information * JITTER**2
    right = np.concatenate([(made.pull - made.information @ OFFSET)[:, :, None], made.information], axis=2)
    solved = np.linalg.solve(left, right)
    assert white.pull == pytest.approx(solved[:, :, 0], rel=1e-9)
    assert white.information == pytest.approx(np.einsum("bii->bi", solved[:, :, 1:]), rel=1e-9)


def test_blocks_that_go_together_are_noticed(made):
    white = whitened(made, OFFSET, JITTER**2)
    slow = np.repeat(white.pull[::20], 20, axis=0)
    assert np.all(togetherness(white._replace(pull=slow)) > 4.0)
    assert np.all(togetherness(type(white)(white.pull[:20], white.information[:20])) == 2.0)


def test_offsets_that_stray_from_stretch_to_stretch_are_seen():
    """The limit lies above the variance that was made in most cases, and not far above; what does not stray has next to none."""
    rng, cases, stretches = np.random.default_rng(8), 300, 15
    true, known = np.where(np.arange(cases) < cases // 2, 0.09, 0.0), 2.0
    offset = np.repeat(rng.normal(size=(stretches, cases)) * np.sqrt(true), 60, axis=0)
    pull = known * offset + rng.normal(size=offset.shape) * np.sqrt(known)
    found = slow_variance(Whitened(pull, np.full_like(pull, known)), np.ones(cases))
    strays, stays = found[true > 0.0], found[true == 0.0]
    assert 0.7 < np.mean(strays > 0.09) < 0.9
    assert np.median(strays) < 2.0 * 0.09
    assert np.median(stays) < 1.0 / (60.0 * known)


def test_what_strays_is_not_asked_of_few_stretches_and_has_a_limit():
    rng = np.random.default_rng(9)
    pull = rng.normal(size=(40, 1))
    assert slow_variance(Whitened(pull, np.full((40, 1), 1.0)), np.ones(1))[0] == 0.0
    wild = Whitened(np.repeat(rng.normal(size=(10, 1)), 60, axis=0), np.full((600, 1), 1e-9))
    assert slow_variance(wild, np.ones(1))[0] == 100.0
