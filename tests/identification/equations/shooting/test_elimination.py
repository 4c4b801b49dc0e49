"""Windows without their states, against the whole system."""

import numpy as np

from polydraulic.identification.equations.shooting.elimination import Linearised, without_states


def test_numbers_and_states_move_as_in_the_whole_system():
    rng = np.random.default_rng(4)
    windows, m, n, states = 3, 9, 2, 4
    here = Linearised(*(rng.normal(size=(windows, *shape)) for shape in ((states,), (m,), (m, n), (m, states))))
    weight, begun = rng.uniform(0.2, 1.0, (windows, m)), rng.normal(size=(windows, states))
    spread = np.array([0.1, 1.0, 2.0, 5.0])
    found = without_states(here, weight, begun, spread)
    size = n + windows * states
    gram, gradient = np.zeros((size, size)), np.zeros(size)
    for w in range(windows):
        own = slice(n + w * states, n + (w + 1) * states)
        slopes = np.zeros((m, size))
        slopes[:, :n], slopes[:, own] = here.over_numbers[w], here.over_states[w]
        gram += slopes.T @ (weight[w][:, None] * slopes)
        gradient += slopes.T @ (weight[w] * here.off[w])
        gram[own, own] += np.diag(spread**-2)
        gradient[own] += begun[w] / spread**2
    step = np.linalg.solve(gram, gradient)
    assert np.allclose(np.linalg.solve(found.gram.sum(0), found.gradient.sum(0)), step[:n])
    assert np.allclose(found.own - found.to_numbers @ step[:n], step[n:].reshape(windows, states))
