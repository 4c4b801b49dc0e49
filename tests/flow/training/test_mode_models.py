"""A flow is the least of those that the pump's modes give alone: what the networks of single modes rest on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from polydraulic import load_machine
from polydraulic.flow.training.circuit_models import exact_pump, input_flow
from polydraulic.flow.training.mode_models import at_constant_flow, at_relief, at_torque_limit
from polydraulic.thesis.excavator import pump_of, spool_of, with_pumps
from polydraulic.units import to_si

MACHINE = load_machine("cat215b")
SPOOL = st.floats(0.0, spool_of(MACHINE).end)
PRESSURE = st.floats(0.0, pump_of(MACHINE, "boom").relief)


def flows(machine, mode, spool, p):
    """Flows into swing, boom and stick with the pumps that a mode gives."""
    columns = {"swing": 0, "boom": 1, "stick": 2}
    found = np.empty(3)
    for c in machine.circuits:
        X = np.array([[v[columns[name]] for v in (spool, p) for name in c.functions]])
        for name in c.functions:
            found[columns[name]] = input_flow(machine, mode(machine, c.name), X, c.functions, name)[0]
    return found


@pytest.mark.parametrize("exponent", [None, 0.5, 1.0, 2.0])
@settings(max_examples=60, deadline=None)
@given(spool=st.tuples(SPOOL, SPOOL, SPOOL), p=st.tuples(PRESSURE, PRESSURE, PRESSURE))
def test_flows_are_the_least_of_the_modes(exponent, spool, p):
    machine = with_pumps(MACHINE, torque_limit_enabled=exponent is not None, torque_limit_exponent=exponent or 1.0)
    modes = [at_constant_flow, at_relief, *([at_torque_limit] if exponent else [])]
    true, alone = flows(machine, exact_pump, spool, p), [flows(machine, mode, spool, p) for mode in modes]
    assert true == pytest.approx(np.min(alone, axis=0), abs=1e-9 * pump_of(machine, "series").flow)


def test_each_mode_is_the_least_somewhere():
    machine = with_pumps(MACHINE, torque_limit_enabled=True)
    spool = [to_si(0.36, "in")] * 3
    modes = [at_constant_flow, at_relief, at_torque_limit]
    found = [
        int(np.argmin([flows(machine, mode, spool, [to_si(psi, "psi")] * 3)[1] for mode in modes]))
        for psi in (0.0, 3000.0, 4400.0)
    ]
    assert found == [0, 2, 1]
