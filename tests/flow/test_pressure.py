import dataclasses

import numpy as np
import pytest

from helpers.flow_steps import PSI, layout_step, states, step, with_limit
from helpers.valves import orifices
from polydraulic import AbductiveRegressor, build_flow
from polydraulic.errors import InputError
from polydraulic.flow.layout.database import sample_circuit
from polydraulic.flow.layout.slots import pressure_before
from polydraulic.flow.polynomial import shipped_models
from polydraulic.machine.valve import orifice_flow
from polydraulic.networks import Variable
from polydraulic.thesis.boom_models import fit_columns


@pytest.mark.parametrize("model", ["pressure"], indirect=True)
def test_models_of_the_boom_leave_the_others_still(machine, model):
    assert model.served == ("boom",)
    flows = step(machine, model, 0.008, 500 * PSI, 800 * PSI)
    assert flows.series.p_pump == 0.0
    assert flows.q_in.swing == flows.q_in.stick == flows.k_out.swing == flows.k_out.stick == 0.0


def boom_models():
    return [model for model in shipped_models() if model.output.name.startswith("boom.")]


def test_the_pressure_model_refuses_a_torque_limit(machine):
    pressure = dataclasses.replace(boom_models()[1], output=Variable("boom.p_pump", "Pa"))
    with pytest.raises(InputError, match="torque_limit_enabled = true: flow 'pressure' does not know"):
        build_flow("pressure", with_limit(machine), models=[pressure])


@pytest.fixture(scope="module")
def learnt(machine):
    """Pressures before the valves of both circuits of the excavator as links, each a rough network."""
    links, rng, models = machine, np.random.default_rng(2), []
    for c in links.circuits:
        table = sample_circuit(links, c.name, 500, rng=rng, pressure=(0.0, 3000 * PSI))
        for place in range(len(c.functions)):
            output, inputs = pressure_before(c, place)
            names = [variable.name for variable in inputs]
            models.append(fit_columns(AbductiveRegressor(max_layers=1), table, names, output.name, {}))
    return links, models


def test_flows_of_valves_in_series_are_those_that_the_pressures_drive(machine, learnt):
    links, models = learnt
    flow = build_flow("pressure", links, models=models)
    assert flow.served == links.names
    ours, p_return = layout_step(links, flow), links.tank.return_pressure
    at = {model.output.name: model for model in models}
    for spool, p_in, p_out in states(machine, 20):
        found = ours(spool, p_in, p_out)
        read = np.array([[abs(spool.swing), abs(spool.stick), p_in.swing, p_in.stick]])
        p, between = (float(at[f"series.{name}"].predict(read)[0]) for name in ("p_pump", "p_between"))
        assert (found.circuit_series.p_pump, found.between_series_1) == pytest.approx((p, between), rel=1e-12)
        k_swing, k_stick = (
            orifices(spool.swing, machine.function("swing").valve),
            orifices(spool.stick, machine.function("stick").valve),
        )
        wanted = orifice_flow(k_swing.inlet, p - p_in.swing), orifice_flow(k_stick.inlet, between - p_in.stick)
        assert (found.q_in.swing, found.q_in.stick) == pytest.approx(wanted, rel=1e-9)
        assert found.circuit_series.q_bypass == pytest.approx(
            orifice_flow(k_stick.bypass, between - p_return), rel=1e-9
        )


def test_what_does_not_fit_a_layout_is_named(machine, learnt):
    links, models = learnt
    with pytest.raises(InputError, match="fit one of 'work.p_pump' on a sampled table first"):
        build_flow("pressure", "wheel_loader")
    with pytest.raises(InputError, match=r"flow 'pressure' needs one of \['boom.p_pump', 'series.p_pump'\]"):
        build_flow("pressure", links, models=[models[2]])
    with pytest.raises(InputError, match="needs one model of series.p_between"):
        build_flow("pressure", links, models=[models[1]])
    with pytest.raises(
        InputError, match=r"circuits.boom.pump.torque_limit_enabled = true: flow 'pressure' does not know"
    ):
        build_flow("pressure", with_limit(machine), models=[models[0]])
