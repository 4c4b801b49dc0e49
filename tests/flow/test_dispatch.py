"""One body over all flow models, each held to what it claims."""

import numpy as np
import pytest

from helpers.flow_steps import PSI, flow_step, points, states, step, step_all, with_limit
from polydraulic import build_flow
from polydraulic.errors import InputError
from polydraulic.flow import FLOW_KINDS, NOT_CONVERGED
from polydraulic.flow.dispatch import layout_flow
from polydraulic.flow.polynomial import shipped_models
from polydraulic.thesis.excavator import LINKS, pump_of, spool_of


def test_flows_are_finite_and_not_negative(model, machine):
    for spool, p_in, p_out in points(machine):
        flows = step(machine, model, spool, p_in, p_out)
        values = [flows.q_in.boom, flows.k_out.boom, flows.boom.q_bypass, flows.boom.q_relief, flows.boom.p_pump]
        assert np.all(np.isfinite(values))
        assert min(flows.q_in.boom, flows.k_out.boom, flows.boom.q_bypass, flows.boom.q_relief) >= 0.0


LEARNT = ("pressure", "residual")  # that need networks
BOTH_CIRCUITS = [name for name in FLOW_KINDS if name not in LEARNT]


@pytest.mark.parametrize("model", BOTH_CIRCUITS, indirect=True)
def test_pump_flow_is_shared_out(model, machine):
    for spool, p_in, p_out in points(machine):
        flows = step(machine, model, spool, p_in, p_out)
        circuit = flows.boom
        assert circuit.q_pump == pytest.approx(pump_of(machine, "boom").flow, rel=1e-12)
        parts = [flows.q_in.boom, circuit.q_bypass, circuit.q_relief, circuit.q_stored]
        assert sum(parts) == pytest.approx(circuit.q_pump, rel=1e-9)


# at -1 exactly the opening region answers: a border belongs to the cell below it
@pytest.mark.parametrize("share", [-0.999, -0.5, 0.0, 0.7, 1.0])
def test_nothing_flows_in_the_deadband(model, machine, share):
    flows = step(machine, model, share * spool_of(machine).deadband, 500 * PSI, 800 * PSI)
    assert flows.q_in.boom == 0.0
    assert flows.k_out.boom == 0.0


@pytest.mark.parametrize("limit", [False, True])
@pytest.mark.parametrize("name", BOTH_CIRCUITS)
def test_both_pumps_share_out_their_flow(machine, build, name, limit):
    """From rest at each state, and as one state follows another."""
    machine = with_limit(machine) if limit else machine
    model = build(name, machine)
    memory, small = np.zeros(model.n_memory), 1.0 + 1e-12
    for number, (spool, p_in, p_out) in enumerate(states(machine, 400)):
        from_rest = number < 200
        flows = (
            step_all(machine, model, spool, p_in, p_out)
            if from_rest
            else flow_step(machine, model, memory, spool, p_in, p_out)
        )
        for circuit, q_in, full in (
            (flows.boom, flows.q_in.boom, pump_of(machine, "boom").flow),
            (flows.series, flows.q_in.swing + flows.q_in.stick, pump_of(machine, "series").flow),
        ):
            parts = [q_in, circuit.q_bypass, circuit.q_relief]
            assert min(*parts, *flows.q_in) >= -1e-15 * full
            assert sum(parts) + circuit.q_stored == pytest.approx(circuit.q_pump, rel=1e-9)
            assert model.stores_oil or circuit.q_stored == 0.0
            assert 0.0 < circuit.q_pump <= full * small
            assert limit or circuit.q_pump == pytest.approx(full, rel=1e-12)
            assert circuit.p_pump <= pump_of(machine, "boom").relief * small
        # the iteration leaves its last pressure where nothing passes
        assert name != "exact" or flows.p_between <= flows.series.p_pump * small


# Largest error of the input flow that each model may have against exact, as a share of the pump's flow.
# The pump-pressure networks state none: they are kept to show that they fail.
# Models with pressures of their own are at rest here; tests of their own say how they get there.
STATED = {
    "exact": 1e-12,
    "iterative": 0.08,
    "stiff": 1e-8,
    "tlm": 1e-5,
    "polynomial": 0.004,
    "polynomial-fine": 0.0004,
    "neural": 0.1,
    "lookup": 0.03,
}


@pytest.mark.parametrize("model", STATED, indirect=True)
def test_input_flow_is_near_exact(model, machine):
    stated = STATED[model.name]
    exact = build_flow("exact", machine)
    settled = 0
    for spool, p_in, p_out in points(machine):
        flows = step(machine, model, spool, p_in, p_out)
        if flows.status != NOT_CONVERGED:  # it states nothing then
            settled += 1
            error = flows.q_in.boom - step(machine, exact, spool, p_in, p_out).q_in.boom
            assert abs(error) <= stated * pump_of(machine, "boom").flow
    assert settled > 180


def test_unknown_models_list_the_choices(machine):
    with pytest.raises(InputError, match=r"unknown flow model 'magic'; choose one of \['exact', 'iterative'"):
        build_flow("magic", machine)
    with pytest.raises(InputError, match="int is not a flow model"):
        layout_flow(3, machine)
    with pytest.raises(InputError, match="flow 'pressure' needs models"):
        build_flow("pressure", machine)


def boom_models():
    return [model for model in shipped_models() if model.output.name.startswith("boom.")]


def test_networks_serve_the_functions_they_are_given_for(machine):
    assert build_flow("polynomial", machine).served == LINKS
    assert build_flow("polynomial", machine, models=boom_models()).served == ("boom",)
    series = [model for model in shipped_models() if model not in boom_models()]
    assert build_flow("polynomial", machine, models=series).served == ("swing", "stick")
    assert build_flow("exact", machine).served == LINKS
