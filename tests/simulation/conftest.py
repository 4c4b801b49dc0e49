import pytest

from polydraulic import load_scenario, simulate


@pytest.fixture(scope="session")
def whole(machine):
    """The whole machine in motion, by two flow models."""
    scenario = load_scenario("task")
    return {name: simulate(machine, name, scenario, t_end=0.6) for name in ("exact", "iterative")}


@pytest.fixture(scope="session")
def boom_runs(machine):
    scenario = load_scenario("single_08")
    return {name: simulate(machine, name, scenario, t_end=0.2) for name in ("exact", "polynomial")}
