import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.machine.valve import orifice_flow, orifices, prepare_valve


@pytest.mark.parametrize("link", ["swing", "boom", "stick"])
def test_orifices_meet_their_tables(machine, link):
    valve = getattr(machine, link).valve
    prepared = prepare_valve(valve, machine.spool)
    for sign, outlet in ((1.0, valve.outlet_positive), (-1.0, valve.outlet_negative)):
        for i, knot in enumerate(machine.spool.knots):
            k = orifices(sign * knot, prepared)
            expected = (valve.inlet[i], valve.bypass[i], (valve.outlet_positive if knot == 0.0 else outlet)[i])
            assert tuple(k) == pytest.approx(expected, rel=1e-13, abs=1e-25)


@given(x=st.floats(-0.02, 0.02))
def test_orifices_are_linear_between_knots_and_exactly_shut(machine, x):
    prepared = prepare_valve(machine.boom.valve, machine.spool)
    k = orifices(x, prepared)
    knots, travel = machine.spool.knots, abs(x)
    assert k.inlet == pytest.approx(np.interp(travel, knots, machine.boom.valve.inlet), rel=1e-12, abs=1e-22)
    if travel <= machine.spool.deadband:
        assert k.inlet == 0.0
        assert k.outlet == 0.0
    if travel >= machine.spool.bypass_closed:
        assert k.bypass == 0.0


def test_check_valve():
    assert orifice_flow(2.0, -4.0) == 0.0
    assert orifice_flow(2.0, 4.0) == 4.0
