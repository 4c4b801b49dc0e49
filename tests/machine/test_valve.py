import numpy as np
import pytest

from polydraulic.flow.layout.model import exact_flow
from polydraulic.machine.valve import orifice_flow, spool_edges
from polydraulic.simulation.layout.module import layout_module
from polydraulic.simulation.layout.prepare import valves_of


@pytest.mark.parametrize("name", ["swing", "boom", "stick"])
def test_orifices_meet_their_tables_are_linear_between_knots_and_exactly_shut(machine, name):
    module, valve = layout_module(machine), machine.function(name).valve
    prepared = getattr(valves_of(machine, module, exact_flow(machine)), f"valve_{name}")
    opens, shut = spool_edges(valve)
    for sign, outlet in ((1.0, valve.outlet_positive), (-1.0, valve.outlet_negative)):
        travels = [*valve.knots[1:], *np.random.default_rng(0).uniform(0.0, 1.3 * valve.knots[-1], 30)]
        for travel in travels:
            k = module.orifices_6(sign * travel, prepared)
            expected = [np.interp(travel, valve.knots, curve) for curve in (valve.inlet, valve.bypass, outlet)]
            assert tuple(k) == pytest.approx(expected, rel=1e-12, abs=1e-22)
            assert travel > opens or (k.inlet, k.outlet) == (0.0, 0.0)
            assert travel < shut or k.bypass == 0.0


def test_edges_of_a_spool_are_those_of_its_curves(machine):
    valve = machine.function("boom").valve
    assert spool_edges(valve) == (valve.knots[1], valve.knots[4])
    always = valve._replace(inlet=(1e-6, *valve.inlet[1:]), bypass=(*valve.bypass[:-1], 1e-9))
    assert spool_edges(always) == (0.0, float("inf"))


def test_check_valve():
    assert orifice_flow(2.0, -4.0) == 0.0
    assert orifice_flow(2.0, 4.0) == 4.0
