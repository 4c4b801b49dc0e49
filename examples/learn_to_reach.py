"""A wheel loader learns to bring its bucket's edge to places in space: random search over linear policies, all trials side by side."""

import gymnasium
import matplotlib.pyplot as plt
import numpy as np

from polydraulic.gym import follow_goal

ROUNDS, TRIALS, EPISODES, BEST, STEP, NOISE = 60, 32, 4, 16, 0.1, 0.2
env = gymnasium.make_vec("polydraulic/Reach-v0", num_envs=2 * TRIALS * EPISODES, machine="wheel_loader")
scale = np.array([0.5, 0.3, 0.5, 0.3] * 2 + [1.0] * 3)  # of travel, rate, spool, load of lift and tilt; m to the goal


def returns(policy, seeds):
    """What the first episode of each machine brings in all."""
    (seen, _), total, going = env.reset(seed=seeds), np.zeros(env.num_envs), np.ones(env.num_envs, dtype=bool)
    while going.any():
        seen, rewards, over, cut, _ = env.step(policy(seen))
        total, going = total + going * rewards, going & ~(over | cut)
    return total


def linear(weights):
    """A policy with weights (number of an observation and 1, function), or with a set of them for each machine."""
    return lambda seen: np.tanh((np.insert(seen / scale, 0, 1.0, axis=1)[:, None] @ weights)[:, 0])


rng, weights, curve = np.random.default_rng(0), np.zeros((len(scale) + 1, 2)), []
for k in range(ROUNDS):
    noise = rng.normal(size=(TRIALS, *weights.shape))
    tried = np.concatenate([weights + NOISE * noise, weights - NOISE * noise]).repeat(EPISODES, axis=0)
    seeds = np.tile(np.arange(EPISODES) + EPISODES * k, 2 * TRIALS).tolist()  # the same episodes for every trial
    up, down = returns(linear(tried), seeds).reshape(2, TRIALS, EPISODES).mean(axis=2)
    best = np.argsort(np.maximum(up, down))[-BEST:]
    gain = (up - down)[best] / np.concatenate([up[best], down[best]]).std()
    weights += STEP / BEST * np.einsum("t,tij->ij", gain, noise[best])
    curve.append(np.mean([up, down]))
unseen = list(range(10**6, 10**6 + env.num_envs))
none, learnt, known = (returns(p, unseen).mean() for p in (linear(0.0 * weights), linear(weights), follow_goal(env)))
print(f"return of an unseen episode: at rest {none:.2f}, learnt {learnt:.2f}, by the inverse Jacobian {known:.2f}")
plt.plot(curve, label="trials of each round")
for value, name in ((learnt, "learnt"), (known, "inverse Jacobian")):
    plt.axhline(value, linestyle="--" if name == "learnt" else ":", color="0.4", label=f"{name}, unseen episodes")
plt.legend(), plt.xlabel("round of 256 episodes"), plt.ylabel("mean return"), plt.savefig("learning.png")
assert learnt > none + 1.0
