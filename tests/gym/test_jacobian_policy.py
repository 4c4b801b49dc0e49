"""Tasks are neither trivial nor impossible: a policy that knows the machine's links does them, chance and rest do not."""

import gymnasium
import numpy as np
import pytest

from polydraulic.gym import MachineVectorEnv, follow_goal
from polydraulic.gym.arguments import TASKS
from polydraulic.parameters.load import machine_names

N = 64


def done(env, policy):
    """Return of each machine's first episode, and whether it did the task."""
    seen, _ = env.reset(seed=0)
    total, success, going = np.zeros(N), np.zeros(N, dtype=bool), np.ones(N, dtype=bool)
    while going.any():
        seen, rewards, over, cut, infos = env.step(policy(seen))
        total += going * rewards
        success |= going & infos.get("is_success", success)
        going &= ~(over | cut)
    return total, success


def compared(task, machine):
    env = gymnasium.make_vec(f"polydraulic/{task}-v0", num_envs=N, machine=machine)
    rng = np.random.default_rng(0)
    knowing = done(env, follow_goal(env))
    chance = done(env, lambda seen: rng.uniform(-1.0, 1.0, (N, env.action_space.shape[1])))
    resting = done(env, lambda seen: np.zeros(env.action_space.shape))
    return knowing, chance, resting


def test_a_loader_reaches_by_its_jacobian_and_not_by_chance():
    knowing, chance, resting = compared("Reach", "wheel_loader")
    assert knowing[1].mean() > 0.85
    assert chance[1].mean() < 0.2
    assert resting[1].mean() < 0.1
    assert knowing[0].mean() > chance[0].mean() + 2.0


@pytest.mark.slow  # each machine is compiled, and once more with a payload
@pytest.mark.parametrize("machine", machine_names())
@pytest.mark.parametrize("task", TASKS)
def test_every_task_can_be_done_with_every_machine(task, machine):
    knowing, chance, resting = compared(task, machine)
    assert knowing[1].mean() > (
        0.1 if task == "Grade" else 0.8
    )  # a line asks for shared flow, which it knows nothing of
    assert chance[1].mean() < 0.15
    assert resting[1].mean() < 0.1
    assert knowing[0].mean() > max(chance[0].mean(), resting[0].mean())


def test_one_observation_gives_one_set_of_levers():
    env = MachineVectorEnv("Reach", 2, "wheel_loader")
    policy, (seen, _) = follow_goal(env), env.reset(seed=0)
    levers = policy(seen)
    assert levers.shape == (2, 2)
    assert np.array_equal(policy(seen[0]), levers[0])
    assert np.abs(levers).max() <= 1.0
    there = seen.copy()
    there[:, -3:] = 0.0
    there[:, [1, 5]] = 0.0  # rates
    assert np.array_equal(policy(there), np.zeros((2, 2)))
