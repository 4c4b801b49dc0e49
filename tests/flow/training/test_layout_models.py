"""Networks of a circuit of any machine: what they learn, and how well."""

import numba
import numpy as np
import pytest

from polydraulic import InputError, build_flow, load_machine
from polydraulic.flow import TrainingEffort, sample_circuit, train_layout
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.training.layout_models import _inlets, _modes, affordable
from polydraulic.machine.pump import limited_pump

CRANE = load_machine("loader_crane")


@pytest.mark.parametrize("circuit", CRANE.circuits, ids=lambda c: c.name)
@pytest.mark.parametrize("limited", [False, True])
def test_what_enters_and_what_passes_are_the_least_of_the_modes(circuit, limited):
    circuit = circuit._replace(pump=circuit.pump._replace(torque_limit_enabled=limited))
    valves, rng = [CRANE.function(f).valve for f in circuit.functions], np.random.default_rng(2)
    travel = rng.uniform(0.0, [v.knots[-1] for v in valves], (200, len(valves)))
    p_in = rng.uniform(0.0, circuit.pump.relief, travel.shape)
    pump = limited_pump(circuit.pump.flow, circuit.pump.relief, CRANE.tank.return_pressure, circuit.pump)
    true = sample_valves(valves, pump, travel, p_in)
    alone = [sample_valves(valves, mode, travel, p_in) for mode in _modes(CRANE, circuit)[: 3 if limited else 2]]
    for what in ("q_in", "q_passed"):
        least = np.min([getattr(mode, what) for mode in alone], axis=0)
        assert np.abs(least - getattr(true, what)).max() < 1e-9 * circuit.pump.flow


def test_valves_behind_the_first_know_the_pump_by_what_reaches_them():
    c = CRANE.circuits[1]
    table = sample_circuit(CRANE, c.name, 300, rng=np.random.default_rng(3))
    targets = {target.place[0].name: target for target in _inlets(CRANE, c)}
    for f in c.functions[1:]:
        target = targets[f"{f}.q_in"]
        X = np.column_stack([table[variable.name] for variable in target.place[1]])
        assert np.abs(target.function(np.maximum(X, 0.0)) - table[f"{f}.q_in"]).max() < 1e-6 * c.pump.flow
    assert "slew_and_reach.q_passed_1_limited" not in targets  # its pump has no torque limit


def test_known_borders_are_given_as_far_as_regions_go():
    edges = {0: [1.0, 2.0], 1: [], 2: [1.0, 2.0], 3: [1.0]}
    assert affordable(edges, 64) == {0: [1.0, 2.0], 2: [1.0, 2.0], 3: [1.0]}
    assert affordable(edges, 9) == {0: [1.0, 2.0], 2: [1.0, 2.0]}
    assert affordable(edges, 2) == {}


@pytest.fixture(scope="module")
def rough():
    """The lift's two valves, learnt in haste, and what was told meanwhile."""
    if numba.config.DISABLE_JIT:
        pytest.skip("needs the compiler to learn in time")
    told = []
    models = train_layout(
        CRANE, circuits=["lift"], effort=TrainingEffort(0.05, 6, 150), progress=lambda *piece: told.append(piece)
    )
    return models, told


def test_a_circuit_alone_may_be_learnt(rough):
    models, told = rough
    assert {model.output.name for model in models} == {
        *("inner.k_out", "outer.k_out", "inner.k_in", "inner.q_in", "inner.q_in_limited", "outer.q_in"),
        *("lift.q_passed_relief", "lift.q_passed_limited"),
    }
    assert build_flow("polynomial", CRANE, models=models).served == ("inner", "outer")
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told)
    assert told[-1][1:] == (len(models) - 1, len(models))
    assert all(len(model.networks) <= 6 for model in models if model.output.unit == "m3/s")


def test_the_stated_error_is_hardly_exceeded_elsewhere(rough):
    models, _ = rough
    table = sample_circuit(CRANE, "lift", 4000, rng=np.random.default_rng(5))
    model = next(model for model in models if model.output.name == "outer.q_in")
    X = np.column_stack([table[variable.name] for variable in model.inputs])
    error = np.abs(model.predict(X) - table["outer.q_in"])
    assert error.max() < 1.5 * model.training["largest_error"]
    outlet = next(model for model in models if model.output.name == "inner.k_out")
    k = table["inner.k_out"]
    assert np.abs(outlet.predict(table["inner.spool"][:, None]) - k).max() < 2e-3 * k.max()


def test_what_cannot_be_learnt_is_named():
    with pytest.raises(InputError, match="unknown circuit 'boom'"):
        train_layout(CRANE, circuits=["boom"])
    with pytest.raises(InputError, match="circuits = \\[\\]: name some of \\['lift', 'slew_and_reach'\\]"):
        train_layout(CRANE, circuits=[])
