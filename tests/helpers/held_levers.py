"""Levers that stand still during each step, as an array and as the scenario that `simulate` takes."""

from dataclasses import dataclass, field

import numpy as np

from polydraulic.parameters.loads import Loads
from polydraulic.parameters.scenario import Scenario


@dataclass(frozen=True)
class Held:
    """A signal that is constant over each step."""

    values: np.ndarray = field(repr=False)
    dt: float

    @property
    def voltage(self) -> float:
        """Largest to either side."""
        return float(np.abs(self.values).max())

    def __call__(self, t):
        """Volts at the times `t`, the first value before."""
        return self.values[np.clip(np.floor(t / self.dt + 1e-6).astype(int), 0, len(self.values) - 1)]


def random_levers(seed, n_step, n_function, *, each=9, limit=0.7):
    """Voltages of steps, (n_step, n_function) V, that change every so many of them."""
    rng = np.random.default_rng(seed)
    return np.repeat(rng.uniform(-limit, limit, (n_step // each + 1, n_function)), each, axis=0)[:n_step]


def held_scenario(machine, levers, dt, *, locked=(), load=None):
    """The scenario in which these levers are moved."""
    signals = {name: Held(levers[:, place], dt) for place, name in enumerate(machine.names) if name not in locked}
    return Scenario("held", len(levers) * dt, signals, tuple(locked), loads=load or Loads())


def random_split(rng, n):
    """Whole numbers, at least 1, that sum up to n."""
    found = []
    while n:
        found.append(int(rng.integers(1, min(n, 12) + 1)))
        n -= found[-1]
    return found
