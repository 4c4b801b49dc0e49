"""Exact circuits with networks of what they leave: what is added, at whose cost, and where nothing can be."""

import numpy as np
import pytest

from helpers.flow_steps import PSI, Links, flow_step, states
from polydraulic import AbductiveRegressor, build_flow
from polydraulic.errors import InputError
from polydraulic.flow import OUT_OF_DOMAIN
from polydraulic.flow.layout.slots import residual
from polydraulic.networks import Variable
from polydraulic.thesis.excavator import pump_of, spool_of


@pytest.fixture(scope="module")
def models(machine):
    """Networks for boom and stick, learnt from a plane; the swing has none."""
    rng, found = np.random.default_rng(1), []
    for name in ("boom", "stick"):
        circuit = next(c for c in machine.circuits if name in c.functions)
        n = len(circuit.functions)
        X = np.hstack([rng.uniform(0.0, 0.0143, (400, n)), rng.uniform(0.0, 2e7, (400, n))])
        y = 2e-2 * X[:, 0] - 1e-11 * X[:, n]
        output, inputs = residual(circuit, name)
        found.append(AbductiveRegressor(max_layers=1, output_bounds=(-5e-4, 5e-4)).fit(X, y).to_model(inputs, output))
    return found


def test_networks_add_to_flows_at_the_cost_of_the_bypass(machine, models):
    flow, exact = build_flow("residual", machine, models=models), build_flow("exact", machine)
    at, changed, moved = {m.output.name.split(".")[0]: m for m in models}, 0, machine.circuits
    for spool, p_in, p_out in states(machine, 60):
        ours, plain = (
            flow_step(machine, model, np.zeros(model.n_memory), spool, p_in, p_out) for model in (flow, exact)
        )
        assert ours.k_out == plain.k_out
        for circuit in moved:
            found, was = (getattr(flows, circuit.name) for flows in (ours, plain))
            left = was.q_pump - was.q_relief
            for name in circuit.functions:
                q = getattr(plain.q_in, name)
                if name in at and q > 0.0:
                    read = [
                        [
                            *(abs(getattr(spool, f)) for f in circuit.functions),
                            *(getattr(p_in, f) for f in circuit.functions),
                        ]
                    ]
                    q = min(max(q + float(at[name].predict(np.array(read))[0]), 0.0), left)
                    changed += q != getattr(plain.q_in, name)
                assert getattr(ours.q_in, name) == pytest.approx(min(q, left), rel=1e-12, abs=1e-18)
                left -= getattr(ours.q_in, name)
            assert found.q_bypass == pytest.approx(left, rel=1e-9, abs=1e-15)
            assert found.q_bypass >= 0.0
            assert found[2:] == was[2:]
    assert changed > 20


def test_nothing_is_added_in_the_deadband_or_against_a_load(machine, models):
    flow = build_flow("residual", machine, models=models)
    still, relief = Links(0.0, 0.0, 0.0), pump_of(machine, "boom").relief
    for spool, p_in in ((0.9 * spool_of(machine).deadband, 0.0), (0.012, 1.01 * relief)):
        flows = flow_step(
            machine, flow, np.zeros(flow.n_memory), still._replace(boom=spool), still._replace(boom=p_in), still
        )
        assert flows.q_in.boom == 0.0
    beyond = flow_step(
        machine, flow, np.zeros(flow.n_memory), still._replace(boom=0.012), still._replace(boom=3500.0 * PSI), still
    )
    assert beyond.status == OUT_OF_DOMAIN


def test_what_does_not_fit_is_refused(machine, models):
    with pytest.raises(
        InputError,
        match=r"flow 'residual' needs models=\[\.\.\.\] \(--model FILE\), one at least of .*'boom.q_in_residual'",
    ):
        build_flow("residual", machine)
    other = AbductiveRegressor(max_layers=1).fit(np.arange(40.0)[:, None], np.arange(40.0))
    wrong = other.to_model([Variable("boom.travel", "m")], Variable("boom.q_in_residual", "m3/s"))
    with pytest.raises(InputError, match="reads"):
        build_flow("residual", machine, models=[wrong])
