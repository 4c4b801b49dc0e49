"""Perceptrons of any machine's circuits: what they learn is what those of the package learnt, and they run."""

import numba
import numpy as np
import pytest

from polydraulic import InputError, build_flow, load_machine, simulate
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.training.circuit_models import (
    BELOW_RELIEF,
    SERIES,
    exact_pump,
    input_flow,
    pressure_boxes,
    travels,
)
from polydraulic.flow.training.layout_perceptrons import inlet_targets, train_layout_perceptrons


@pytest.mark.parametrize("limited", [False, True])
def test_targets_are_the_flows_of_the_circuits_between_marks_that_are_known(machine, limited):
    circuits = tuple(c._replace(pump=c.pump._replace(torque_limit_enabled=limited)) for c in machine.circuits)
    machine, rng = machine._replace(circuits=circuits), np.random.default_rng(5)
    found = {t.place[0].name: t for c in machine.circuits for t in inlet_targets(machine, c)}
    assert list(found) == ["boom.q_in", "swing.q_in", "stick.q_in"]
    *cuts, end = travels(machine)
    pressure, pump = pressure_boxes(machine, BELOW_RELIEF), exact_pump(machine, "series")
    stick, fed = machine.function("stick").valve, pump._replace(log_least=0.0)  # it knows of no torque limit
    expected = {
        "boom": (("boom",), lambda X: input_flow(machine, exact_pump(machine, "boom"), X, ("boom",), "boom")),
        "swing": (SERIES, lambda X: input_flow(machine, pump, X, SERIES, "swing")),
        "stick": (("stick",), lambda X: sample_valves([stick], fed, X[:, 1:2], X[:, 2:], X[:, 0]).q_in[:, 0]),
    }
    for link, (seen, flow) in expected.items():
        # the stick's reads the flow that reaches it before all else
        target, first = found[f"{link}.q_in"], int(link == "stick")
        arriving = [(0.0, pump.flow)] * first
        box = [*arriving, *((0.0, end) for _ in seen), *(pressure[name] for name in seen)]
        assert np.array(target.box) == pytest.approx(np.array(box), rel=1e-12)
        assert target.edges == {first + k: pytest.approx(cuts) for k in range(len(seen))}
        names = [variable.name for variable in target.place[1]][first:]
        assert names == [*(f"{name}.travel" for name in seen), *(f"{name}.p_in" for name in seen)]
        X = rng.uniform(*np.transpose(box), size=(300, len(box)))
        assert np.abs(target.function(X) - flow(X)).max() < 1e-9 * pump.flow


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler to learn in time")
def test_perceptrons_of_a_machine_run_in_it():
    loader, told = load_machine("wheel_loader"), []
    models = train_layout_perceptrons(
        loader, rows=400, hidden_units=2, regions=9, progress=lambda *piece: told.append(piece)
    )
    assert [what for what, _, _ in told] == ["tilt.q_in", "lift.q_in", "tilt.k_out", "lift.k_out"]
    assert [done for _, done, _ in told] == [0, 1, 2, 3]
    full = loader.circuits[0].pump.flow
    inlets = [model for model in models if model.output.name.endswith("q_in")]
    assert all(0.0 < model.training["largest_error"] < full for model in inlets)
    assert inlets[1].inputs[0].name == "work.q_passed"
    run = simulate(loader, build_flow("neural", loader, models=models), "wheel_loader_cycle", t_end=0.5)
    assert run.info["flow"] == "neural"
    assert np.isfinite(run["lift.angle"]).all()
    with pytest.raises(InputError, match="choose one of"):
        train_layout_perceptrons(loader, circuits=["boom"])
    with pytest.raises(InputError, match="regions = 0: must be at least 1"):
        train_layout_perceptrons(loader, regions=0)
