"""Conditions in words, and the machine that works under them."""

import numpy as np

from polydraulic.thesis.excavator import LINKS, with_pumps
from polydraulic.thesis.measured.conditions import COMMANDS, NO_PRESSURES, USUAL, conditions_in_words, machine_under
from polydraulic.thesis.measured.readings import rows_for_networks, sensor_readings


def test_conditions_in_words():
    assert conditions_in_words(USUAL._replace(dropout=0.05, flow_sensors=False, limited=True)) == (
        "30 min, sensor noise 0.3 %, joystick travel 100 %, sensors silent 5 % of the time, no flow sensors, pumps with a torque limit"
    )
    assert conditions_in_words(USUAL._replace(outlet_sensors=False, friction=0.0)).endswith(
        "no outlet-flow sensors, no friction"
    )
    assert conditions_in_words(USUAL._replace(friction=5.0)).endswith("5 times the friction")
    assert conditions_in_words(NO_PRESSURES).endswith(", no flow or pressure sensors")
    assert conditions_in_words(COMMANDS).endswith(", no flow or pressure or spool sensors")


def test_friction_is_that_of_all_joints_and_changes_the_pressures(machine):
    stiff = machine_under(machine, USUAL._replace(friction=5.0))
    for link in LINKS:
        now, then = stiff.function(link).friction, machine.function(link).friction
        assert (now.coulomb, now.static, now.viscous) == (5.0 * then.coulomb, 5.0 * then.static, 5.0 * then.viscous)
        assert (now.smoothing, now.stribeck) == (then.smoothing, then.stribeck)
    assert machine_under(machine, USUAL) == with_pumps(machine, torque_limit_enabled=False)
    exact = USUAL._replace(minutes=0.5, noise=0.0)
    pressures = [np.median(rows_for_networks(m, sensor_readings(m, exact))["swing.p_in"]) for m in (machine, stiff)]
    assert pressures[1] > 1.2 * pressures[0]
