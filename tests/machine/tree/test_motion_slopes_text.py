"""Slopes of what a motion needs against differences of the mechanics, in plain Python: one text for all."""

import re

import numpy as np
import pytest

from helpers.trees import GRAVITY, TREES, head, loaded, random_states, random_tree
from polydraulic.machine.tree.motion_slopes_text import motion_slopes_text
from polydraulic.machine.tree.motion_text import motion_text, moving

PLAIN = """
def kernel(function):
    return function


driver, sincos = kernel, getattr(sincos, "py_func", sincos)
"""
NEEDED = """

def needed(q, v, a, point, force, constants):
    turn = turns(q)
    m = motion(turn, v, constants)
    inertia, push = times(m.mass, a), push_LAST(turn, *point, *force, constants)
    return [x + b + g - p for x, b, g, p in zip(inertia, m.bias, m.gravity, push)]
"""


def _found(folder, links, seed):
    """Both matrices, and the same from differences, at a random state."""
    last = links[-1].name
    parts = [head(links), PLAIN, motion_text(links, points=[last]), motion_slopes_text(links, last)]
    module = loaded(folder, "\n\n".join([*parts, NEEDED.replace("LAST", last)]))
    rng, n = np.random.default_rng(seed), len(moving(links))
    q, v = (states[0] for states in random_states(links, 1, seed)[:2])
    a, point, force = rng.uniform(-5.0, 5.0, n), rng.uniform(-1.0, 1.0, 3), rng.uniform(-1e4, 1e4, 3)
    constants = module.prepare_motion(links, GRAVITY)

    def needed(q, v):
        return np.array(module.needed(module.Joints(*q), module.Joints(*v), module.Joints(*a), point, force, constants))

    by_position, by_rate = np.zeros((n, n)), np.zeros((n, n))
    module.motion_slopes(
        module.turns(module.Joints(*q)), module.Joints(*v), module.Joints(*a), *point, *force,
        module.prepare_slopes(links, GRAVITY), by_position, by_rate,
    )  # fmt: skip
    steps = 1e-6 * np.eye(n)
    true_position = np.array([needed(q + step, v) - needed(q - step, v) for step in steps]).T / 2e-6
    true_rate = np.array([needed(q, v + step) - needed(q, v - step) for step in steps]).T / 2e-6
    return (by_position, true_position), (by_rate, true_rate)


@pytest.mark.parametrize("name", TREES)
def test_slopes_are_differences(tmp_path, name):
    for found, true in _found(tmp_path, TREES[name], 1):
        assert np.abs(true).max() > 10.0
        assert found == pytest.approx(true, rel=1e-6, abs=1e-8 * np.abs(true).max() + 1e-4)


@pytest.mark.parametrize("seed", range(12))
def test_slopes_of_random_trees_are_differences(tmp_path, seed):
    for found, true in _found(tmp_path, random_tree(seed), seed):
        assert found == pytest.approx(true, rel=1e-6, abs=1e-8 * np.abs(true).max() + 1e-4)


def test_no_number_is_in_the_text():
    links = TREES["telescopic boom"]
    heavier = [link._replace(mass=None if link.mass is None else 3.0 * link.mass) for link in links]
    assert motion_slopes_text(links) == motion_slopes_text(heavier)
    after = motion_slopes_text(links).partition("def motion_slopes(")[2].partition("):")[2]
    assert not re.search(r"\bf[xyz]\b", after)  # without a force
