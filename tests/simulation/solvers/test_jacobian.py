"""The Jacobian against differences of the equations, and its solution by blocks against a dense one."""

import numpy as np
import pytest

from polydraulic.flow import exact_flow
from polydraulic.machine.linkage import Held
from polydraulic.machine.plant import prepare
from polydraulic.machine.state import Links
from polydraulic.simulation.solvers.jacobian import Free, Slow, factorise, linearise, solve
from polydraulic.simulation.solvers.rosenbrock_step import SIZES, evaluate_slow, slow_state

VELOCITY = Links(0.01, -0.02, 0.015)
UNITS = np.repeat([1e6, 1e6, 0.1, 0.1], 3)


def dense(machine, model, y, spool, held, free):
    """Jacobian (12, 12) and drift (12,) by central differences."""
    plant, memory = prepare(machine, 1.0), np.zeros(1)

    def rates(y, spool):
        f = np.empty(12)
        evaluate_slow(model, memory, plant, held, free, Links(*spool), y, f)
        return f

    jacobian = np.empty((12, 12))
    for m in range(12):
        step = 1e-5 * UNITS[m] * np.eye(12)[m]
        jacobian[:, m] = (rates(y + step, spool) - rates(y - step, spool)) / (2e-5 * UNITS[m])
    x, v = np.array(spool), np.array(VELOCITY)
    drift = (rates(y, x + 1e-7 * v) - rates(y, x - 1e-7 * v)) / 2e-7
    return jacobian, drift


def by_port(v, spool):
    """Line pressures in the order of fed ports and outlets."""
    v = v.copy()
    for link in range(3):
        if spool[link] < 0.0:
            v[[link, 3 + link]] = v[[3 + link, link]]
    return Slow(*(Links(*v[k : k + 3]) for k in (0, 3, 6, 9)))


def by_line(x, spool):
    return np.concatenate([*by_port(np.concatenate(x), spool)])


def random_state(rng):
    y = np.concatenate(
        [rng.uniform(5e5, 2.5e7, 6), [rng.uniform(-2, 2), rng.uniform(-0.5, 0.9), rng.uniform(-2, -0.6)]]
    )
    return np.concatenate([y, rng.uniform(-0.5, 0.5, 3)])


CASES = [
    pytest.param(seed, limited, held, id=f"{seed}{'-limited' if limited else ''}{'-held' if any(held) else ''}")
    for seed in range(6)
    for limited, held in ((False, (False, False, False)), (True, (False, False, False)), (False, (False, True, False)))
]


@pytest.mark.parametrize(("seed", "limited", "held"), CASES)
def test_the_system_is_that_of_the_true_jacobian(machine, seed, limited, held):
    rng = np.random.default_rng(seed)
    machine = machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=limited))
    model, plant, memory = exact_flow(machine), prepare(machine, 1.0), np.zeros(1)
    for _ in range(30):
        y, held = random_state(rng), Held(*held)
        y[9:] *= 1.0 - np.array(held)
        spool = rng.uniform(0.0045, 0.0142, 3) * rng.choice([-1.0, 1.0], 3)
        free = np.where(rng.uniform(size=6) < 0.1, 0.0, 1.0)
        knots = np.array(machine.spool.knots)
        if np.abs(np.abs(spool)[:, None] - knots).min() < 1e-5:
            continue  # at a knot there are two slopes
        jacobian, drift = dense(machine, model, y, spool, held, free)
        r = evaluate_slow(model, memory, plant, held, free, Links(*spool), y, np.empty(12))
        a = linearise(
            model,
            plant,
            slow_state(Links(*spool), y),
            r,
            Links(*spool),
            VELOCITY,
            Free(Links(*free[:3]), Links(*free[3:])),
        )
        assert by_line(a.drift, spool) == pytest.approx(drift, rel=1e-4, abs=3e-3 * 1e6)
        e, right = 1.0 / 0.004, rng.normal(size=12) * UNITS * (1.0 - np.concatenate([np.zeros(6), held, held]))
        found = by_line(solve(by_port(right, spool), factorise(e, a, r, held), a, r, held), spool)
        expected = np.linalg.solve(e * np.eye(12) - jacobian, right)
        assert found / UNITS == pytest.approx(expected / UNITS, rel=2e-4, abs=2e-5 * np.abs(expected / UNITS).max())


def test_sizes_are_one_for_each_quantity():
    assert SIZES.shape == UNITS.shape
