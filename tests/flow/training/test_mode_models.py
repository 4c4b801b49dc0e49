"""A flow is the least of those that the pump's modes give alone: what the networks of single modes rest on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from polydraulic.flow.sample import sample_flow

from polydraulic import load_machine
from polydraulic.flow import exact_flow
from polydraulic.flow.training.mode_models import at_constant_flow, at_relief, at_torque_limit
from polydraulic.thesis.excavator import pump_of, spool_of, with_pumps
from polydraulic.units import to_si

MACHINE = load_machine("cat215b")
SPOOL = st.floats(0.0, spool_of(MACHINE).end)
PRESSURE = st.floats(0.0, pump_of(MACHINE, "boom").relief)


def flows(exact, spool, p):
    """Flows into swing, boom and stick."""
    return sample_flow(exact, spool, p, np.zeros_like(p)).q_in[0]


@pytest.mark.parametrize("exponent", [None, 0.5, 1.0, 2.0])
@settings(max_examples=60, deadline=None)
@given(spool=st.tuples(SPOOL, SPOOL, SPOOL), p=st.tuples(PRESSURE, PRESSURE, PRESSURE))
def test_flows_are_the_least_of_the_modes(exponent, spool, p):
    pumps = MACHINE.pumps._replace(torque_limit_enabled=exponent is not None, torque_limit_exponent=exponent or 1.0)
    machine = MACHINE._replace(pumps=pumps)
    modes = [at_constant_flow(machine), at_relief(machine), *([at_torque_limit(machine)] if exponent else [])]
    spool, p = np.array([spool]), np.array([p])
    true, alone = flows(exact_flow(machine), spool, p), [flows(mode, spool, p) for mode in modes]
    assert true == pytest.approx(np.min(alone, axis=0), abs=1e-9 * pumps.series_flow)


def test_each_mode_is_the_least_somewhere():
    machine = with_pumps(MACHINE, torque_limit_enabled=True)
    spool, p = np.full((1, 3), to_si(0.36, "in")), np.zeros((1, 3))
    modes = [at_constant_flow(machine), at_relief(machine), at_torque_limit(machine)]
    found = [
        int(np.argmin([flows(mode, spool, np.full_like(p, to_si(psi, "psi")))[1] for mode in modes]))
        for psi in (0.0, 3000.0, 4400.0)
    ]
    assert found == [0, 2, 1]
