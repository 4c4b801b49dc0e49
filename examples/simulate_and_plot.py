"""Simulate pick and place and draw it; every drop that a pump gives goes somewhere."""

import numpy as np

from polydraulic import simulate
from polydraulic.plotting import plot_run

run = simulate("cat215b", "exact", "task")
plot_run({"exact": run}).savefig("task.png", dpi=80)
for time, link, what in run.info["events"][:5]:
    print(f"{time:.3f} s  {link}  {what}")

# what the boom's pump gives is what the actuator takes, what the bypass and what the relief valve let through
balance = run["boom.q_pump"] - run["boom.q_in"] - run["boom.q_bypass"] - run["boom.q_relief"]
assert np.abs(balance).max() < 1e-9 * run["boom.q_pump"].max()
