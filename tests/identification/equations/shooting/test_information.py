"""Information of channels against the covariance of the whole linear problem."""

import numpy as np

from polydraulic.identification.equations.shooting.information import (
    channel_information,
    information_of,
    left_unsure,
)
from polydraulic.identification.equations.shooting.runs import Slopes


def test_states_are_eliminated_as_in_the_whole_problem():
    rng = np.random.default_rng(3)
    windows, rows, channels, n, states = 3, 7, 2, 2, 4
    slopes = Slopes(rng.normal(size=(windows, rows, channels, n)), rng.normal(size=(windows, rows, channels, states)))
    noise, state_spread, spread = np.array([0.5, 2.0]), np.array([0.1, 1.0, 2.0, 5.0]), np.array([0.3, 0.7])
    found = channel_information(slopes, noise, state_spread)
    for chosen in ([0], [1], [0, 1]):
        whole = np.zeros((windows * rows * len(chosen), n + windows * states))
        row = 0
        for w in range(windows):
            for r in range(rows):
                for c in chosen:
                    whole[row, :n] = slopes.numbers[w, r, c] / noise[c]
                    whole[row, n + w * states : n + (w + 1) * states] = slopes.states[w, r, c] / noise[c]
                    row += 1
        prior = np.concatenate([spread, np.tile(state_spread, windows)]) ** -2
        covariance = np.linalg.inv(whole.T @ whole + np.diag(prior))[:n, :n]
        assert np.allclose(left_unsure(information_of(found, chosen), spread), np.sqrt(np.diag(covariance)) / spread)
    assert np.array_equal(left_unsure(np.zeros((2, 2)), spread), [1.0, 1.0])
