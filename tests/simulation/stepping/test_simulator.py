"""A machine moved step by step has the bits of `simulate`, however its steps are divided among calls; what is doubtful is refused."""

import pickle
import threading

import numba
import numpy as np
import pytest

from helpers.excavator_tree import excavator_tree
from helpers.held_levers import held_scenario, random_levers
from helpers.held_steps import DT, held_to_run
from polydraulic import InputError, SimulationError, Simulator, build_flow, simulate
from polydraulic.flow.polynomial import shipped_models
from polydraulic.simulation.stepping import simulator


def delayed(machine, *times):
    """The machine with dead times of its pilots."""
    functions = (f._replace(pilot=f.pilot._replace(dead_time=t)) for f, t in zip(machine.functions, times, strict=True))
    return machine._replace(functions=tuple(functions))


def test_any_division_into_calls_has_the_bits_of_simulate(loader):
    run = held_to_run(loader, random_levers(1, 240, 2, limit=1.2, each=40), seeds=(1, 2, 3))
    assert len(run.info["events"]) > 5


def test_dead_times_are_counted_in_whole_steps(loader):
    slow = delayed(loader, 0.02, 0.0123)
    run = held_to_run(slow, random_levers(2, 90, 2))
    prompt = simulate(loader, "exact", held_scenario(loader, random_levers(2, 90, 2), DT))
    assert np.array_equal(run["lift.spool"][4:], prompt["lift.spool"][:-4])
    assert np.array_equal(run["tilt.spool"][3:], prompt["tilt.spool"][:-3])  # 2.46 steps


@pytest.mark.slow_to_compile
def test_effects_keep_their_memory(worn_crane):
    held_to_run(worn_crane, random_levers(3, 120, 3), dt=2e-3)


def test_locked_functions_stand_still_and_their_levers_are_ignored(loader):
    run = held_to_run(loader, random_levers(4, 60, 2), locked=("tilt",))
    assert "tilt.p_a" not in run.names
    with Simulator(loader, locked=["tilt"]) as sim:
        assert "tilt.p_a" not in sim.outputs
        with pytest.raises(InputError, match="inputs name tilt, which is locked"):
            sim.step({"tilt": 0.1})


@pytest.mark.slow_to_compile
@pytest.mark.parametrize("flow", ["iterative", "lookup", "stiff", "tlm"])
def test_other_flow_models_keep_what_they_remember(loader, flow):
    options = {"points": 6} if flow == "lookup" else {}
    held_to_run(loader, random_levers(5, 60, 2), build_flow(flow, loader, **options))


@pytest.mark.slow_to_compile
def test_networks_too():
    tree = excavator_tree()
    held_to_run(tree, random_levers(6, 60, 3), build_flow("polynomial", tree, models=shipped_models("cascade")))


def test_outputs_are_views_that_follow_and_cannot_be_written(loader):
    sim = Simulator(loader)
    angle, row = sim["lift.angle"], sim.values
    assert np.shares_memory(angle, row)
    before = float(angle)
    sim.step({"lift": 0.6}, n=60)
    assert float(angle) == row[sim.place["lift.angle"]] != before
    assert float(sim["lift.voltage"]) == 0.6
    assert sim.units["lift.p_in"] == "Pa"
    for view in (angle, row, sim.state):
        with pytest.raises(ValueError, match="read-only"):
            view[...] = 0.0
    with pytest.raises(InputError, match="no output 'lift'"):
        sim["lift"]


def test_a_state_to_start_from(loader):
    sim = Simulator(loader)
    sim.step([0.5, -0.5], n=50)
    middle = sim.state.copy()
    sim.reset(middle)
    assert (sim.time, sim.events) == (0.0, [])
    assert np.array_equal(sim.state, middle)
    sim.reset({"lift.angle": 0.2})
    assert float(sim["lift.angle"]) == 0.2
    here = sim.state.copy()
    for state, words in (
        (middle[:-1], "state has the shape"),
        (np.append(middle[:-1], np.nan), "state: tilt.rate = nan: must be a finite number"),
        ({"lift.anlge": 0.0}, "state names 'lift.anlge'; a state has"),
        ({"lift.angle": 9.0}, "state: lift.angle = 9 rad: must lie between the stops"),
        ({"lift.angle": "up"}, "state: lift.angle = 'up': must be a number"),
    ):
        with pytest.raises(InputError, match=words):
            sim.reset(state)
        assert np.array_equal(sim.state, here)


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        ([0.1, float("nan")], "tilt: the lever's voltage is nan; it must be a number in V"),
        (np.array([np.inf, 0.0]), "lift: the lever's voltage is inf"),
        ([0.0, -2.5], "tilt: the lever's voltage is -2.5 V; 0.8 V gives full travel, and at most 2.4 V to either side"),
        ([0.1], r"inputs have the shape \(1,\); the machine is moved by lift, tilt: give \(2,\)"),
        (0.1, r"inputs have the shape \(\)"),
        (np.zeros((1, 2)), r"inputs have the shape \(1, 2\)"),
        (["0.1", "0.2"], "must be numbers in V, in the order lift, tilt"),
        ([[0.1], 0.2], "must be numbers in V"),
        ([1j, 0.0], "must be numbers in V"),
        ({"lfit": 0.1}, "inputs name 'lfit', which the machine does not have; it has"),
        ({"lift": None}, "must be numbers in V"),
    ],
)
def test_doubtful_levers_are_refused_and_nothing_moves(loader, inputs, words):
    sim = Simulator(loader)
    sim.step({"lift": 0.4}, n=5)
    here = sim.state.copy()
    with pytest.raises(InputError, match=words):
        sim.step(inputs)
    assert np.array_equal(sim.state, here)
    assert sim.steps == 5
    sim.step()  # levers are where they were, or centred
    assert float(sim["lift.voltage"]) in (0.4, 0.0)


@pytest.mark.parametrize("n", [0, -1, 1.5, "2", 10**10])
def test_numbers_of_steps_that_are_none(loader, n):
    with pytest.raises(InputError, match="must be a whole number, from 1 to 1e.09"):
        Simulator(loader).step(n=n)


def test_events_of_a_long_call_are_those_of_many_short_ones(loader, monkeypatch):
    """More than one call of compiled code can leave at once."""
    levers = np.repeat(np.tile([[0.8, -0.8], [-0.8, 0.8]], (40, 1)), 10, axis=0)
    run = simulate(loader, "exact", held_scenario(loader, levers, DT))
    monkeypatch.setattr(simulator, "_MOST_NOTED", 3)
    tight = Simulator(loader)
    tight._engine.changes = tight._engine.changes[:2]
    found = []
    for k in range(0, len(levers), 10):
        tight.step(levers[k], n=10)
        found += tight.events
    assert len(found) > 20
    assert tight.events_dropped == 0
    assert sorted(found) == sorted(run.info["events"])


def test_what_diverges_ends_before_the_step_in_which_it_does(loader):
    sim = Simulator(loader)
    sim.reset({"lift.rate": 1e300})
    before = sim.state.copy()
    with (
        np.errstate(all="ignore"),  # in plain Python
        pytest.raises(SimulationError, match="diverged: a rate grew without bound after t = 0 s"),
    ):
        sim.step(n=50)
    assert np.array_equal(sim.state, before)
    sim.reset()
    sim.step(n=2)
    assert np.isfinite(sim.values).all()


def test_states_of_other_machines_are_refused(loader):
    kept = Simulator(loader, dt=2e-3).save()
    for other in (Simulator(loader), Simulator(loader, dt=2e-3, locked=["lift"])):
        with pytest.raises(InputError, match="what was saved is of another machine, load, flow model, step"):
            other.restore(kept)
    with pytest.raises(InputError, match="what was saved"):
        Simulator(loader).restore(None)
    Simulator(loader, dt=2e-3).restore(kept)


def test_after_the_end_nothing_moves(loader):
    with Simulator(loader) as sim:
        sim.step()
    with pytest.raises(InputError, match="the simulator is closed"):
        sim.step()
    assert np.isfinite(sim.values).all()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"locked": ["boom"]}, "locked names 'boom', which the machine does not have"),
        ({"locked": "lift"}, "locked = 'lift': must be a list of names"),
        ({"locked": ["lift", "tilt"]}, "nothing is left to move"),
        ({"dt": 0.0}, "the time step must be positive"),
        ({"flow": "exakt"}, "unknown flow model"),
        ({"realtime": 0.0}, "realtime = 0.0: must be a finite number"),
    ],
)
def test_what_cannot_be_built_is_named(options, words):
    with pytest.raises(InputError, match=words):
        Simulator(**{"machine": "wheel_loader"} | options)


def test_another_thread_runs_while_a_machine_moves(loader):
    """The compiled part lets go of Python's lock: states of a thread are those of a run without one."""
    sim, alone, counted = Simulator(loader), Simulator(loader), 0
    n = 3_000 if numba.config.DISABLE_JIT else 400_000  # long enough for the other thread to be given a turn
    thread = threading.Thread(target=lambda: sim.step([0.3, 0.2], n=n))
    thread.start()
    while thread.is_alive():
        counted += 1
    thread.join()
    alone.step([0.3, 0.2], n=n)
    assert counted > 0
    assert np.array_equal(sim.values, alone.values)


def test_other_numbers_act_from_the_next_step_on(loader):
    weak = {"circuits.work.pump.flow": 0.5 * loader.circuit("work").pump.flow}
    sim = Simulator(loader)
    sim.step({"lift": 0.6}, n=20)
    kept = sim.save()
    sim.change(weak)
    sim.step({"lift": 0.6}, n=40)
    changed = sim.values.copy()
    assert float(sim["work.q_pump"]) == sim.machine.circuit("work").pump.flow == weak["circuits.work.pump.flow"]
    sim.restore(kept)  # the numbers of then come back, too
    assert sim.machine == loader
    sim.step({"lift": 0.6}, n=40)
    assert float(sim["work.q_pump"]) == loader.circuit("work").pump.flow
    other = Simulator(loader)
    other.restore(kept)
    other.change(weak)
    for _ in range(40):
        other.step({"lift": 0.6})
    np.testing.assert_array_equal(other.values, changed)
    again = pickle.loads(pickle.dumps(other.save()))
    sim.restore(again)  # into one that had other numbers
    assert sim.machine == other.machine
    sim.step(), other.step()
    np.testing.assert_array_equal(sim.values, other.values)


def test_numbers_changed_before_the_first_step_give_the_bits_of_that_machine(loader):
    values = {"links.bucket.mass": 900.0, "functions.lift.friction.viscous": 4e4, "functions.lift.pilot.gain": 1e-3}
    sim, made = Simulator(loader), Simulator(loader.with_values(values))
    sim.change(values)
    sim.reset()
    sim.step({"lift": 0.4}, n=50), made.step({"lift": 0.4}, n=50)
    np.testing.assert_array_equal(sim.values, made.values)


def test_what_is_no_number_of_the_machine_is_not_changed(loader):
    sim = Simulator(loader)
    sim.step({"lift": 0.6}, n=20)
    before, bits = sim.machine, sim.values.copy()
    knots = [0.0, *loader.function("lift").valve.knots[1:], 2.0 * loader.function("lift").valve.knots[-1]]
    tables = {
        f"functions.lift.valve.{k}": [
            *getattr(loader.function("lift").valve, k),
            getattr(loader.function("lift").valve, k)[-1],
        ]
        for k in ("inlet", "bypass", "outlet_positive", "outlet_negative")
    }
    for values, message in (
        ({"circuits.work.pump.flaw": 1.0}, "circuits.work.pump.flow"),
        ({"circuits.work.pump.flow": -1.0}, "must be"),
        ({"functions.lift.valve.knots": knots, **tables}, "build another simulator"),
        ({"functions.lift.pilot.dead_time": 0.1}, "dead times"),
        ({"functions.lift.initial.angle": -0.6, "functions.lift.stops.high": -0.5}, "beyond"),
    ):
        with pytest.raises(InputError, match=message):
            sim.change(values)
        assert sim.machine == before
    np.testing.assert_array_equal(sim.values, bits)
