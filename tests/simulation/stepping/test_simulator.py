"""A machine moved step by step has the bits of `simulate`, however its steps are divided among calls; what is doubtful is refused."""

import pickle
import threading

import numba
import numpy as np
import pytest

from helpers.excavator_tree import excavator_tree
from helpers.held_levers import held_scenario, random_levers, random_split
from polydraulic import InputError, SimulationError, Simulator, build_flow, simulate
from polydraulic.flow.polynomial import shipped_models
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.signals import Constant, Piecewise, Sine
from polydraulic.simulation.stepping import simulator

DT = 5e-3


def slowly(test):
    """Of a text of its own, which takes long to compile: quick in plain Python alone."""
    return test if numba.config.DISABLE_JIT else pytest.mark.slow(test)


TIP = ("effector.x", "effector.y", "effector.z")  # compiled here, and in NumPy behind a run: equal but for rounding


def assert_bits(sim, run, row):
    """All outputs are those of a row of a run."""
    for name in run.names:
        if name in TIP:
            assert abs(float(sim[name]) - run[name][row]) < 1e-12
        elif name != "time" and not name.endswith("voltage"):
            assert float(sim[name]) == run[name][row], (name, row)


def played(sim, levers, seed, events, *, disturb=False):
    """Play levers in calls of random lengths; gives the step at their ends, and adds to a list of events."""
    rng, k = np.random.default_rng(seed), 0
    while k < len(levers):
        same = next((i for i in range(k, len(levers)) if (levers[i] != levers[k]).any()), len(levers))
        for n in random_split(rng, same - k):
            if disturb and rng.random() < 0.3:
                kept = pickle.loads(pickle.dumps(sim.save()))
                sim.step(np.full(levers.shape[1], 0.1), n=int(rng.integers(1, 9)))
                if rng.random() < 0.5:
                    sim.reset()
                sim.restore(kept)
            sim.step(levers[k], n=n)
            events += sim.events
            k += n
            yield k


def delayed(machine, *times):
    """The machine with dead times of its pilots."""
    functions = (f._replace(pilot=f.pilot._replace(dead_time=t)) for f, t in zip(machine.functions, times, strict=True))
    return machine._replace(functions=tuple(functions))


def check(machine, levers, flow="exact", *, locked=(), load=None, dt=DT, seeds=(1, 2)):
    run = simulate(machine, flow, held_scenario(machine, levers, dt, locked=locked, load=load), dt=dt)
    for seed in seeds:
        with Simulator(machine, flow, dt=dt, locked=locked, load=load) as sim:
            assert_bits(sim, run, 0)
            events = []
            for k in played(sim, levers, seed, events, disturb=seed == seeds[-1]):
                assert_bits(sim, run, k)
            assert sim.steps == len(levers)
            assert sim.time == run["time"][-1]
            assert sorted(events) == sorted(run.info["events"])
            assert sim.steps_not_converged == run.info["steps_not_converged"]
            assert sim.steps_out_of_domain == run.info["steps_out_of_domain"]
    return run


def test_any_division_into_calls_has_the_bits_of_simulate(loader):
    run = check(loader, random_levers(1, 240, 2, limit=1.2, each=40), seeds=(1, 2, 3))
    assert len(run.info["events"]) > 5


def test_dead_times_are_counted_in_whole_steps(loader):
    slow = delayed(loader, 0.02, 0.0123)
    run = check(slow, random_levers(2, 90, 2))
    prompt = simulate(loader, "exact", held_scenario(loader, random_levers(2, 90, 2), DT))
    assert np.array_equal(run["lift.spool"][4:], prompt["lift.spool"][:-4])
    assert np.array_equal(run["tilt.spool"][3:], prompt["tilt.spool"][:-3])  # 2.46 steps


@slowly
def test_effects_keep_their_memory(worn_crane):
    check(worn_crane, random_levers(3, 120, 3), dt=2e-3)


def test_locked_functions_stand_still_and_their_levers_are_ignored(loader):
    run = check(loader, random_levers(4, 60, 2), locked=("tilt",))
    assert "tilt.p_a" not in run.names
    with Simulator(loader, locked=["tilt"]) as sim:
        assert "tilt.p_a" not in sim.outputs
        with pytest.raises(InputError, match="inputs name tilt, which is locked"):
            sim.step({"tilt": 0.1})


@slowly
@pytest.mark.parametrize("flow", ["iterative", "lookup", "stiff", "tlm"])
def test_other_flow_models_keep_what_they_remember(loader, flow):
    options = {"points": 6} if flow == "lookup" else {}
    check(loader, random_levers(5, 60, 2), build_flow(flow, loader, **options))


@slowly
def test_networks_too():
    tree = excavator_tree()
    check(tree, random_levers(6, 60, 3), build_flow("polynomial", tree, models=shipped_models("cascade")))


LOADS = Loads(
    {"x": Sine(8e3, 9.0), "z": Piecewise(np.array([0.0, 0.1, 0.2]), np.array([0.0, -2e4, 0.0]))},
    Payload((0.062, 0.15), (1500.0, 200.0)),
)


@slowly
def test_forces_and_payloads_over_time(loader):
    run = check(loader, random_levers(7, 60, 2), load=LOADS)
    light = simulate(loader, "exact", held_scenario(loader, random_levers(7, 60, 2), DT))
    assert np.abs(run["lift.rate"] - light["lift.rate"]).max() > 1e-3


@slowly
def test_a_load_by_hand_is_that_of_a_scenario(loader):
    levers = np.full((30, 2), 0.3)
    load = Loads({"z": Constant(-5e3)}, Payload((0.0, 0.1), (0.0, 900.0)))
    run = simulate(loader, "exact", held_scenario(loader, levers, DT, load=load))
    with Simulator(loader, load={"z": -5e3, "payload": 0.0}) as sim:
        sim.step(levers[0], n=20)
        sim.step(n=10, load={"payload": 900.0})
        assert_bits(sim, run, 30)
        sim.reset()
        sim.step(levers[0], n=20)
        assert_bits(sim, run, 20)
    with Simulator(loader) as sim:
        for load, words in (({"payload": 1.0}, "a payload, for which"), ({"x": 1.0}, "a force at the tip, for which")):
            with pytest.raises(InputError, match=words):
                sim.step(load=load)
        for load, words in (
            ({"w": 1.0}, "load names 'w'"),
            ({"payload": -1.0}, "load: payload = -1.0: must be a finite number in kg, at least 0 kg"),
            ({"x": float("nan")}, "load: x = nan: must be a finite number in N"),
            (3.0, "load = 3.0: must be a mapping"),
        ):
            with pytest.raises(InputError, match=words):
                sim.step(load=load)
        assert sim.steps == 0


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


def test_a_run_to_a_time_an_event_or_a_condition(loader):
    sim = Simulator(loader)
    assert sim.run_until(0.1)
    assert sim.steps == 20
    assert sim.run_until("lift high stop met", {"lift": 0.8}, limit=20.0)
    assert sim.events[-1][1:] == ["lift", "high stop met"]
    assert sim.time == sim.events[-1][0]  # no step is made beyond
    met = sim.time
    assert not sim.run_until("low stop met", {"lift": 0.0}, limit=0.2)
    assert sim.time == pytest.approx(met + 0.2)
    low = float(sim["lift.angle"]) - 0.1
    assert sim.run_until(lambda s: s["lift.angle"] < low, {"lift": -0.8})
    assert low - 0.05 < float(sim["lift.angle"]) < low
    for until, words in (
        ("stop met", "until = 'stop met': no such event; there are"),
        (0.05, "until = 0.05 s: has passed"),
        (float("nan"), "until = nan: must be a finite number in s"),
        (1e9, "at most 1e.09 are made"),
    ):
        with pytest.raises(InputError, match=words):
            sim.run_until(until)


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


class FakeClock:
    """Time passes in sleeps, and where a test says so."""

    def __init__(self):
        self.now, self.slept = 100.0, []

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.slept.append(seconds)
        self.now += seconds


def test_real_time_is_kept_by_deadlines_and_never_written_into_the_run(loader):
    clock = FakeClock()
    free, sim = Simulator(loader), Simulator(loader, realtime=2.0, clock=clock, sleep=clock.sleep)
    for k in range(40):
        clock.now += 0.4 if k == 20 else 0.001  # somebody thinks for long, once
        sim.step([0.5, 0.1], n=2)
        free.step([0.5, 0.1], n=2)
    assert np.array_equal(sim.values, free.values)
    assert sim.time == free.time == 0.4
    assert sim.pace.overruns == 1
    assert sim.pace.lost == pytest.approx(0.4 - 0.005)
    assert clock.now == pytest.approx(100.0 + 0.001 + 0.2 + sim.pace.lost)
    sim.reset()
    clock.now += 7.0  # a new run has a new schedule
    sim.run_until(0.1)
    assert sim.pace.overruns == 1


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
