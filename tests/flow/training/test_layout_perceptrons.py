"""Perceptrons of any machine's circuits: what they learn is what those of the package learnt, and they run."""

import numba
import numpy as np
import pytest

from polydraulic import InputError, build_flow, load_machine, simulate
from polydraulic.flow.training.circuit_models import circuit_targets
from polydraulic.flow.training.layout_perceptrons import inlet_targets, train_layout_perceptrons


@pytest.mark.parametrize("limited", [False, True])
def test_targets_are_those_of_the_networks_that_come_with_the_package(machine, limited):
    circuits = tuple(c._replace(pump=c.pump._replace(torque_limit_enabled=limited)) for c in machine.circuits)
    machine = machine._replace(circuits=circuits)
    hand, rng = circuit_targets(machine), np.random.default_rng(5)
    found = {t.place[0].name: t for c in machine.circuits for t in inlet_targets(machine, c)}
    assert list(found) == ["boom.q_in", "swing.q_in", "stick.q_in"]
    for link in ("boom", "swing", "stick"):
        ours, wanted = found[f"{link}.q_in"], hand[link]
        assert ours.place == (wanted.output, wanted.inputs)
        assert np.array(ours.box) == pytest.approx(np.array(wanted.box), rel=1e-12)
        names = [variable.name for variable in wanted.inputs]
        assert ours.edges == {names.index(name): pytest.approx(cuts) for name, cuts in wanted.edges.items()}
        X = rng.uniform(*np.transpose(wanted.box), size=(300, len(names)))
        assert np.abs(ours.function(X) - wanted.function(X)).max() < 1e-9 * wanted.high


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler to learn in time")
def test_perceptrons_of_a_machine_run_in_it():
    loader, told = load_machine("wheel_loader"), []
    models = train_layout_perceptrons(
        loader, rows=400, hidden_units=2, regions=9, progress=lambda *piece: told.append(piece)
    )
    assert [what for what, _, _ in told] == ["tilt.k_out", "lift.k_out", "tilt.q_in", "lift.q_in"]
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
