"""Play between what drives and what follows, and the forces of flows on a spool."""

from math import cos, radians, sqrt

import numpy as np
import pytest

from polydraulic.machine.hose import LineStep, Pressures
from polydraulic.machine.pilot import PilotStep
from polydraulic.machine.play import actuator_rate, felt_torque, followed, jet, prepare_shift, pushed_back, taken_up
from polydraulic.parameters.layout.parts import FlowForce

DT = 5e-3
LINE = LineStep(DT / 3e-12, DT / 2e-12, 0.0, 0.0, 3e7, 0.0, 3e5)


def test_a_follower_lags_by_half_a_width_either_way_and_rests_in_between():
    driver = np.concatenate([np.linspace(0, 5, 11), np.linspace(5, -5, 21)])
    place, seen = 0.0, []
    for x in driver:
        place = followed(place, float(x), 1.0)
        seen.append(place)
    assert seen[:11] == [max(0.0, x - 1.0) for x in driver[:11]]
    assert seen[11:] == [min(4.0, x + 1.0) for x in driver[11:]]
    assert followed(0.3, 0.7, 0.0) == 0.7


def test_an_actuator_touches_at_the_ends_of_its_play_and_never_pulls():
    assert actuator_rate(0.01, 0.4, 0.01) == actuator_rate(-0.01, 0.4, 0.01) == 0.4
    assert actuator_rate(0.009, 0.4, 0.01) == 0.0
    assert [
        felt_torque(t, g, 0.01) for t, g in ((5.0, 0.01), (-5.0, 0.01), (5.0, 0.0), (5.0, -0.01), (-5.0, -0.01))
    ] == [
        5.0,
        0.0,
        0.0,
        0.0,
        -5.0,
    ]
    assert [felt_torque(t, 0.0, 0.0) for t in (5.0, -5.0)] == [5.0, -5.0]  # without play it does both


def test_within_its_play_an_actuator_moves_to_where_its_oil_balances():
    a, b, p = 3e-4, 2e-4, Pressures(5e6, 6e6, 1e-4)
    after = taken_up(p, 0.0, a, b, LINE, 1.0, DT)
    assert a * after.p_a == pytest.approx(b * after.p_b, rel=1e-12)
    assert after.q_out == p.q_out
    # what it sweeps is what the lines lose and gain
    assert (p.p_a - after.p_a) * 3e-12 == pytest.approx(a * after.gap)
    assert (after.p_b - p.p_b) * 2e-12 == pytest.approx(b * after.gap)


def test_at_the_end_of_its_play_the_rest_of_the_torque_remains():
    a, b, p = 3e-4, 2e-4, Pressures(5e6, 6e6, 1e-4)
    free = taken_up(p, 0.0, a, b, LINE, 1.0, DT)
    after = taken_up(p, 0.0, a, b, LINE, 0.5 * free.gap, DT)
    assert after.gap == 0.5 * free.gap
    assert a * after.p_a - b * after.p_b == pytest.approx(0.5 * (a * p.p_a - b * p.p_b))
    rigid = taken_up(p, 0.0, a, b, LINE, 0.0, DT)
    assert rigid == (p.p_a, p.p_b, p.q_out, 0.0)


def test_pressures_stay_between_floor_and_relief():
    after = taken_up(Pressures(2e7, 1e5, 0.0), 0.9, 3e-4, 2e-4, LINE, 0.1, DT)  # the joint drives it back
    assert after.gap == 0.1
    assert after.p_a == LINE.relief
    assert after.p_b == LINE.floor


def test_a_jet_pushes_by_conductance_times_drop_and_up_to_the_centre():
    k, drop = 3e-8, 4e6
    assert jet(k, k * sqrt(drop)) == pytest.approx(k * drop)
    assert jet(0.0, 0.0) == 0.0
    assert prepare_shift(FlowForce(2e4, 870.0, radians(69))) == pytest.approx(sqrt(2 * 870) * cos(radians(69)) / 2e4)
    pilot = PilotStep(8e-3, 8e-3, 0.95)
    assert pushed_back(4e-3, 1e-3, pilot) == pytest.approx(3.95e-3)
    assert pushed_back(-4e-3, 1e-3, pilot) == pytest.approx(-3.95e-3)
    assert pushed_back(1e-5, 1e-3, pilot) == pushed_back(-1e-5, 1e-3, pilot) == 0.0
