import numpy as np
import pytest

from helpers.flow_steps import PSI, step_all
from polydraulic import build_flow
from polydraulic.flow.sample import sample_fed, sample_flow
from polydraulic.machine.state import Links


def test_samples_are_the_steps(model):
    spool = np.array([[0.006, -0.008, 0.007], [0.0, 0.008, -0.006], [-0.007, 0.0, 0.01]])
    p_in, p_out = np.array([[1e6, 2e6, 3e6], [5e6, 4e6, 3e6], [1e6, 1e6, 9e6]]), np.full((3, 3), 2e6)
    sample = sample_flow(model, spool, p_in, p_out)
    for i in range(3):
        flows = step_all(model, Links(*spool[i]), Links(*p_in[i]), Links(*p_out[i]))
        assert tuple(sample.q_in[i]) == flows.q_in
        assert tuple(sample.k_out[i]) == flows.k_out
        assert tuple(sample.p_pump[i]) == (flows.boom.p_pump, flows.series.p_pump)


def test_a_fed_valve_is_the_second_one_of_a_series(machine):
    exact = build_flow("exact", machine)
    spool, p_in = Links(0.0, 0.0, 0.008), Links(0.0, 0.0, 60.0 * PSI)
    alone = step_all(exact, spool, p_in, Links(0.0, 0.0, 0.0))
    fed = sample_fed(exact.valves.stick, exact.series_pump, np.array([[machine.pumps.series_flow, 0.008, 60.0 * PSI]]))
    assert fed[0] == pytest.approx(alone.q_in.stick, rel=1e-12)
