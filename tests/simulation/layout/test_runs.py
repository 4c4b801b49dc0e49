"""Machines of other layouts in time: balances, stops, and the excavator as a tree of links against its closed form."""

import numba
import numpy as np
import pytest

from helpers.excavator_tree import excavator_tree
from helpers.layout_states import check_jacobian
from polydraulic import InputError, load_machine, load_scenario, simulate, simulate_batch
from polydraulic.parameters.scenario import Scenario, random_operator
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.layout.runs import simulate_layout
from polydraulic.simulation.summary import run_summary


@pytest.fixture(scope="module")
def run(crane):
    return simulate(crane, "exact", "random:3:20")


def test_oil_is_neither_made_nor_lost(crane, run):
    for c in crane.circuits:
        used = sum(run[f"{f}.q_in"] for f in c.functions)
        gap = run[f"{c.name}.q_pump"] - used - run[f"{c.name}.q_bypass"] - run[f"{c.name}.q_relief"]
        assert np.abs(gap).max() < 1e-12 * c.pump.flow
        assert run[f"{c.name}.p_pump"].max() <= c.pump.relief * (1 + 1e-12)
        limited = run[f"{c.name}.p_pump"] > c.pump.torque_limit_start
        power = run[f"{c.name}.p_pump"] * run[f"{c.name}.q_pump"] / (c.pump.flow * c.pump.torque_limit_start)
        assert np.allclose(power[limited], 1.0, atol=1e-9)


def test_joints_stay_within_their_stops_and_pressures_between_floor_and_relief(crane, run):
    for f in crane.functions:
        where = run[f"{f.name}.position" if f.name == "extend" else f"{f.name}.angle"]
        assert f.stops.low <= where.min()
        assert where.max() <= f.stops.high
        assert run[f"{f.name}.p_a"].min() >= crane.tank.floor
        assert run[f"{f.name}.p_b"].max() <= f.line.relief
    assert run["extend.position"].max() == pytest.approx(1.4)
    met = [event for event in run.info["events"] if event[1:] == ["extend", "high stop met"]]
    assert met
    assert run["extend.position"][np.searchsorted(run["time"], met[0][0])] == pytest.approx(1.4, abs=1e-3)


def test_the_tip_is_where_the_joints_put_it(run):
    reach = 0.1 + (1.8 + run["extend.position"] + 1.5) * np.cos(run["lift.angle"])
    assert np.allclose(np.hypot(run["effector.x"], run["effector.y"]), reach, atol=1e-12)


def test_a_summary_speaks_of_the_machines_own_functions(run):
    lines = run_summary(run)
    assert "slew" in lines[0]
    assert "second pump" in lines[0]
    assert any(line.startswith("at the end: slew") and "extend" in line for line in lines)


@pytest.fixture(scope="module")
def joined_run(joined_crane):
    return simulate(joined_crane, "exact", "random:3:20")


def test_a_crossover_takes_from_one_pump_what_the_other_circuit_gets(joined_crane, joined_run):
    run, cross = joined_run, joined_run["main_giving.q_cross"]
    assert run.info["steps_not_converged"] == 0
    for c, sign in zip(joined_crane.circuits, (1.0, -1.0), strict=True):
        used = sum(run[f"{f}.q_in"] for f in c.functions)
        gap = run[f"{c.name}.q_pump"] - used - run[f"{c.name}.q_bypass"] - run[f"{c.name}.q_relief"] - sign * cross
        assert np.abs(gap).max() < 1e-12 * c.pump.flow
        assert run[f"{c.name}.p_pump"].max() <= c.pump.relief * (1 + 1e-12)
        limited = run[f"{c.name}.p_pump"] > c.pump.torque_limit_start
        power = run[f"{c.name}.p_pump"] * run[f"{c.name}.q_pump"] / (c.pump.flow * c.pump.torque_limit_start)
        assert np.allclose(power[limited], 1.0, atol=1e-9)
    (x,), lift = joined_crane.crossovers, joined_crane.function("lift")
    conductance = np.interp(np.abs(run["lift.spool"]), lift.valve.knots, x.valve.conductance)
    drop = run["main_giving.p_pump"] - run["main_taking.p_between"] - x.valve.opening_pressure
    assert np.allclose(cross, conductance * np.sqrt(np.maximum(drop, 0.0)), rtol=0.0, atol=1e-9 * cross.max())
    assert 0.1 < np.mean(cross > 0.0) < 0.9


def test_a_crossover_that_opens_is_an_event_and_no_warning(joined_run):
    named = [event[2] for event in joined_run.info["events"] if event[1] == "main"]
    assert named[:2] == ["crossover opens", "crossover closes"]
    lines = run_summary(joined_run)
    assert any("crossover opens" in line for line in lines)
    assert not any("warning" in line and "crossover" in line for line in lines)


def test_the_other_function_moves_faster_with_a_crossover(joined_crane):
    scenario = Scenario(
        "up and out", 2.0, {"lift": Constant(0.8), "extend": Constant(0.8)}
    )  # a centred valve lets the oil pass
    shut = joined_crane.crossovers[0].valve._replace(conductance=(0.0,) * 4)
    alone = joined_crane._replace(crossovers=(joined_crane.crossovers[0]._replace(valve=shut),))
    with_it, without = (simulate(machine, "exact", scenario)["lift.angle"][-1] for machine in (joined_crane, alone))
    start = joined_crane.function("lift").initial.angle
    assert with_it - start > 1.1 * (without - start)


@pytest.mark.slow_to_compile
def test_joined_circuits_in_lanes_have_the_bits_of_single_runs(joined_crane):
    operators = [random_operator(seed, 0.5, functions=joined_crane.names) for seed in range(3)]
    batch = simulate_batch(joined_crane, "exact", operators, keep=["rows"])
    run = simulate(joined_crane, "exact", operators[2])
    assert "main_giving.q_cross" in batch.names
    assert all(np.array_equal(batch[name][2], run[name]) for name in batch.names)


def test_locked_functions_stand_still_and_keep_their_columns_short(crane):
    run = simulate(crane, "exact", random_operator(5, 3.0, links=("lift",), functions=crane.names))
    assert np.ptp(run["slew.angle"]) == 0.0
    assert np.ptp(run["extend.position"]) == 0.0
    assert np.ptp(run["lift.angle"]) > 0.01
    assert "slew.p_a" not in run.names
    assert "second.p_pump" not in run.names
    assert "main.p_pump" in run.names


def test_a_run_in_pieces_and_of_some_rows_is_the_same_run(crane, run):
    options = {"dt": 5e-3, "t_end": None, "every": 5, "method": "semi-implicit", "energy": True}
    pieces = simulate_layout(crane, "exact", "random:3:20", piece=77, **options)
    assert np.array_equal(pieces["time"], run["time"][::5])
    assert all(np.array_equal(pieces[name], run[name][::5]) for name in run.names)
    assert len(pieces["energy.kinetic"]) == len(pieces)


def test_without_input_a_machine_at_rest_stays_where_oil_holds_it(crane):
    run = simulate(crane, "exact", random_operator(5, 3.0, links=("slew",), functions=crane.names), t_end=0.2)
    assert np.abs(run["slew.rate"]).max() < 1e-3


@pytest.mark.parametrize(
    ("flow", "scenario", "options", "words"),
    [
        ("exakt", "random:1:1", {}, "unknown flow model 'exakt'"),
        (
            "polynomial",
            "random:1:1",
            {},
            "flow 'polynomial': no networks come with the package for 'Small crane': train networks for this machine",
        ),
        (
            "iterative",
            "random:1:1",
            {"method": "rk4"},
            "flow 'iterative' with method 'rk4': .* use method 'semi-implicit'",
        ),
        (
            "exact",
            "task",
            {},
            "is for the machine 'cat215b', which is moved by swing, boom, stick; this one is moved by slew",
        ),
        ("exact", load_scenario("random:1:1"), {}, "names 'swing', which the machine does not have"),
    ],
)
def test_what_a_layout_cannot_do_is_refused_by_name(crane, flow, scenario, options, words):
    with pytest.raises(InputError, match=words):
        simulate(crane, flow, scenario, **options)


@pytest.mark.slow
def test_the_excavator_of_the_thesis_moves_like_the_file():
    file = load_machine("cat215b")
    for name in ("task", "step", "sine", "pulse"):
        tree, arm = simulate(excavator_tree(), "exact", name), simulate(file, "exact", name)
        for link in ("swing", "boom", "stick"):
            assert (
                np.abs(tree[f"{link}.angle"] - arm[f"{link}.angle"]).max() < 1e-8
            )  # coordinates are rounded to 1e-9 m
        assert [event[1:] for event in tree.info["events"]] == [event[1:] for event in arm.info["events"]]


@pytest.mark.slow_to_compile
def test_steps_solve_with_the_true_jacobian_where_a_crossover_joins_three_valves(joined_crane):
    assert check_jacobian(joined_crane, np.random.default_rng(5), 8) > 3


@pytest.mark.slow_to_compile
@pytest.mark.parametrize("method", ["semi-implicit", "rosenbrock", "reference"])
def test_a_pump_whose_own_functions_are_locked_is_seen_while_it_feeds_another_through_a_crossover(joined_crane, method):
    scenario = Scenario("lift", 2.0, {"lift": Constant(0.8)}, locked=joined_crane.circuit("main_giving").functions)
    run = simulate(joined_crane, "exact", scenario, method=method)
    assert run["main_giving.q_cross"].max() > 0.0
    assert run["main_giving.q_pump"].min() > 0.0
    assert ["main", "crossover opens"] in [event[1:] for event in run.info["events"]]
    if method == "semi-implicit":
        steps = 40 if numba.config.DISABLE_JIT else 400  # plain Python fills 64 lanes slowly
        batch = simulate_batch(joined_crane, "exact", [scenario], t_end=5e-3 * steps, keep=("rows",))
        assert np.array_equal(batch.table(0)["main_giving.q_cross"], run["main_giving.q_cross"][: steps + 1])


def test_flow_models_of_valves_in_series_refuse_a_crossover(joined_crane):
    with pytest.raises(InputError, match="circuit 'main_giving' is of the kind 'crossover'"):
        simulate(joined_crane, "iterative", "random:1:1")
