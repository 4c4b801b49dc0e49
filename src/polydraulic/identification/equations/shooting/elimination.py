"""States at the start of windows, eliminated window by window: what is left is a small system over the numbers."""

from typing import NamedTuple

import numpy as np


class Linearised(NamedTuple):
    """Windows as they are linear around some numbers and states.

    Attributes
    ----------
    states : (n_window, n_state) array
        At the start of windows.
    off : (n_window, m) array
        Residuals over noise.
    over_numbers, over_states : (n_window, m, n) and (n_window, m, n_state) array
        Slopes of the residuals.
    """

    states: np.ndarray
    off: np.ndarray
    over_numbers: np.ndarray
    over_states: np.ndarray


class Reduced(NamedTuple):
    """Windows without their states.

    Attributes
    ----------
    gram : (n_window, n, n) array
        Of the numbers.
    gradient : (n_window, n) array
        Half that of the squares, priors of states among them.
    to_numbers : (n_window, n_state, n) array
        What is to be subtracted from the states for a step of each number.
    own : (n_window, n_state) array
        What is to be subtracted from them besides.
    """

    gram: np.ndarray
    gradient: np.ndarray
    to_numbers: np.ndarray
    own: np.ndarray


def without_states(here: Linearised, weight: np.ndarray, begun: np.ndarray, state_spread: np.ndarray) -> Reduced:
    """Eliminate the states of each window.

    Parameters
    ----------
    here : Linearised
    weight : (n_window, m) array
        Of squares of residuals.
    begun : (n_window, n_state) array
        States less the means of their priors.
    state_spread : (n_state,) array
        Standard deviations of these.
    """
    a, b = here.over_numbers, here.over_states
    wa, wb = a * weight[..., None], b * weight[..., None]
    inner = np.swapaxes(b, 1, 2) @ wb + np.diag(1.0 / state_spread**2)
    cross = np.swapaxes(b, 1, 2) @ wa
    pull = np.einsum("wms,wm->ws", wb, here.off) + begun / state_spread**2
    scale = np.sqrt(np.einsum("wss->ws", inner))
    solved = np.linalg.solve(
        inner / (scale[:, :, None] * scale[:, None, :]),
        np.concatenate([cross, pull[..., None]], axis=2) / scale[..., None],
    )
    solved = solved / scale[..., None]
    to_numbers, own = solved[..., :-1], solved[..., -1]
    gram = np.swapaxes(a, 1, 2) @ wa - np.swapaxes(cross, 1, 2) @ to_numbers
    gradient = np.einsum("wmn,wm->wn", wa, here.off) - np.einsum("wsn,ws->wn", cross, own)
    return Reduced(gram, gradient, to_numbers, own)
