"""An error that came at once, and one that grows: against both fitted plainly, one beginning after the other."""

import numpy as np
import pytest

from polydraulic._kernel import in_plain_python
from polydraulic.watch.kernels.courses import BEGINNINGS, ROOM_OF_COURSE, course_of
from polydraulic.watch.kernels.evidence import KEPT

KNOWN = 20.0  # information of a block


def pulled(amounts, seed=1):
    """Pull and information of blocks in which an error of these amounts is seen."""
    noise = np.random.default_rng(seed).normal(0.0, np.sqrt(KNOWN), len(amounts))
    return KNOWN * amounts + noise, np.full(len(amounts), KNOWN)


def room(pull, information):
    """Blocks as the kernel reads them, not from the first place on."""
    return np.concatenate([np.zeros(3), pull, information, np.zeros(ROOM_OF_COURSE - 2 * len(pull))])


def course(pull, information, together):
    return course_of(room(pull, information), 3, len(pull), together)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_came_at_once_is_told_from_what_grows(sign):
    at = np.arange(200.0)
    step = course(*pulled(sign * (at >= 130.0)), 1.0)
    assert step.grows < 0.01
    ramp = course(*pulled(sign * 0.8 * np.clip((at - 40.0) / 160.0, 0.0, 1.0)), 1.0)
    assert ramp.grows > 0.99
    assert ramp.size == pytest.approx(sign * 0.8, abs=3.0 * ramp.error)
    assert 0.0 < ramp.error < 0.1


def test_few_blocks_that_say_little_leave_it_open():
    pull, information = pulled(np.full(6, 0.7))
    assert 0.05 < course(0.05 * pull, 0.05 * information, 1.0).grows < 0.95


def test_no_block_that_says_anything_leaves_it_open():
    assert course(np.zeros(10), np.zeros(10), 1.0).grows == pytest.approx(0.5)


@pytest.mark.parametrize("n", [1, 2, 7, 59, 60, 61, 250, KEPT])
def test_sums_over_blocks_are_those_of_every_beginning_by_itself(n):
    rng = np.random.default_rng(n)
    information = rng.uniform(0.0, 40.0, n) * (rng.uniform(size=n) > 0.3)
    grown = np.clip((np.arange(n) - n // 3) / n, 0.0, 1.0)
    pull = information * grown + np.sqrt(information) * rng.normal(size=n)
    found, expected = course(pull, information, 1.3), plain_course(pull, information, 1.3)
    assert found == pytest.approx(expected, rel=1e-9)


def test_bits_are_those_of_plain_python():
    pull, information = pulled(np.linspace(0.0, 0.3, 200))
    seen = [room(pull, information) for _ in range(2)]
    assert course_of(seen[0], 3, 200, 1.0) == in_plain_python(course_of)(seen[1], 3, 200, 1.0)
    assert np.array_equal(*seen)


def plain_course(pull, information, together):
    """Both shapes from every beginning, by least squares."""
    n, known, fits = len(pull), information > 0.0, []
    for first in np.unique(np.linspace(0.0, n - 1.0, BEGINNINGS).astype(int)):
        at = np.arange(n) - first
        for shape in (np.where(at >= 0, 1.0, 0.0), np.where(at >= 0, (at + 1.0) / (n - first), 0.0)):
            weight = max(float(np.sum(shape**2 * information)), 1e-300)
            size = float(np.sum(shape * pull)) / weight
            left = pull[known] - size * shape[known] * information[known]
            fits.append((size, weight, float(np.sum(left**2 / information[known]))))
    scatter = max(min(left for *_, left in fits) / max(np.sum(known) - 1, 1), together)
    speaks = np.array([0.5 * (s**2 * w / scatter - np.log1p(w / scatter)) for s, w, _ in fits])
    likely = np.exp(speaks - speaks.max())
    size, weight, _ = fits[1 + 2 * int(np.argmax(speaks[1::2]))]
    return likely[1::2].sum() / likely.sum(), size, np.sqrt(scatter / weight)
