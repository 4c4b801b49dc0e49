"""What is taken of estimates: what shows is found, what hardly shows is as it was."""

import numpy as np

from polydraulic import load_machine
from polydraulic.identification.equations.free_numbers import Freedom
from polydraulic.identification.equations.numbers.estimates import estimates_of
from polydraulic.identification.equations.ways.so_far import SoFar, is_mechanical

BYPASS = "functions.lift.valve.bypass"


def test_what_hardly_shows_keeps_its_value_and_what_trades_is_named():
    machine = load_machine("wheel_loader")
    before = {number.path: number.value for number in machine.numbers}
    paths = [
        f"{BYPASS}[0]",
        f"{BYPASS}[1]",
        "circuits.work.pump.flow",
        "links.tool.mass" if "links.tool.mass" in before else "links.lift_arm.mass",
    ]
    paths = [path for path in paths if path in before]
    values = np.array([1.1 * before[path] for path in paths])
    spread = 0.3 * np.array([before[path] for path in paths])
    left = np.array([0.95, 0.1, 0.7, 0.99])[: len(paths)]
    correlation = np.eye(len(paths))
    correlation[1, 2] = correlation[2, 1] = 0.97
    so_far = SoFar(machine, Freedom({}, True), "identified from a log")
    so_far.take_estimates(estimates_of(paths, values, np.diag((left * spread) ** 2), spread, correlation), "told so")
    bypass = so_far.changes[BYPASS]
    assert bypass.value[:2] == (before[f"{BYPASS}[0]"], values[1])
    assert bypass.uncertainty[0] == np.inf
    assert bypass.uncertainty[1] == left[1] * spread[1]
    assert set(bypass.uncertainty[2:]) == {0.0}
    assert so_far.machine.circuit("work").pump.flow == values[2]
    assert f"{paths[0]}: kept; it hardly shows in this log" in so_far.kept
    assert so_far.remarks == [f"circuits.work.pump.flow trades against {BYPASS}[1] (rises with it)"]
    assert all(path not in so_far.changes for path in paths[3:])


def test_a_knot_that_hardly_shows_moves_along_where_its_curve_would_turn():
    """A bypass falls: an end that shows little stays below what was found before it, or moves with it."""
    machine = load_machine("wheel_loader")
    before = {number.path: number.value for number in machine.numbers}
    paths = [f"{BYPASS}[{k}]" for k in range(4)]
    was = np.array([before[path] for path in paths])
    spread = 0.3 * was
    for factor, moves in ((0.9, False), (0.4, True)):  # the third knot then lies above the fourth as it was, or below
        values = np.append(factor * was[:3], 0.8 * factor * was[3])
        so_far = SoFar(machine, Freedom({}, True), "identified from a log")
        covariance = np.diag((np.array([0.1, 0.1, 0.1, 0.95]) * spread) ** 2)
        so_far.take_estimates(estimates_of(paths, values, covariance, spread, np.eye(4)), "told so")
        found = so_far.changes[BYPASS]
        assert found.value[:3] == tuple(values[:3])
        assert found.value[3] == (values[3] if moves else was[3])
        assert np.all(np.diff(found.value) <= 0.0)
        assert np.isfinite(found.uncertainty[3]) == moves
        assert (f"{paths[3]}: kept; it hardly shows in this log" in so_far.kept) != moves
        assert any(line.startswith(f"{paths[3]} hardly shows") for line in so_far.remarks) == moves


def test_masses_and_friction_are_known_by_their_paths():
    assert is_mechanical("links.boom.cg.x")
    assert is_mechanical("functions.boom.friction.viscous")
    assert not is_mechanical("links.boom.at.x")
    assert not is_mechanical("functions.boom.pilot.gain")


def test_what_hardly_shows_moves_along_where_the_machine_would_be_impossible():
    machine = load_machine("cat215b")
    moments = [f"links.boom.inertia.{key}" for key in ("xx", "yy", "zz")]
    swing, boom = (
        [f"functions.{name}.friction.{kind}" for kind in ("coulomb", "static")] for name in ("swing", "boom")
    )
    paths = [*moments, *swing, *boom]
    before = {number.path: number.value for number in machine.numbers}
    xx, yy, zz = (before[path] for path in moments)
    raised = 1.1 * before[boom[1]]
    values = np.array(
        [xx + 500.0, yy + 500.0, zz, 0.9 * before[swing[0]], 1.2 * before[swing[1]], raised, 1.3 * raised]
    )
    left = np.array([0.95, 0.1, 0.1, 0.1, 0.95, 0.1, 0.95])  # which moments and static friction hardly show
    spread = np.full(len(paths), 1000.0)
    so_far = SoFar(machine, Freedom({}, True), "identified from a log")
    so_far.take_estimates(
        estimates_of(paths, values, np.diag((left * spread) ** 2), spread, np.eye(len(paths))), "told so"
    )
    found = {number.path: number.value for number in so_far.machine.numbers}
    assert found[moments[0]] == values[0]
    assert found[swing[1]] == before[swing[1]]
    assert found[boom[1]] == values[-1]
    moved = [line.partition(" ")[0] for line in so_far.remarks if "moved with them" in line]
    assert moved == [moments[0], boom[1]]
    assert so_far.kept == [f"{swing[1]}: kept; it hardly shows in this log"]
