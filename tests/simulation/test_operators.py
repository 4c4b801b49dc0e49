"""Long runs under operators that nobody planned: every whole-machine flow model keeps its bounds and loses no oil."""

import numpy as np
import pytest

from polydraulic.flow import FLOW_KINDS
from polydraulic.parameters import LINKS, random_operator
from polydraulic.simulation import simulate

WHOLE = [name for name, kind in FLOW_KINDS.items() if set(kind.links) == set(LINKS)]


def check(machine, run, balances):
    assert all(np.all(np.isfinite(values)) for values in run.columns.values())
    for link in LINKS:
        part = getattr(machine, link)
        assert run[f"{link}.angle"].min() >= part.stops.low
        assert run[f"{link}.angle"].max() <= part.stops.high
        assert np.abs(run[f"{link}.spool"]).max() <= machine.spool.knots[-1]
        for name in ("p_a", "p_b"):
            assert run[f"{link}.{name}"].min() >= machine.tank.floor
            assert run[f"{link}.{name}"].max() <= part.line.relief
    if balances:
        rest = run["boom.q_pump"] - run["boom.q_in"] - run["boom.q_bypass"] - run["boom.q_relief"]
        assert np.abs(rest).max() <= 1e-9 * run["boom.q_pump"].max()


@pytest.mark.parametrize("name", WHOLE)
def test_a_short_run(machine, name):
    run = simulate(machine, name, random_operator(3, 2.0))
    check(machine, run, FLOW_KINDS[name].balances)
    assert all(np.ptp(run[f"{link}.angle"]) > 0.0 for link in LINKS)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", WHOLE)
def test_ten_minutes(machine, name, seed):
    run = simulate(machine, name, random_operator(seed, 600.0), every=2)
    check(machine, run, FLOW_KINDS[name].balances)
    stops = machine.boom.stops
    assert np.ptp(run["boom.angle"]) > 0.5 * (stops.high - stops.low)


@pytest.mark.slow
def test_networks_of_the_boom_for_ten_minutes(machine):
    scenario = random_operator(4, 600.0, links=("boom",))
    run = simulate(machine, "polynomial", scenario, every=2)
    assert np.all(np.isfinite(run["boom.rate"]))
    assert machine.boom.stops.low <= run["boom.angle"].min() <= run["boom.angle"].max() <= machine.boom.stops.high
    assert run["boom.p_a"].max() <= machine.boom.line.relief
