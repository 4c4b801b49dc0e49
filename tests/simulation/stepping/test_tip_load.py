"""Loads at the tip of machines that are moved step by step are those of runs, and are changed by hand between steps."""

import numba
import numpy as np
import pytest

from helpers.held_levers import held_scenario, random_levers
from helpers.held_steps import DT, MANY, TIP, assert_row, held_to_run, levers_of, play
from polydraulic import BatchSimulator, InputError, Simulator, simulate
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.signals import Constant, Piecewise, Sine

STEPS = 3 if numba.config.DISABLE_JIT else 30  # of 128 lanes
LOADS = Loads(
    {"x": Sine(8e3, 9.0), "z": Piecewise(np.array([0.0, 0.1, 0.2]), np.array([0.0, -2e4, 0.0]))},
    Payload((0.062, 0.15), (1500.0, 200.0)),
)


@pytest.mark.slow_to_compile
def test_forces_and_payloads_over_time(loader):
    run = held_to_run(loader, random_levers(7, 60, 2), load=LOADS)
    light = simulate(loader, "exact", held_scenario(loader, random_levers(7, 60, 2), DT))
    assert np.abs(run["lift.rate"] - light["lift.rate"]).max() > 1e-3


@pytest.mark.slow_to_compile
def test_a_load_by_hand_is_that_of_a_scenario(loader):
    levers = np.full((30, 2), 0.3)
    load = Loads({"z": Constant(-5e3)}, Payload((0.0, 0.1), (0.0, 900.0)))
    run = simulate(loader, "exact", held_scenario(loader, levers, DT, load=load))
    with Simulator(loader, load={"z": -5e3, "payload": 0.0}) as sim:
        sim.step(levers[0], n=20)
        sim.step(n=10, load={"payload": 900.0})
        assert_row(sim, run, 30)
        sim.reset()
        sim.step(levers[0], n=20)
        assert_row(sim, run, 20)
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


@pytest.mark.slow_to_compile
def test_forces_and_payloads_of_each_machine(loader):
    mass, push = np.linspace(0.0, 2000.0, MANY), np.linspace(-5e3, 5e3, MANY)
    levers = levers_of(STEPS, 2)
    with BatchSimulator(loader, MANY, load={"payload": mass, "z": push}) as sim:
        play(sim, levers)
        for i in (0, 40, 69):
            load = Loads({"z": Constant(push[i])}, Payload((0.0,), (mass[i],)))
            run = simulate(loader, "exact", held_scenario(loader, levers[i], DT, load=load))
            assert all(sim[name][i] == run[name][-1] for name in sim.outputs if name not in TIP)
        sim.reset(payload=mass[::-1])
        sim.step(levers[:, 0], n=3, load={"z": 0.0, "x": push})
        load = Loads({"z": Constant(0.0), "x": Constant(push[2])}, Payload((0.0,), (mass[::-1][2],)))
        run = simulate(loader, "exact", held_scenario(loader, levers[2, :3], DT, load=load))
        assert all(sim[name][2] == run[name][-1] for name in sim.outputs if name not in TIP)


@pytest.mark.slow_to_compile
def test_payloads_change_between_steps_and_the_first_ones_come_back(loader):
    levers, first, later = levers_of(24, 2, n=3), np.array([0.0, 500.0, 0.0]), np.array([0.0, 800.0, 1500.0])
    mask = np.array([False, True, True])
    with BatchSimulator(loader, 3, load={"payload": first, "z": -100.0}) as sim:
        start = {name: values.copy() for name, values in sim.outputs.items()}
        sim.step(levers[:, 0], n=12)
        sim.step(levers[:, 12], n=12, load={"payload": later, "x": 50.0})
        for i in range(3):
            with Simulator(loader, load={"payload": first[i], "z": -100.0, "x": 0.0}) as one:
                one.step(levers[i, 0], n=12)
                one.step(levers[i, 12], n=12, load={"payload": later[i], "x": 50.0})
                assert all(sim[name][i] == one[name] for name in sim.outputs if name not in TIP)
        sim.reset(mask)
        assert all(np.array_equal(sim[name][mask], start[name][mask]) for name in sim.outputs)
        sim.step(levers[:, 0], n=12)
        for i, (mass, force) in enumerate([(0.0, 50.0), (500.0, 0.0), (0.0, 0.0)]):
            with Simulator(loader, load={"payload": mass, "z": -100.0, "x": force}) as one:
                if i == 0:
                    one.step(levers[0, 0], n=12, load={"x": 0.0})
                    one.step(levers[0, 12], n=12, load={"x": 50.0})
                one.step(levers[i, 0], n=12)
                assert all(sim[name][i] == one[name] for name in sim.outputs if name not in TIP)
