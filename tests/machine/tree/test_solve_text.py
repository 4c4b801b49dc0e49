"""Solutions with held joints, whatever is zero in the mass matrix, against NumPy."""

from itertools import product
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from polydraulic.machine.tree.solve_text import mass_text, solve_text, times_text


def functions(names, places):
    """The kernels of joints of these names, in plain Python."""
    space = {
        "NamedTuple": NamedTuple,
        "kernel": lambda function: function,
        "Joints": NamedTuple("Joints", [(name, float) for name in names]),
    }
    exec("\n\n\n".join([mass_text(names, places), times_text(names, places), solve_text(names, places)]), space)
    return SimpleNamespace(**space)


def random_mass(rng, n, places):
    """Positive definite, with zeros where they are by structure."""
    mass = np.zeros((n, n))
    for i, j in places:
        mass[i, j] = mass[j, i] = rng.normal()
    return mass + np.eye(n) * (np.abs(mass).sum(1) + 0.1)


CHAIN = {n: [(i, j) for i in range(n) for j in range(i, n)] for n in range(1, 8)}
TWO_ARMS = [(i, j) for i, j in CHAIN[7] if i in (0, j) or (i < 4) == (j < 4)]
APART = [(0, 0), (1, 1), (2, 2), (2, 3), (3, 3)]


@pytest.mark.parametrize(
    "places", [*CHAIN.values(), TWO_ARMS, APART], ids=[*(f"chain of {n}" for n in CHAIN), "two arms", "apart"]
)
def test_solutions_are_those_of_numpy(places):
    n, rng = 1 + max(j for _, j in places), np.random.default_rng(0)
    names = [f"joint{k}" for k in range(n)]
    made = functions(names, places)
    mass, right, v = random_mass(rng, n, places), rng.normal(size=n), rng.normal(size=n)
    given = made.Mass(*(mass[i, j] for i, j in places))
    for held in product((False, True), repeat=n):
        free = ~np.array(held)
        found = np.array(
            made.solve_motion(given, SimpleNamespace(**dict(zip(names, held, strict=True))), made.Joints(*right))
        )
        assert np.all(found[~free] == 0.0)
        assert found[free] == pytest.approx(
            np.linalg.solve(mass[np.ix_(free, free)], right[free]), rel=1e-10, abs=1e-13
        )
    assert made.times(given, made.Joints(*v)) == pytest.approx(mass @ v, rel=1e-13, abs=1e-14)
    assert made.kinetic(given, made.Joints(*v)) == pytest.approx(0.5 * v @ mass @ v, rel=1e-13)


def test_a_block_of_up_to_three_joints_takes_one_division():
    for n, divisions in ((1, 1), (3, 1), (4, 2), (6, 2), (7, 3)):
        assert solve_text([f"joint{k}" for k in range(n)], CHAIN[n]).count("1.0 / ") == divisions


def test_arms_that_share_nothing_are_apart():
    text = solve_text([f"joint{k}" for k in range(7)], TWO_ARMS)
    assert text.count("*") < 0.7 * solve_text([f"joint{k}" for k in range(7)], CHAIN[7]).count("*")
    assert "if held" in text
    assert not any(line.strip().startswith("if ") for line in text.splitlines())  # selects alone
