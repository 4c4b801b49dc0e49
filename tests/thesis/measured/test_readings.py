"""What sensors read of an operator's work, as rows for networks and as a log for equations."""

import numpy as np

from polydraulic import random_operator, simulate
from polydraulic.thesis.excavator import LINKS, pump_of, spool_of
from polydraulic.thesis.measured.conditions import COMMANDS, NO_PRESSURES, USUAL
from polydraulic.thesis.measured.readings import STROKE, log_of_readings, rows_for_networks, sensor_readings


def measured(machine, conditions):
    return rows_for_networks(machine, sensor_readings(machine, conditions))


def test_ports_follow_the_spool_and_shut_valves_pass_nothing(machine):
    log = measured(machine, USUAL._replace(minutes=0.2, noise=0.0))
    run = simulate(machine, "exact", random_operator(USUAL.operator, 12.0, limit=STROKE), raster=0.02)
    for link in LINKS:
        open_ = np.abs(run[f"{link}.spool"]) > spool_of(machine).deadband
        assert np.allclose(log[f"{link}.p_in"][open_], np.maximum(run[f"{link}.p_in"][open_], 0.0))
        assert np.all(log[f"{link}.q_in"][~open_] == 0.0)
        assert np.all(log[f"{link}.k_out"][~open_] == 0.0)
        assert log[f"{link}.q_in"][open_].max() > 0.0
    assert np.all(log["series.q_passed"] <= pump_of(machine, "series").flow)


def test_silent_sensors_and_joint_angles(machine):
    whole = measured(machine, USUAL._replace(minutes=0.5))
    assert len(measured(machine, USUAL._replace(minutes=0.5, dropout=0.05))) < 0.9 * len(whole)
    rebuilt = measured(machine, USUAL._replace(minutes=0.5, noise=0.0, flow_sensors=False))
    true = measured(machine, USUAL._replace(minutes=0.5, noise=0.0))
    flowing = true["boom.q_in"] > 0.3 * pump_of(machine, "boom").flow
    error = rebuilt["boom.q_in"] - true["boom.q_in"]  # what the oil's compression takes, and all of it at a stop
    assert np.median(np.abs(error[flowing])) < 0.5 * np.median(true["boom.q_in"][flowing])


def test_flows_out_of_actuators_follow_from_those_in(machine):
    exact = USUAL._replace(minutes=0.5, noise=0.0)
    true, rebuilt = measured(machine, exact), measured(machine, exact._replace(outlet_sensors=False))
    assert all(np.array_equal(true[f"{link}.q_in"], rebuilt[f"{link}.q_in"]) for link in LINKS)
    for link in ("boom", "stick"):
        flowing = true[f"{link}.q_in"] > 0.5 * pump_of(machine, "boom").flow
        read, found = (log[f"{link}.q_out"][flowing] for log in (true, rebuilt))
        assert 0.8 < np.corrcoef(read, found)[0, 1] < 1.0  # compression is what differs
        assert abs(np.median(found - read)) < 0.05 * np.median(read)
    assert np.array_equal(rebuilt["swing.q_out"], rebuilt["swing.q_in"])


def test_a_log_has_the_sensors_of_its_conditions_and_the_levers():
    from polydraulic import load_machine

    machine = load_machine("cat215b")
    for conditions, quantities in (
        (USUAL, ["p_a", "p_b", "q_in", "q_out", "spool", "voltage"]),
        (NO_PRESSURES, ["angle", "spool", "voltage"]),
        (COMMANDS, ["angle", "voltage"]),
    ):
        log = log_of_readings(sensor_readings(machine, conditions._replace(minutes=0.2, dropout=0.05)))
        assert sorted(n for n in log.names if n.startswith("boom.")) == [f"boom.{what}" for what in quantities]
        assert len(log) == 601
        assert 0 < np.count_nonzero(log["missing"]) < 601
        assert all(log.known([name]).all() for name in ("time", "boom.voltage"))
        assert len(log.whole(log.names)) == np.count_nonzero(log["missing"] == 0.0)
