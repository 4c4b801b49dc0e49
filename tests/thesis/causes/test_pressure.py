"""Explanations of section 4.2.1: which of them make pump-pressure networks fail."""

import numpy as np
import pytest

from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.table import Network
from polydraulic.thesis.cache import Cache, Lab
from polydraulic.thesis.causes import pressure
from polydraulic.thesis.excavator import spool_of
from polydraulic.thesis.single_link import boom_study


def test_flow_from_the_bypass_is_what_it_leaves(machine):
    p = 6e6  # a network without nodes answers with its lower bound
    constant = Network((), (0.0, 0.0), (1.0, 1.0), (0.0, 0.0), (1.0, 1e9), p, 2.0 * p)
    model = Model(
        (Variable("boom.travel", "m"), Variable("boom.p_in", "Pa")), Variable("boom.p_pump", "Pa"), (constant,)
    )
    table = pressure._from_bypass(machine, model).parts["lookup_boom"]
    valve = machine.function("boom").valve
    row = int(np.searchsorted(table.travel, 0.3 * 0.0254))
    k = np.interp(table.travel[row], valve.knots, valve.bypass)
    pump_flow = machine.circuit("boom").pump.flow
    left = pump_flow - k * np.sqrt(p - machine.tank.return_pressure)
    assert table.flows[row, :, 0] == pytest.approx(left)
    assert np.all(table.flows[table.travel <= spool_of(machine).deadband] == 0.0)
    assert np.all(table.flows[-1] == pump_flow)


@pytest.mark.slow
def test_only_the_gain_makes_pressure_networks_fail_and_it_closes_the_valve_too_late(machine):
    found = pressure.pressure_causes(boom_study(Lab(machine, Cache(None), Cache(None))))
    usual, strong = found[pressure.AS_RUN], found[pressure.STRONGEST]
    assert strong.rate > 10.0
    assert usual.rate < 0.2
    assert usual.closes == pytest.approx(3.5, abs=0.03)
    assert strong.closes > 4.0
    others = [failure.rate for name, failure in found.items() if not name.startswith("pilot gain")]
    assert max(others) < 0.1 * strong.rate
    assert found[f"{pressure.STRONGEST}, and Q - Q_e"].rate < 0.1  # what the inlet's equation does
    assert found[pressure.WIDE_INLET].spread > usual.spread + 1.0  # printed: 61.90
