import dataclasses

import pytest

from helpers.flow_steps import PSI, step, with_limit
from polydraulic import build_flow
from polydraulic.errors import InputError
from polydraulic.flow import (
    FLOW_KINDS,
    flow_name,
)
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Variable


@pytest.mark.parametrize("model", ["pressure"], indirect=True)
def test_models_of_the_boom_leave_the_others_still(model):
    assert FLOW_KINDS[flow_name(model)].links == ("boom",)
    flows = step(model, 0.008, 500 * PSI, 800 * PSI)
    assert flows.series == (0.0,) * 5
    assert flows.q_in.swing == flows.q_in.stick == flows.k_out.swing == flows.k_out.stick == 0.0


def boom_models():
    return [model for model in shipped_models() if model.output.name.startswith("boom.")]


def test_the_pressure_model_refuses_a_torque_limit(machine):
    pressure = dataclasses.replace(boom_models()[1], output=Variable("boom.p_pump", "Pa"))
    with pytest.raises(InputError, match="torque_limit_enabled = true: this flow model has no pump pressure"):
        build_flow("pressure", with_limit(machine), models=[pressure])
