"""A hundred booms of different mass side by side: what spread of pressure is to be expected?"""

import numpy as np

from polydraulic import load_machine, simulate, simulate_batch

machine = load_machine("cat215b")
masses = machine.link("boom").mass * np.random.default_rng(0).uniform(0.8, 1.2, 100)
loaded = [machine.with_values({"links.boom.mass": mass}) for mass in masses]  # kg; values are SI
batch = simulate_batch(loaded, "exact", "single_08", t_end=2.0, keep=["range"], columns=["boom.angle", "boom.p_a"])
highest = batch.highest[:, batch.place("boom.p_a")]
print(f"highest head pressures: {highest.min() / 1e5:.0f} to {highest.max() / 1e5:.0f} bar")

# a batch is not an approximation: each machine ends where `simulate` alone would end, to the last bit
alone = simulate(loaded[7], "exact", "single_08", t_end=2.0)
assert batch.final[7, batch.place("boom.angle")] == alone["boom.angle"][-1]
assert np.corrcoef(masses, highest)[0, 1] > 0.9  # the heavier, the more pressure
