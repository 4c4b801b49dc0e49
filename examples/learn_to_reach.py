"""A wheel loader learns to bring its bucket's edge to places in space: random search over linear policies, all trials side by side."""

import gymnasium
import matplotlib.pyplot as plt
import numpy as np

from polydraulic.gym import follow_goal

ROUNDS, TRIALS, EPISODES, BEST, STEP, NOISE = 120, 32, 4, 16, 0.05, 0.1
env = gymnasium.make_vec("polydraulic/Reach-v0", num_envs=2 * TRIALS * EPISODES, machine="wheel_loader")
scale = np.array([0.5, 0.3, 0.5, 0.3] * 2 + [1.0] * 3)  # of travel, rate, spool and load of both functions; of the way to the goal, m


def returns(policy, seeds):
    """What the first episode of each machine brings in all."""
    seen, _ = env.reset(seed=seeds)
    total, going = np.zeros(env.num_envs), np.ones(env.num_envs, dtype=bool)
    while going.any():
        seen, rewards, over, cut, _ = env.step(policy(seen))
        total, going = total + going * rewards, going & ~(over | cut)
    return total


def linear(weights):
    """A policy with weights (n_number + 1, n_function), or with a set of them for each machine."""
    return lambda seen: np.tanh((np.insert(seen / scale, 0, 1.0, axis=1)[:, None] @ weights)[:, 0])


rng, weights, curve = np.random.default_rng(0), np.zeros((len(scale) + 1, 2)), []
for k in range(ROUNDS):
    noise = rng.normal(size=(TRIALS, *weights.shape))
    tried = np.concatenate([weights + NOISE * noise, weights - NOISE * noise]).repeat(EPISODES, axis=0)
    seeds = np.tile(np.arange(EPISODES) + EPISODES * k, 2 * TRIALS)  # the same episodes for every trial
    up, down = returns(linear(tried), seeds.tolist()).reshape(2, TRIALS, EPISODES).mean(axis=2)
    best = np.argsort(np.maximum(up, down))[-BEST:]
    gain = (up - down)[best] / max(np.concatenate([up[best], down[best]]).std(), 1e-9)
    weights += STEP / BEST * np.einsum("t,tij->ij", gain, noise[best])
    curve.append(np.mean([up, down]))
    print(k, curve[-1], flush=True)
unseen = list(range(10**6, 10**6 + env.num_envs))
learnt, known = returns(linear(weights), unseen).mean(), returns(follow_goal(env), unseen).mean()
print(f"return of an episode: learnt {learnt:.2f}, by the inverse Jacobian {known:.2f}")
