"""Slopes of circuits that a crossover joins against central differences, at random states of all kinds."""

import numba
import numpy as np
import pytest

from helpers.crossover_made import N_FOUND, STATUS, put, random_states
from helpers.series_made import STATES
from polydraulic._kernel import driver
from polydraulic.machine.circuits.crossover.circuit import crossover_3, crossover_4
from polydraulic.machine.circuits.crossover.nodes import CrossoverOrifice
from polydraulic.machine.circuits.crossover.slopes import crossover_3_slopes, crossover_4_slopes
from polydraulic.machine.circuits.series.check import UNPROVED
from polydraulic.machine.valve import Orifices

PLAIN = bool(numba.config.DISABLE_JIT)
# of port pressures in Pa, and of spools, each of which changes its conductances by shares
STEP = np.array([100.0] * 4 + [1e-5] * 4)
FLOWS = [0, 1, 2, 3, 4, 6, 7, 10, 11]  # columns: inlets, crossover, to the tank and over relief


@driver
def four(k, d, p, gives, takes, found, slopes):
    """Conductances and slopes of crossover, inlets and bypasses in rows, the opening pressure behind those of the crossover."""
    cross = CrossoverOrifice(k[0, 0], k[0, 1])
    k_1, k_2, k_3, k_4 = (
        Orifices(k[1, 0], k[1, 1], 0.0), Orifices(k[2, 0], k[2, 1], 0.0),
        Orifices(k[3, 0], k[3, 1], 0.0), Orifices(k[4, 0], k[4, 1], 0.0),
    )  # fmt: skip
    d_1, d_2, d_3, d_4 = (
        Orifices(d[1, 0], d[1, 1], 0.0), Orifices(d[2, 0], d[2, 1], 0.0),
        Orifices(d[3, 0], d[3, 1], 0.0), Orifices(d[4, 0], d[4, 1], 0.0),
    )  # fmt: skip
    s = crossover_4(cross, k_1, k_2, k_3, k_4, p[0], p[1], p[2], p[3], gives, takes)
    put(s, found)
    found_slopes = crossover_4_slopes(cross, d[0, 0], k_1, k_2, k_3, k_4, d_1, d_2, d_3, d_4, s, gives, takes)
    for place, slope in enumerate(found_slopes):
        slopes[place] = slope


@driver
def three(k, d, p, gives, takes, slopes):
    """The same without the giving pump's second valve."""
    cross = CrossoverOrifice(k[0, 0], k[0, 1])
    k_1, k_3, k_4 = Orifices(k[1, 0], k[1, 1], 0.0), Orifices(k[3, 0], k[3, 1], 0.0), Orifices(k[4, 0], k[4, 1], 0.0)
    d_1, d_3, d_4 = Orifices(d[1, 0], d[1, 1], 0.0), Orifices(d[3, 0], d[3, 1], 0.0), Orifices(d[4, 0], d[4, 1], 0.0)
    s = crossover_3(cross, k_1, k_3, k_4, p[0], p[2], p[3], gives, takes)
    for place, slope in enumerate(crossover_3_slopes(cross, d[0, 0], k_1, k_3, k_4, d_1, d_3, d_4, s, gives, takes)):
        slopes[place] = slope


class At:
    """A state, of which ports and spools move; `shares` says by how much a spool changes each conductance."""

    def __init__(self, states, i, rng):
        crosses, inlets, bypasses, self.ports, self.gives, self.takes = states
        self.ports = self.ports[i]
        self.k = np.array([crosses[i], *zip(inlets[i], bypasses[i], strict=True)])
        self.d = np.abs(self.k) * rng.normal(size=self.k.shape)
        self.d[0, 1] = 0.0

    def found(self, moved=None):
        """Flows where ports and spools have moved, and slopes."""
        moved = np.zeros(8) if moved is None else moved
        k = self.k + self.d * moved[[7, 4, 5, 6, 7], None]  # the spool of the fourth valve opens the crossover
        found, slopes = np.empty(N_FOUND), np.empty(32)
        four(k, self.d, self.ports + moved[:4], self.gives, self.takes, found, slopes)
        return found, slopes

    def differences(self, step):
        """Slopes of flows over ports and spools by central differences, and whether all places have the flows of one kind."""
        both = [[self.found(side * move)[0] for side in (1.0, -1.0)] for move in np.diag(step)]
        kinds = {tuple(one[FLOWS] > 0.0) for pair in both for one in pair} | {tuple(self.found()[0][FLOWS] > 0.0)}
        limited = {(one[8] > self.gives.limit_start, one[12] > self.takes.limit_start) for pair in both for one in pair}
        slopes = [(up[:4] - down[:4]) / (2.0 * h) for (up, down), h in zip(both, step, strict=True)]
        return np.array(slopes).T, len(kinds) == 1 and len(limited) == 1


@pytest.mark.parametrize("exponent", [0.0, 1.0])
@pytest.mark.parametrize("kind", STATES)
def test_slopes_are_differences(machine, kind, exponent):
    size, compared, kinds, rng = 8 if PLAIN else 300, 0, set(), np.random.default_rng(1)
    states = random_states(machine, kind, exponent, size, 11)
    for i in range(size):
        at = At(states, i, rng)
        found, slopes = at.found()
        assert np.all(np.isfinite(slopes))
        coarse, smooth = at.differences(STEP)
        fine, _ = at.differences(0.5 * STEP)
        if not smooth or found[STATUS] == UNPROVED:
            continue
        # of the quotients: what rounding of flows makes of them, and what is left of higher orders
        doubt = 1e-13 * at.gives.flow / STEP + np.abs(coarse - fine)
        ours = slopes.reshape(2, 4, 4).transpose(1, 0, 2).reshape(4, 8)
        assert np.all(np.abs(ours - fine) <= 3.0 * doubt + 1e-6 * np.abs(fine))
        assert np.allclose(ours[:, :4], ours[:, :4].T, rtol=1e-9, atol=0.0)
        compared += int(np.sum(doubt < 1e-4 * np.abs(fine)))
        kinds.add(tuple(found[[0, 1, 2, 3, 4, 7, 11]] > 0.0))
    assert compared > (5 if PLAIN else 800)
    assert PLAIN or len(kinds) > 30


@pytest.mark.slow_to_compile
@pytest.mark.parametrize("kind", STATES)
def test_three_valves_are_four_of_which_one_is_not_there(machine, kind):
    size, rng = 5 if PLAIN else 100, np.random.default_rng(2)
    states = random_states(machine, kind, 1.0, size, 12)
    states.inlets[:, 1], states.bypasses[:, 1] = 0.0, 1e3
    for i in range(size):
        at, slopes = At(states, i, rng), np.empty(18)
        at.d[2] = 0.0
        three(at.k, at.d, at.ports, at.gives, at.takes, slopes)
        whole = at.found()[1].reshape(2, 4, 4)[:, [0, 2, 3]][:, :, [0, 2, 3]]
        assert np.allclose(slopes, whole.ravel(), rtol=1e-12, atol=0.0)
