"""How far noise of sensors pulls the regression of masses and friction, found by adding as much noise once more.

A filtered position stands on both sides of the equations of motion, so that its noise does not average out: it makes motion look larger than it
is, and what is multiplied by it smaller. To second order the noise of the log pulls as a second helping of it does (simulation-extrapolation,
Cook and Stefanski, J. Am. Stat. Assoc. 89 (1994) 1314). Noise is added and subtracted in turn, so that its own first order cancels.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.mechanics.motion_rows import MotionRows, Piece
from polydraulic.identification.equations.mechanics.weight_widths import sensor_noise
from polydraulic.identification.noise import robust_deviation


class NoisePull(NamedTuple):
    """What noise of sensors does to a regression.

    Attributes
    ----------
    gradient : (n,) array
        That it makes of the weighted squares: what it adds to regressor^T weight (torque - regressor @ at).
    deviation : (n_function,) array
        Robust standard deviation of what it makes of each function's rows.
    """

    gradient: np.ndarray
    deviation: np.ndarray


def noise_pull(
    rows_of: Callable[[Sequence[Piece]], MotionRows], pieces: Sequence[Piece], weight: np.ndarray, at: np.ndarray
) -> NoisePull:
    """What noise alone does to a regression.

    Parameters
    ----------
    rows_of : function (sequence of Piece) -> MotionRows
    pieces : sequence of Piece
    weight : (n_instant, n_function) array
        Of the rows that it makes of these pieces.
    at : (n,) array
        Solution of the normal equations of these rows.
    """
    rng, levels, found, made = np.random.default_rng(0), sensor_noise(pieces), np.zeros(len(at)), np.zeros(weight.shape)
    more = [[level * rng.normal(size=piece.position.shape) for level in levels] for piece in pieces]
    for way in (1.0, -1.0):
        noisy = [
            Piece(piece.time, *(v + way * n for v, n in zip(piece[1:], own, strict=True)))
            for piece, own in zip(pieces, more, strict=True)
        ]
        rows = rows_of(noisy)
        left = rows.torque - rows.regressor @ at
        found += np.einsum("tkc,tk->c", rows.regressor, weight * left)
        made += way * left
    own = [robust_deviation(column[of > 0.0]) for column, of in zip(made.T, weight.T, strict=True)]
    return NoisePull(found / 2.0, np.array(own) / 2.0)
