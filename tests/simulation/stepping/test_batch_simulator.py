"""Machines moved side by side have the bits of `simulate_batch` and of single ones; what begins anew leaves its neighbours alone."""

import pickle

import numba
import numpy as np
import pytest

from helpers.held_levers import held_scenario
from helpers.held_steps import DT, MANY, TIP, levers_of, play
from polydraulic import (
    AbductiveRegressor,
    BatchSimulator,
    InputError,
    Simulator,
    build_flow,
    load_machine,
    simulate,
    simulate_batch,
)
from polydraulic.flow.layout.slots import residual
from polydraulic.parameters.layout.parts import Seen
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import start_vector

STEPS = 6 if numba.config.DISABLE_JIT else 60  # of 128 lanes


def assert_bits(sim, names, rows, which=slice(None)):
    """Outputs are those of rows, (n_machine, n_column)."""
    for place, name in enumerate(names):
        if name in TIP:
            assert np.allclose(sim[name][which], rows[which, place], rtol=0.0, atol=1e-12)
        else:
            assert np.array_equal(sim[name][which], rows[which, place]), name


@pytest.mark.parametrize("threads", [1, 2])
def test_any_division_into_calls_has_the_bits_of_a_batch(loader, threads):
    levers = levers_of(STEPS, 2)
    batch = simulate_batch(loader, "exact", levers, dt=DT, keep=["rows"])
    with BatchSimulator(loader, MANY, threads=threads) as sim:
        assert_bits(sim, batch.names, batch.rows[:, 0])
        play(sim, levers, threads)
        assert_bits(sim, batch.names, batch.final)
        assert np.array_equal(sim.time, np.full(MANY, STEPS * DT))
        assert not sim.diverged.any()
        assert np.array_equal(sim.steps_not_converged, batch.not_converged)
        assert set(sim.outputs) == set(batch.names)
        assert dict(sim.units) == batch.units


def test_single_machines_begin_anew_and_their_neighbours_do_not_notice(loader):
    levers, again = levers_of(STEPS, 2), levers_of(STEPS, 2, 500)
    mask = np.random.default_rng(1).random(MANY) < 0.3
    batch = simulate_batch(loader, "exact", levers, dt=DT, keep=["rows"])
    state = np.column_stack([batch.final[:, batch.place(column.name)] for column in columns_of(loader).columns[:10]])
    fresh = simulate_batch(loader, "exact", again, dt=DT, x0=state, keep=["rows"])
    half = STEPS // 12 * 6
    with BatchSimulator(loader, MANY) as sim:
        play(sim, levers[:, :half])
        sim.reset(np.zeros(MANY, dtype=bool), {"lift.angle": 0.1})  # none
        sim.reset(mask, state)
        assert_bits(sim, batch.names, batch.rows[:, half], ~mask)
        assert_bits(sim, batch.names, fresh.rows[:, 0], mask)
        assert np.array_equal(sim.steps, np.where(mask, 0, half))
        play(sim, np.where(mask[:, None, None], again[:, : STEPS - half], levers[:, half:]))
        assert_bits(sim, batch.names, batch.rows[:, STEPS], ~mask)
        assert_bits(sim, batch.names, fresh.rows[:, STEPS - half], mask)


def test_what_is_saved_comes_back_bit_for_bit(loader):
    levers = levers_of(STEPS // 5, 2)
    with BatchSimulator(loader, MANY) as sim, BatchSimulator(loader, MANY) as other:
        play(sim, levers)
        saved = sim.save()
        play(sim, levers)
        wanted = {name: values.copy() for name, values in sim.outputs.items()}
        for fresh in (sim, other):
            fresh.restore(pickle.loads(pickle.dumps(saved)))
            play(fresh, levers, 5)
            assert all(np.array_equal(fresh[name], values) for name, values in wanted.items())
        with pytest.raises(InputError, match="what was saved is of other machines"):
            BatchSimulator(loader, 3).restore(saved)


def test_a_machine_that_diverges_stands_still_alone(loader):
    wild = np.arange(MANY) == 5
    overflow = np.errstate(all="ignore")  # in plain Python
    with overflow, BatchSimulator(loader, MANY) as sim, BatchSimulator(loader, MANY) as other:
        sim.reset(wild, {"lift.rate": 1e300})
        for each in (sim, other):
            each.step({"lift": 0.5}, n=2)
        assert np.array_equal(sim.diverged, wild)
        assert np.array_equal(sim.steps, np.where(wild, 0, 2))
        assert all(np.isnan(sim[name][5]) for name in sim.outputs)
        assert all(np.array_equal(sim[name][~wild], other[name][~wild]) for name in sim.outputs)
        sim.reset(wild)
        assert not sim.diverged.any()
        assert all(np.isfinite(sim[name]).all() for name in sim.outputs)


def randomised(loader, n=MANY):
    """Machines with other pilots, dead times and links."""
    rng, found = np.random.default_rng(3), []
    for _ in range(n):
        functions = (
            f._replace(
                pilot=f.pilot._replace(
                    gain=f.pilot.gain * rng.uniform(0.9, 1.1), dead_time=float(rng.integers(0, 4)) * DT
                )
            )
            for f in loader.functions
        )
        links = (link._replace(mass=link.mass * rng.uniform(0.9, 1.1)) for link in loader.links)
        found.append(loader._replace(functions=tuple(functions), links=tuple(links)))
    return found


@pytest.mark.slow_to_compile
def test_machines_of_their_own_with_dead_times(loader):
    machines, levers = randomised(loader), levers_of(STEPS // 2, 2)
    others, mask = randomised(loader)[::-1], np.arange(MANY) % 3 == 0
    with BatchSimulator(machines) as sim:
        play(sim, levers)
        for i in (0, 31, 63, 64, 69):
            run = simulate(machines[i], "exact", held_scenario(machines[i], levers[i], DT))
            assert all(sim[name][i] == run[name][-1] for name in sim.outputs if name not in TIP)
        before = sim["lift.angle"].copy()
        sim.reset(mask, machines=others)
        assert np.array_equal(sim["lift.angle"][~mask], before[~mask])
        play(sim, levers)
        run = simulate(others[63], "exact", held_scenario(others[63], levers[63], DT))
        assert all(sim[name][63] == run[name][-1] for name in sim.outputs if name not in TIP)


@pytest.mark.slow_to_compile
def test_one_machine_several_times_makes_room_for_others(loader):
    others = randomised(loader, 2)
    with BatchSimulator([loader, loader], longest_delay=0.1) as sim:
        sim.reset(machines=others)
        sim.step({"lift": 0.5}, n=20)
        for i, other in enumerate(others):
            run = simulate(other, "exact", held_scenario(other, np.tile([0.5, 0.0], (20, 1)), DT))
            assert sim["lift.angle"][i] == run["lift.angle"][-1]


def test_steps_beyond_the_log_of_each_are_counted(loader):
    levers = levers_of(STEPS, 2)
    seen = [
        loader._replace(functions=(loader.functions[0]._replace(seen=seen), *loader.functions[1:]))
        for seen in (Seen(2e-4), Seen(1.0, 1e6))
    ]
    batch = simulate_batch(seen[0], "exact", levers, dt=DT)
    with BatchSimulator(seen[0], MANY) as sim:
        play(sim, levers)
        assert np.array_equal(sim.steps_beyond_log, batch.beyond_log)
        assert np.array_equal(sim.steps_out_of_domain, batch.out_of_domain)
        assert np.array_equal(batch.out_of_domain, batch.beyond_log)
        for i in (0, 64, 69):
            run = simulate(seen[0], "exact", held_scenario(loader, levers[i], DT))
            assert sim.steps_beyond_log[i] == run.info["steps_beyond_log"]
        assert sim.steps_beyond_log.max() > 0
        sim.reset(np.arange(MANY) == 0)
        assert sim.steps_beyond_log[0] == 0
    mixed = simulate_batch([loader, *seen], "exact", levers[:3], dt=DT)
    assert mixed.beyond_log[0] == 0
    assert mixed.beyond_log[1] == batch.beyond_log[1]
    assert (
        mixed.beyond_log[2] == simulate(seen[1], "exact", held_scenario(loader, levers[2], DT)).info["steps_beyond_log"]
    )


@pytest.mark.slow_to_compile
def test_batches_without_lanes_count_steps_beyond_the_log(loader):
    lift, *others = loader.functions
    seen = loader._replace(functions=(lift._replace(seen=Seen(2e-4)), *others))
    levers = levers_of(STEPS, 2, n=2)
    batch = simulate_batch(seen, "iterative", levers, dt=DT)
    for i in range(2):
        run = simulate(seen, "iterative", held_scenario(loader, levers[i], DT))
        assert batch.beyond_log[i] == batch.out_of_domain[i] == run.info["steps_beyond_log"]
    assert batch.beyond_log.max() > 0


def left_over(loader):
    """A flow model with a network of what the exact circuit leaves, of travel and pressure."""
    rng, (circuit,) = np.random.default_rng(1), loader.circuits
    n = len(circuit.functions)
    X = np.hstack([rng.uniform(0.0, 8e-3, (400, n)), rng.uniform(0.0, 1e7, (400, n))])
    output, inputs = residual(circuit, "lift")
    network = AbductiveRegressor(max_layers=1, output_bounds=(-5e-4, 5e-4)).fit(X, 2e-2 * X[:, 0] - 1e-11 * X[:, n])
    return build_flow("residual", loader, models=[network.to_model(inputs, output)])


@pytest.mark.slow_to_compile
@pytest.mark.parametrize("name", ["polynomial", "residual"])
def test_networks_are_stepped_side_by_side(loader, machine, name):
    one, n, n_step = machine if name == "polynomial" else loader, 3 if numba.config.DISABLE_JIT else MANY, 18
    flow = name if name == "polynomial" else left_over(loader)
    heavy = one.with_values({f"links.{one.functions[-1].moves}.mass": 900.0})
    levers = levers_of(n_step, len(one.names), n=n)
    start = np.tile(start_vector(one), (n, 1))
    # beyond what networks have seen
    start[1, len(one.names) : 3 * len(one.names)] = 4e7
    batch = simulate_batch([one, heavy, *[one] * (n - 2)], flow, levers, dt=DT, x0=start, keep=["rows"])
    for machines in ([one, heavy, *[one] * (n - 2)], one):
        with BatchSimulator(machines, n, flow) as sim:
            same = np.arange(n) != 1 if machines is one else slice(None)
            sim.reset(state=start)
            assert_bits(sim, batch.names, batch.rows[:, 0], same)
            play(sim, levers)
            assert_bits(sim, batch.names, batch.final, same)
            assert np.array_equal(sim.steps_out_of_domain[same], batch.out_of_domain[same])
            assert np.array_equal(sim.steps_not_converged[same], batch.not_converged[same])
            saved = sim.save()
            with pytest.raises(InputError, match="what was saved is of other machines"):
                BatchSimulator(machines, n).restore(saved)
    with Simulator(heavy, flow) as single:
        single.reset(start[1])
        for k in range(0, n_step, 6):
            single.step(levers[1, k], n=6)
        assert all(batch.final[1, batch.place(c)] == single[c] for c in batch.names if c not in TIP)
        assert batch.out_of_domain[1] == single.steps_out_of_domain > 0


@pytest.mark.slow_to_compile
def test_machines_with_other_networks_are_named(machine):
    limit = machine.with_values({"circuits.boom.pump.torque_limit_enabled": True})
    with pytest.raises(InputError, match="has other networks of flow 'polynomial' than the first machine"):
        BatchSimulator([machine, limit], flow="polynomial")
    with BatchSimulator([machine, machine], flow="polynomial") as sim:
        before = sim.save()
        with pytest.raises(InputError, match="has other networks"):
            sim.reset(machines=[machine, limit])
        assert all(np.array_equal(was, getattr(sim._engine, key)) for key, was in before.arrays.items())


@pytest.mark.slow_to_compile
def test_locked_functions_in_lanes(loader):
    with BatchSimulator(loader, 2, locked=["tilt"]) as sim, Simulator(loader, locked=["tilt"]) as one:
        sim.step(np.full((2, 2), 0.5), n=4)
        one.step([0.5, 0.5], n=4)
        assert all(sim[name][1] == one[name] for name in sim.outputs)


@pytest.fixture
def pair(loader):
    with BatchSimulator(loader, 3, columns=["lift.angle", "effector.z"]) as sim:
        yield sim


def test_chosen_columns_are_views(pair):
    assert list(pair.outputs) == ["lift.angle", "effector.z"]
    with pytest.raises(ValueError, match="read-only"):
        pair["lift.angle"][0] = 0.0
    angle = pair["lift.angle"]
    before = angle.copy()
    pair.step({"lift": [0.5, 0.0, -0.5]}, n=40 if not numba.config.DISABLE_JIT else 4)
    assert np.sign(angle - before)[0] == 1.0
    with pytest.raises(InputError, match="no output 'tilt.angle'"):
        pair["tilt.angle"]


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        (np.zeros((2, 2)), r"inputs have the shape \(2, 2\); .*: give \(3, 2\)"),
        (np.array([[0, 0], [0, np.nan], [0, 0]]), "tilt of machine 1: the lever's voltage is nan"),
        (
            np.array([[0, 0], [0, 0], [9.0, 0]]),
            "lift of machine 2: the lever's voltage is 9 V; 0.8 V gives full travel",
        ),
        ({"lift": [0.1, 0.2]}, "lift = .*: must be one number for all machines, or 3"),
        ({"boom": 0.1}, "inputs name 'boom'"),
        ("half", "inputs = 'half'"),
    ],
)
def test_doubtful_levers_are_refused_and_nothing_moves(pair, inputs, words):
    with pytest.raises(InputError, match=words):
        pair.step(inputs)
    assert np.array_equal(pair.steps, [0, 0, 0])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"mask": [True, False]}, r"mask: must be 3 values"),
        ({"mask": np.array([0, 1, 2])}, "True or False"),
        ({"state": np.zeros(4)}, r"state has the shape \(4,\)"),
        ({"state": {"lift.angle": [0.0, 0.1, np.inf]}}, "state: lift.angle = inf of machine 2"),
        ({"state": {"lift": 0.0}}, "state names 'lift'"),
        ({"state": {"lift.angle": [0.0, 9.0, 0.0]}}, "lift.angle = 9 rad of machine 1: must lie between the stops"),
        ({"payload": 3.0}, "payload: this simulator was built without"),
        ({"machines": "wheel_loader"}, "machines: this simulator was built of one machine"),
    ],
)
def test_doubtful_restarts_are_refused(pair, arguments, words):
    here = pair["lift.angle"].copy()
    with pytest.raises(InputError, match=words):
        pair.reset(**arguments)
    assert np.array_equal(pair["lift.angle"], here)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"n": None}, "n: give the number of machines"),
        ({"n": 0}, "n = 0: must be a whole number, from 1 to"),
        ({"machines": []}, "0 machines"),
        ({"machines": ["wheel_loader"]}, "n = 3: there are 1 machines"),
        ({"machines": ["wheel_loader", "loader_crane"], "n": None}, "has another layout than"),
        ({"flow": "iterative"}, "flow 'iterative' cannot be stepped side by side"),
        ({"columns": ["lift"]}, "columns = .*: must be a list of some of"),
        (
            {"load": {"payload": [1.0, -1.0, 0.0]}},
            "load: payload = -1.0 of machine 1: must be a finite number, at least 0",
        ),
        ({"load": {"u": 1.0}}, "load names 'u'"),
        ({"threads": 0}, "threads = 0"),
        ({"longest_delay": -1.0}, "longest_delay = -1.0 s: the machines have dead times"),
    ],
)
def test_what_cannot_be_built_is_named(options, words):
    with pytest.raises(InputError, match=words):
        BatchSimulator(**{"machines": "wheel_loader", "n": 3} | options)


def test_after_the_end_nothing_moves(loader):
    sim = BatchSimulator(loader, 2, threads=2)
    sim.close()
    with pytest.raises(InputError, match="the simulator is closed"):
        sim.step()
    with pytest.raises(InputError, match="n = 0: must be a whole number"):
        BatchSimulator(loader, 2).step(n=0)
    with pytest.raises(InputError, match="load: has a payload, for which this simulator was not built"):
        BatchSimulator(loader, 2).step(load={"payload": 1.0})
    assert load_machine("wheel_loader") == loader
