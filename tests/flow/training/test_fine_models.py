"""What the finer networks rest on: the least of two smooth flows is the true one, and cells learnt alone make one model."""

import numpy as np
import pytest

from polydraulic import load_machine, units
from polydraulic.flow.polynomial import shipped_models
from polydraulic.flow.training.circuit_models import input_flow
from polydraulic.flow.training.fine_models import (
    cells_of,
    check_valve_open,
    check_valve_shut,
    joined_cells,
    knots_of,
    swing_targets,
)
from polydraulic.flow.training.mode_models import at_constant_flow
from polydraulic.networks import Model, Network

MACHINE = load_machine("cat215b")


def states(n):
    """Points over the box of swing and stick, a third of them at knots and ends."""
    (target, _), rng = swing_targets(MACHINE), np.random.default_rng(2)
    low, high = np.array(target.box).T
    X = rng.uniform(low, high, (n, 4))
    for axis, name in enumerate(("swing", "stick")):
        rows = rng.random(n) < 0.3
        X[rows, axis] = rng.choice(MACHINE.function(name).valve.knots, rows.sum())
    return X


def true(X):
    return input_flow(MACHINE, at_constant_flow(MACHINE, "series"), X, ("swing", "stick"), "swing")


def test_the_true_flow_is_the_least_of_check_valve_open_and_shut():
    X, flow = states(3000), MACHINE.circuit("series").pump.flow
    either = check_valve_open(MACHINE, X), check_valve_shut(MACHINE, X)
    assert np.minimum(*either) == pytest.approx(np.minimum(true(X), flow), abs=1e-12 * flow)
    assert [np.mean(other > np.minimum(*either) + 1e-3 * flow) > 0.05 for other in either] == [True, True]


def test_with_the_check_valve_open_the_flow_has_no_kink_in_the_pressure_of_the_stick():
    """One-sided slopes at the pressure at which the valve shuts: of the open valve alike, of the true flow not."""
    p = np.linspace(0.0, 2e7, 200_001)
    X = np.column_stack([np.full_like(p, 0.008), np.full_like(p, 0.0073), np.full_like(p, 8e6), p])
    slope = np.diff(true(X))
    border = int(np.flatnonzero(np.abs(slope) > 0.5 * np.abs(slope).max())[-1])
    jump = abs(slope[border + 2] - slope[border - 2])
    smooth = np.diff(check_valve_open(MACHINE, X))
    assert abs(smooth[border + 2] - smooth[border - 2]) < 0.01 * jump


def test_cells_that_are_learnt_alone_make_one_model():
    (target, _) = swing_targets(MACHINE)
    cells = cells_of(target)
    assert len(cells) == (len(knots_of(MACHINE)("swing")) + 1) * (len(knots_of(MACHINE)("stick")) + 1)

    def stand_in(k, cell):
        low, high = np.array(cell.box).T
        network = Network((), (0.0,) * 4, (1.0,) * 4, tuple(low), tuple(high), float(k), 1.0)
        training = {"largest_error": float(k % 7), "n_evaluations": 10}
        return Model(target.inputs, target.output, (network,), training=training)

    model = joined_cells(target, [stand_in(k, cell) for k, cell in enumerate(cells)])
    rng = np.random.default_rng(3)
    for k, cell in enumerate(cells):
        low, high = np.array(cell.box).T
        assert np.all(model.predict(rng.uniform(low, high, (20, 4))) == float(k))
    assert model.training == {"largest_error": 6.0, "n_evaluations": 10 * len(cells)}


def test_the_files_of_the_package_were_learnt_from_these_flows():
    models, X = {model.output.name: model for model in shipped_models("fine")}, states(400)
    targets = swing_targets(MACHINE)
    for target in targets:
        assert np.array_equal(models[target.output.name].domain(), np.array(target.box))
    ours = np.minimum(*(models[target.output.name].predict(X) for target in targets))
    assert np.abs(ours - true(X)).max() < units.to_si(3.0, "in3/s")
