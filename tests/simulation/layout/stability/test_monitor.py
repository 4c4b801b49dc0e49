"""Margins of single states: those of the run that they are from, one by one and many at once, and fast enough for a cockpit."""

import time

import numpy as np
import pytest

from polydraulic import InputError, StabilityMonitor, load_machine, simulate
from polydraulic.machine.stability.statics import holding_pressures
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.layout.columns import columns_of

MACHINE = load_machine("wheel_loader")


@pytest.fixture(scope="module")
def monitor():
    return StabilityMonitor(MACHINE)


def at_rest(payload=0.0):
    """A state at the initial positions, with the pressures that hold a payload."""
    columns = columns_of(MACHINE)
    angles = np.array([f.initial.angle for f in MACHINE.functions])
    state = np.zeros(columns.n_state)
    for f, angle, (p_a, p_b) in zip(
        MACHINE.functions, angles, holding_pressures(MACHINE, angles[None], payload)[0], strict=True
    ):
        for quantity, value in (("angle", angle), ("p_a", p_a), ("p_b", p_b)):
            state[columns.place[f"{f.name}.{quantity}"]] = value
    return state


def test_margins_of_states_are_the_columns_of_their_run(monitor):
    run = simulate(MACHINE, "exact", Scenario("lift", 1.0, {"lift": Constant(0.6)}), stability=True)
    states = np.column_stack([run[column.name] for column in columns_of(MACHINE).columns[:10]])
    seen, one = monitor(states), monitor(states[120])
    for k, edge in enumerate(monitor.edges):
        for measure in ("distance", "dynamic_distance", "force_angle", "energy"):
            np.testing.assert_array_equal(getattr(seen, measure)[:, k], run[f"stability.{edge}.{measure}"])
            assert getattr(one, measure)[k] == getattr(seen, measure)[120, k]
    np.testing.assert_array_equal(monitor(run).energy, seen.energy)  # columns by their names
    np.testing.assert_array_equal(seen.edge, run["stability.edge"])
    np.testing.assert_array_equal(seen.time_to_tip, run["stability.time_to_tip"])


def test_payload_and_force_count(monitor):
    """A weight that hangs and a force that pulls as much are the same at rest, and move the centre of gravity only as a weight."""
    bare, loaded = monitor(at_rest()), monitor(at_rest(1000.0), payload=1000.0)
    pulled = monitor(at_rest(1000.0), force=(0.0, 0.0, -9810.0))
    assert loaded.distance[0] < bare.distance[0] - 0.1
    assert pulled.distance[0] == bare.distance[0]
    keeps = [seen.dynamic_distance[0] * mass for seen, mass in ((loaded, 17500.0), (pulled, 16500.0))]
    assert keeps[0] == pytest.approx(keeps[1], rel=1e-6)
    assert monitor(at_rest()).distance[0] == bare.distance[0]


def test_a_warning_is_given_where_it_tips(monitor):
    assert not monitor(at_rest()).warning
    tipping = monitor(at_rest(7000.0), payload=7000.0)
    assert tipping.warning
    assert tipping.time_to_tip == 0.0
    assert monitor.edges[int(tipping.edge)] == "forward"


@pytest.mark.parametrize(
    ("rows", "options", "words"),
    [
        (np.zeros(3), {}, "must hold the 10 numbers of a state"),
        (np.full(10, np.nan), {}, "not finite"),
        (np.zeros(10), {"payload": -1.0}, "payload is negative"),
        (np.zeros(10), {"force": (0.0, np.inf, 0.0)}, "not finite"),
    ],
)
def test_what_cannot_be_used_is_refused(monitor, rows, options, words):
    with pytest.raises(InputError, match=words):
        monitor(rows, **options)


def test_a_state_takes_less_than_a_frame(monitor):
    state = at_rest()
    monitor(state)
    begun = time.process_time()
    for _ in range(20):
        monitor(state)
    assert (time.process_time() - begun) / 20 < 1.0 / 60.0
