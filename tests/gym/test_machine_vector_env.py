"""Environments side by side: the episodes of single ones bit for bit, in every mode of beginning anew; neighbours are left alone."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from polydraulic import InputError, Simulator
from polydraulic.gym import MachineEnv, MachineVectorEnv

WEIGHED = pytest.param(
    "PickPlace", AutoresetMode.SAME_STEP, marks=pytest.mark.slow
)  # with a payload, a text of its own to compile
N = 3


def assert_same(one, other):
    """Values are equal to the last bit, in dictionaries and arrays of arrays, too."""
    if isinstance(one, dict):
        assert set(one) == set(other)
        for name in one:
            assert_same(one[name], other[name])
    elif isinstance(one, tuple):
        for mine, its in zip(one, other, strict=True):
            assert_same(mine, its)
    elif one is None or other is None:
        assert one is other
    else:
        assert (one.shape, one.dtype) == (other.shape, other.dtype)
        if one.dtype == object:
            assert_same(tuple(one), tuple(other))
        else:
            assert np.array_equal(one, other)


def both(task, mode, **options):
    """The same environments side by side and one by one; episodes last 6 steps."""
    name, options = f"polydraulic/{task}-v0", {"machine": "wheel_loader", "max_episode_steps": 6, **options}
    side = gymnasium.make_vec(name, N, "vector_entry_point", autoreset_mode=mode, **options)
    single = gymnasium.make_vec(name, N, "sync", vector_kwargs={"autoreset_mode": mode}, **options)
    return side, single


@pytest.mark.parametrize(
    ("task", "mode"),
    [*(("Reach", mode) for mode in AutoresetMode), ("Grade", AutoresetMode.SAME_STEP), WEIGHED],
)
def test_episodes_are_those_of_single_environments(task, mode):
    side, single = both(task, mode)
    assert side.observation_space == single.observation_space
    assert side.action_space == single.action_space
    assert side.metadata["autoreset_mode"] is mode
    assert_same(side.reset(seed=3), single.reset(seed=3))
    rng, ended = np.random.default_rng(0), 0
    for _ in range(15):
        actions = rng.uniform(-1.0, 1.0, side.action_space.shape).astype(np.float32)
        found = side.step(actions)
        assert_same(found, single.step(actions))
        assert found[0] in side.observation_space
        over = found[2] | found[3]
        ended += over.sum()
        if mode is AutoresetMode.DISABLED and over.any():
            assert_same(side.reset(options={"reset_mask": over}), single.reset(options={"reset_mask": over}))
    assert ended == 2 * N
    side.close()
    single.close()


@pytest.mark.slow  # machines with numbers of their own, which are compiled anew
def test_drawn_machines_are_those_of_single_environments():
    drawn = {"valve_gain": (0.7, 1.3), "friction": (0.5, 2.0), "dead_time": (0.0, 0.05), "payload": (0.0, 800.0)}
    side, single = both("Reach", AutoresetMode.SAME_STEP, randomize=drawn)
    assert_same(side.reset(seed=1), single.reset(seed=1))
    for k in range(9):
        actions = np.full(side.action_space.shape, 0.8 - 0.2 * k, dtype=np.float32)
        found = side.step(actions)
        assert_same(found, single.step(actions))
    parameters = side.reset(seed=1)[1]
    assert parameters["payload"].shape == (N, 1)
    assert len(set(parameters["payload"][:, 0])) == N


@pytest.fixture(scope="module")
def disabled():
    return MachineVectorEnv("Reach", 70, "wheel_loader", autoreset_mode="Disabled", max_episode_steps=50)


def test_neighbours_of_what_begins_anew_keep_their_bits(disabled):
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (12, 70, 2))
    tips = disabled.workspace.tips
    away = np.linalg.norm(tips[:, None] - disabled.workspace.start_tips, axis=2).min(axis=1)

    def play(mask):
        disabled.reset(seed=0, options={"target": tips[away.argmax()]})  # none is there before its time
        for k, action in enumerate(actions):
            seen, *_ = disabled.step(action)
            if k == 5 and mask is not None:
                seen, infos = disabled.reset(options={"reset_mask": mask})
                assert np.array_equal(infos["_goal"], mask)
        return seen

    mask = np.arange(70) % 7 == 0
    whole, part = play(None), play(mask)
    assert np.array_equal(whole[~mask], part[~mask])
    assert not np.isclose(whole[mask], part[mask]).all(axis=1).any()


def test_seeds_are_those_of_each_machine(disabled):
    seeds = [int(seed) for seed in np.random.default_rng(0).integers(0, 5, 70)]
    seen, _ = disabled.reset(seed=seeds)
    for seed in range(5):
        alike = seen[np.array(seeds) == seed]
        assert np.all(alike == alike[0])
    assert np.array_equal(disabled.reset(seed=np.int64(0))[0][4], seen[seeds.index(4)])


def test_each_machine_has_its_goal(disabled):
    goals = disabled.workspace.tips[:70]
    _, infos = disabled.reset(options={"target": goals})
    assert np.array_equal(infos["goal"], goals)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"reset_mask": np.zeros(70, dtype=bool)}, "at least one of them True"),
        ({"reset_mask": np.ones(3, dtype=bool)}, "70 values of bool"),
        ({"reset_mask": np.ones(70)}, "70 values of bool"),
        ({"colour": 1}, "options name 'colour'"),
    ],
)
def test_options_that_cannot_be_used_are_refused(disabled, options, said):
    disabled.reset(seed=0)
    with pytest.raises(InputError, match=said):
        disabled.reset(options=options)


def test_what_is_over_takes_no_step():
    env = MachineVectorEnv("Reach", 2, "wheel_loader", autoreset_mode="Disabled", max_episode_steps=1)
    with pytest.raises(InputError, match="call reset first"):
        env.step(np.zeros((2, 2)))
    with pytest.raises(InputError, match="first reset begins all"):
        env.reset(options={"reset_mask": np.array([True, False])})
    env.reset(seed=[4, None])
    env.step(np.zeros((2, 2)))
    with pytest.raises(InputError, match=r"machines \[0, 1\] are over"):
        env.step(np.zeros((2, 2)))
    with pytest.raises(InputError, match="seed has 3 numbers"):
        env.reset(seed=[1, 2, 3])
    with pytest.raises(InputError, match=r"of the shape \(2, 2\)"):
        env.step(np.zeros(2))


def test_a_machine_that_diverges_ends_its_episode_alone(monkeypatch):
    env = MachineVectorEnv("Reach", 4, "wheel_loader")
    env.reset(seed=0)
    before, *_ = env.step(np.zeros((4, 2)))
    lost = np.array([False, True, False, False])
    values = [np.where(lost, np.nan, output) for output in env._outputs]
    monkeypatch.setattr(env, "_outputs", values)
    seen, rewards, over, _, infos = env.step(np.zeros((4, 2)))
    assert np.isfinite(seen).all()
    assert np.isfinite(rewards).all()
    assert np.array_equal(over, lost)
    assert np.array_equal(infos["diverged"], lost)
    assert np.array_equal(seen[lost], before[lost])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"autoreset_mode": "Sometimes"}, "must be one of"),
        ({"max_episode_steps": 0}, "whole number from 1 on"),
        ({"num_envs": 0}, "num_envs = 0: must be a whole number, from 1 to"),
        ({"num_envs": 2.5}, "num_envs = 2.5"),
    ],
)
def test_what_cannot_be_built_is_named(options, said):
    with pytest.raises(InputError, match=said):
        MachineVectorEnv(**{"task": "Reach", "machine": "wheel_loader", "num_envs": 2} | options)


def test_pictures_of_all():
    env = MachineVectorEnv("Reach", 2, "wheel_loader", render_mode="rgb_array")
    env.reset(seed=0)
    one, other = env.render()
    assert one.shape == other.shape
    assert (one != other).any()
    env.close()
    env.close()


@pytest.mark.slow
def test_a_load_that_is_fetched_hangs_at_the_tip_with_its_inertia():
    """Side by side, one by one, and as a simulator with that payload moves."""
    side = MachineVectorEnv("PickPlace", 2, "wheel_loader", autoreset_mode="Disabled", load=900.0)
    single = MachineEnv("PickPlace", "wheel_loader", load=900.0)
    single.reset(seed=4)
    tip = [float(single.simulator[f"effector.{axis}"]) for axis in "xyz"]
    start = single.simulator.state.copy()
    single.reset(seed=4, options={"pick": tip})
    side.reset(seed=[4, 9], options={"pick": tip})
    lever = np.array([-0.8, 0.3])
    with Simulator("wheel_loader", load={"payload": 0.0}) as plain:
        plain.reset(start)
        for k, mass in enumerate((0.0, *[900.0] * 8)):
            seen, *_, told = single.step(0.0 * lever if k == 0 else lever)
            both_seen, *_, both_told = side.step(np.tile(0.0 * lever if k == 0 else lever, (2, 1)))
            assert told["loaded"]
            assert both_told["loaded"][0]
            assert np.array_equal(seen, both_seen[0])
            volts = 0.0 * lever if k == 0 else np.clip(lever, -1.0, 1.0) * single.workspace.lever
            plain.step(volts, 10, load={"payload": mass})
            assert plain["lift.angle"] == single.simulator["lift.angle"] == side.simulator["lift.angle"][0]
    assert not both_told["loaded"][1]
