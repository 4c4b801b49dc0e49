"""The methods of a small crane: its Jacobian, and the Rosenbrock method against the reference, whatever happens on the way."""

import numpy as np
import pytest

from helpers.layout_states import check_jacobian
from helpers.mechanical_energy import joint_columns
from polydraulic import reference, simulate
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant, Piecewise

# With compiled methods `tests/machines` is quick, for the layout that all quick tests of them share.
pytestmark = pytest.mark.slow_to_compile
VOLTS = {"slew": Constant(0.4), "lift": Constant(0.7), "extend": Constant(0.5)}
PUSH = {"y": Piecewise(np.array([0.3, 0.6, 1.0]), np.array([0.0, 800.0, -300.0]))}
LOADED = Scenario("loaded", 1.5, VOLTS, loads=Loads(PUSH, Payload((0.4, 0.9), (80.0, 0.0))))


# All with a force, so that one text is compiled; `tests/machines` has machines without.
@pytest.mark.parametrize("locked", [(), ("lift",)])
def test_steps_solve_with_the_true_jacobian(crane, locked):
    leaky = crane.with_values({f"functions.{name}.line.external_leakage": 3e-12 for name in crane.names})
    assert check_jacobian(leaky, np.random.default_rng(3), 20, force=True, locked=locked) > 10


def errors(machine, found, tight):
    """Largest errors of all positions, rad and m."""
    return np.abs(joint_columns(machine, found)[0] - joint_columns(machine, tight)[0]).max(axis=0)


@pytest.mark.slow
def test_the_tolerance_is_kept_with_loads_that_come_and_go(crane):
    """A force with corners, a payload for half a second; the steps of fixed length come to the same by their order."""
    tight = reference(crane, "exact", LOADED)
    assert np.ptp(joint_columns(crane, tight)[0], axis=0).min() > 0.1
    for rtol in (1e-3, 1e-5):
        found = simulate(crane, "exact", LOADED, method="rosenbrock", rtol=rtol)
        assert found.names == tight.names
        assert errors(crane, found, tight).max() < 10.0 * rtol
        assert [event[1:] for event in found.info["events"]] == [event[1:] for event in tight.info["events"]]
    steps = [simulate(crane, "exact", LOADED, dt=dt, raster=5e-3) for dt in (5e-3, 2.5e-3)]
    coarse, fine = (errors(crane, run, tight) for run in steps)
    assert (coarse < 1e-2).all()
    assert coarse.max() == pytest.approx(2.0 * fine.max(), rel=0.15)
    smooth = simulate(crane, "exact", LOADED, dt=1e-3, raster=5e-3, method="rk4")
    assert errors(crane, smooth, tight).max() < 1e-4


def test_the_account_of_energy_is_that_of_the_run(crane):
    tight = simulate(crane, "exact", LOADED, method="rosenbrock", energy=True)
    loose = simulate(crane, "exact", LOADED, dt=1e-3, raster=5e-3, energy=True)
    assert tight.names == loose.names
    for name in ("energy.kinetic", "energy.potential", "tip.push_power", "main.pump_power"):
        assert np.abs(tight[name] - loose[name]).max() < 0.02 * np.ptp(loose[name])


def test_bounds_hold_under_a_wild_operator(crane):
    """No pressure leaves its bounds and no joint its stops; stops that are met hold, and joints leave them again."""
    rng, times = np.random.default_rng(7), np.arange(0.0, 4.5, 0.5)
    signals = {name: Piecewise(times, rng.uniform(-1.1, 1.1, times.size)) for name in ("slew", "lift")}
    signals["extend"] = Piecewise(np.array([0.0, 0.1, 3.0, 3.1]), np.array([0.0, 0.9, 0.9, -0.9]))
    wild = Scenario("wild", 4.5, signals, loads=Loads(PUSH))
    found, closer = (simulate(crane, "exact", wild, method="rosenbrock", rtol=rtol) for rtol in (1e-4, 1e-5))
    positions = joint_columns(crane, found)[0]
    for place, f in enumerate(crane.functions):
        for port in ("p_a", "p_b"):
            assert found[f"{f.name}.{port}"].min() >= crane.tank.floor
            assert found[f"{f.name}.{port}"].max() <= f.line.relief
        assert positions[:, place].min() >= f.stops.low - 1e-9
        assert positions[:, place].max() <= f.stops.high + 1e-9
    assert {"high stop met", "high stop left"} <= {event[2] for event in found.info["events"]}
    assert errors(crane, found, closer).max() < 1e-2
    assert found.info["rows_not_converged"] == 0


def test_locked_functions_stand_still(crane):
    levers = {"slew": Constant(0.5), "lift": Constant(0.3)}
    held = Scenario("held", 1.0, levers, locked=("extend",), loads=Loads(PUSH))
    found, tight = (simulate(crane, "exact", held, method=method) for method in ("rosenbrock", "reference"))
    assert np.ptp(found["extend.position"]) == 0.0
    assert errors_of(found, tight) < 1e-4


def errors_of(found, tight):
    return max(np.abs(found[name] - tight[name]).max() for name in ("slew.angle", "lift.angle"))


def test_a_run_of_one_row_is_its_start(crane):
    for method in ("rosenbrock", "reference"):
        found = simulate(crane, "exact", LOADED, method=method, t_end=5e-3, every=2)
        start = simulate(crane, "exact", LOADED, t_end=5e-3)
        assert len(found) == 1
        for name in found.names:
            assert found[name][0] == pytest.approx(start[name][0], rel=1e-12, abs=1e-12), name
