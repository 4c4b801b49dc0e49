"""A single environment: Gymnasium's own check passes, episodes repeat, levers and options that cannot be used are refused."""

import runpy
from importlib import util
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import polydraulic.gym
from polydraulic import InputError, SimulationError, load_machine
from polydraulic.gym import MachineEnv
from polydraulic.gym.arguments import STEPS, TASKS
from polydraulic.parameters.load import machine_names

WEIGHED = pytest.param("PickPlace", marks=pytest.mark.slow)  # with a payload, a text of its own to compile


@pytest.fixture(scope="module")
def reach():
    return MachineEnv("Reach", "wheel_loader")


def played(env, seed, actions):
    seen, info = env.reset(seed=seed)
    rows = [seen]
    for action in actions:
        seen, *_, info = env.step(action)
        rows.append(seen)
    return np.array(rows), info


@pytest.mark.parametrize("task", ["Reach", "Grade", WEIGHED])
def test_gymnasium_has_nothing_to_say(task):
    """Warnings are errors."""
    env = gymnasium.make(f"polydraulic/{task}-v0", machine=load_machine("wheel_loader"))
    assert env.spec.max_episode_steps == STEPS[task]
    check_env(env.unwrapped)
    env.close()


@pytest.mark.slow  # each machine is compiled, and once more with a payload
@pytest.mark.parametrize("machine", machine_names())
@pytest.mark.parametrize("task", TASKS)
def test_every_machine_has_every_task(task, machine):
    check_env(gymnasium.make(f"polydraulic/{task}-v0", machine=machine).unwrapped)


def test_episodes_are_cut_off():
    env = gymnasium.make("polydraulic/Reach-v0", machine="wheel_loader", max_episode_steps=3)
    env.reset(seed=0)
    assert [env.step(np.zeros(2))[2:4] for _ in range(3)] == [(False, False), (False, False), (False, True)]


def test_a_seed_repeats_an_episode_and_another_does_not(reach):
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (10, 2))
    first, _ = played(reach, 5, actions)
    assert np.array_equal(played(reach, 5, actions)[0], first)
    assert not np.array_equal(played(reach, 6, actions)[0], first)


def test_observations_are_what_their_names_say(reach):
    seen, info = reach.reset(seed=1)
    seen, *_ = reach.step(np.array([1.0, -0.5]))
    named = dict(zip([number.name for number in reach.numbers], seen, strict=True))
    sim, machine = reach.simulator, reach.workspace.machine
    lift = machine.function("lift")
    assert named["lift.travel"] == pytest.approx(
        (2.0 * sim["lift.angle"] - lift.stops.low - lift.stops.high) / (lift.stops.high - lift.stops.low), rel=1e-5
    )
    assert named["lift.rate"] == pytest.approx(float(sim["lift.rate"]), rel=1e-5)
    assert named["tilt.spool"] == pytest.approx(sim["tilt.spool"] / 0.01, rel=1e-5)
    assert named["tilt.load"] == pytest.approx((sim["tilt.p_a"] - sim["tilt.p_b"]) / 3.2e7, rel=1e-5)
    tip = np.array([sim[f"effector.{axis}"] for axis in "xyz"])
    assert [named[f"goal.{axis}"] for axis in ("out", "left", "up")] == pytest.approx(info["goal"] - tip, abs=1e-5)
    assert float(sim["lift.voltage"]) == pytest.approx(0.8)  # full lever


def test_levers_stand_at_their_ends_beyond_them(reach):
    beyond, _ = played(reach, 0, [np.array([3.0, -7.0])] * 4)
    assert np.array_equal(beyond, played(reach, 0, [np.array([1.0, -1.0])] * 4)[0])


@pytest.mark.parametrize("action", [[np.nan, 0.0], [0.0], [0.0, 0.0, 0.0], [[0.0, 0.0]], "up", [np.inf, 0.0]])
def test_levers_that_cannot_be_used_are_refused(reach, action):
    reach.reset(seed=0)
    with pytest.raises(InputError, match=r"action = .*of the shape \(2,\)"):
        reach.step(action)


def test_no_step_without_an_episode():
    with pytest.raises(InputError, match="call reset first"):
        MachineEnv("Reach", "wheel_loader").step(np.zeros(2))


def test_a_goal_that_is_asked_for(reach):
    goal = reach.workspace.tips[7]
    _, info = reach.reset(seed=0, options={"target": goal})
    assert np.array_equal(info["goal"], goal)
    with pytest.raises(InputError, match=r"options name 'depth'; Reach takes \['target'\]"):
        reach.reset(options={"depth": 1.0})


def test_a_line_at_a_given_depth():
    env = MachineEnv("Grade", "wheel_loader", depth=0.5)
    for seed in range(3):
        assert env.reset(seed=seed)[1]["goal"][2] == pytest.approx(0.5, abs=0.05)  # where the tip has come to rest


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"task": "Dig"}, "task = 'Dig': must be one of"),
        ({"machine": "tractor"}, "tractor"),
        ({"period": 0.012}, "whole number of steps"),
        ({"period": float("nan")}, "whole number of steps"),
        ({"dt": -1.0}, "whole number of steps"),
        ({"depth": 1.0}, "height of the line of Grade"),
        ({"load": 5.0}, "what PickPlace carries"),
        ({"randomize": {"colour": (0, 1)}}, "randomize names 'colour'"),
        ({"randomize": "payload"}, "randomize = 'payload': must name numbers and their ranges"),
        ({"render_mode": "human"}, "render_mode = 'human'"),
    ],
)
def test_what_cannot_be_built_is_named(options, said):
    with pytest.raises(InputError, match=said):
        MachineEnv(**{"task": "Reach", "machine": "wheel_loader"} | options)


def test_machines_are_drawn_and_said():
    env = MachineEnv("Reach", "wheel_loader", randomize={"valve_gain": (0.5, 2.0), "dead_time": (0.0, 0.1)})
    _, one = env.reset(seed=0)
    assert set(one) == {"goal", "valve_gain", "dead_time"}
    assert np.all((one["valve_gain"] > 0.5) & (one["valve_gain"] < 2.0))
    env.step(np.array([0.2, 0.2]))
    pilots = [f.pilot for f in env.simulator.machine.functions]
    nominal = [f.pilot for f in load_machine("wheel_loader").functions]
    assert [pilot.gain for pilot in pilots] == pytest.approx([p.gain for p in nominal] * one["valve_gain"])
    assert [pilot.dead_time for pilot in pilots] == pytest.approx(one["dead_time"])
    _, other = env.reset()
    assert not np.array_equal(other["valve_gain"], one["valve_gain"])
    assert np.array_equal(env.reset(seed=0)[1]["valve_gain"], one["valve_gain"])


def test_a_machine_that_diverges_ends_its_episode(monkeypatch):
    env = MachineEnv("Reach", "wheel_loader")
    before, _ = env.reset(seed=0)

    def diverge(*_, **__):
        raise SimulationError("lift: a rate grew without bound")

    monkeypatch.setattr(env.simulator, "step", diverge)
    seen, reward, terminated, truncated, info = env.step(np.zeros(2))
    assert np.array_equal(seen, before)
    assert np.isfinite(reward)
    assert (terminated, truncated, info["diverged"], info["is_success"]) == (True, False, True, False)


def test_a_picture_shows_machine_and_goal():
    env = MachineEnv("Reach", "wheel_loader", render_mode="rgb_array")
    env.reset(seed=0, options={"target": env.workspace.tips[0]})
    one = env.render()
    assert one.dtype == np.uint8
    red = (one[..., 0] > 150) & (one[..., 1] < 90) & (one[..., 2] < 90)
    assert 20 < red.sum() < 500  # two crosses
    for _ in range(10):
        env.step(np.array([1.0, 1.0]))
    assert (env.render() != one).any(axis=-1).mean() > 0.01
    assert MachineEnv("Reach", "wheel_loader").render() is None


def test_without_gymnasium_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.setattr(util, "find_spec", lambda name: None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'polydraulic\[gym\]'") as said:
        runpy.run_path(str(Path(polydraulic.gym.__file__)))
    assert said.value.name == "gymnasium"
