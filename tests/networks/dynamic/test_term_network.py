import numpy as np

from polydraulic.networks import Dynamics, Lag, Model, Variable
from polydraulic.networks.dynamic.free_run import prepare_loop, run_windows
from polydraulic.networks.dynamic.lagged_terms import Terms, frame_of, run_terms
from polydraulic.networks.dynamic.term_network import places_read, term_networks
from polydraulic.networks.model.nodes import LINEAR

NAMES, READS = ["u", "v", "y"], [(0, 0), (0, 1), (1, 1), (2, 1), (2, 3)]
FACTORS = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 2, 0], [2, 2, 2], [4, 2, 0], [4, 2, 1], [5, 0, 0], [5, 5, 0], [2, 1, 0]]
SIGNALS = np.random.default_rng(0).normal(loc=3.0, scale=0.5, size=(60, 3))


def polynomial(factors):
    coef = np.random.default_rng(1).uniform(-0.2, 0.2, size=len(factors))
    return Terms(np.array(factors, dtype=np.int64), np.zeros(len(factors), dtype=np.int64), coef)


def model_of(frame, terms):
    lags = tuple(Lag(NAMES[READS[place][0]], READS[place][1]) for place in places_read(terms))
    (network,) = term_networks(frame, terms)
    return Model(tuple(Variable(str(lag)) for lag in lags), Variable("y"), (network,), dynamics=Dynamics(lags))


def test_the_network_runs_as_the_polynomial_does():
    frame, terms, windows = frame_of(SIGNALS, 1, READS, [(3, 60)], 0.3), polynomial(FACTORS), [(3, 30), (30, 60)]
    model = model_of(frame, terms)
    assert [variable.name for variable in model.inputs] == ["u[t]", "u[t-1]", "y[t-1]", "y[t-3]"]  # v is not read
    run = run_windows(prepare_loop([model], NAMES), SIGNALS, windows)[3:, 0]
    (errors, _), *_ = run_terms(frame, terms, windows)
    assert np.allclose(run - SIGNALS[3:, 2], frame.scale[2] * errors, rtol=0.0, atol=1e-12)
    assert len(model.networks[0].nodes) == 3  # a Triple, a Single and what adds them and the rest up


def test_linear_terms_need_one_linear_node_and_a_constant_none():
    frame = frame_of(SIGNALS, 1, READS, [(3, 60)], 0.3)
    (linear,) = term_networks(frame, polynomial([[1, 0, 0], [4, 0, 0]]))
    assert [node.kind for node in linear.nodes] == [LINEAR]
    (constant,) = term_networks(frame, polynomial([[0, 0, 0]]))
    assert constant.nodes == ()
    assert constant.y_mean != frame.mean[2]
