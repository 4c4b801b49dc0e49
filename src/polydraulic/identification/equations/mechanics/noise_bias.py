"""How far noise of sensors pulls the regression of masses and friction, found by adding as much noise once more.

A filtered position stands on both sides of the equations of motion, so that its noise does not average out: it makes motion look larger than it
is, and what is multiplied by it smaller. To second order the noise of the log pulls as a second helping of it does (simulation-extrapolation,
Cook and Stefanski, J. Am. Stat. Assoc. 89 (1994) 1314). Noise is added and subtracted in turn, so that its own first order cancels.
"""

from collections.abc import Sequence

import numpy as np

from polydraulic.identification.equations.mechanics.inertia import Inertial
from polydraulic.identification.equations.mechanics.motion_rows import Piece, motion_rows
from polydraulic.identification.equations.noise import noise_level
from polydraulic.parameters.layout.schema import LayoutMachine


def sensor_noise(pieces: Sequence[Piece]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Standard deviations of positions and of pressures at A and B, (n_function,) each."""
    segment = np.repeat(np.arange(len(pieces)), [len(piece.time) for piece in pieces])
    whole = (np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("position", "p_a", "p_b"))
    position, p_a, p_b = (np.array([noise_level(column, segment) for column in values.T]) for values in whole)
    return position, p_a, p_b


def noise_pull(
    machine: LayoutMachine, numbers: Sequence[Inertial], pieces: Sequence[Piece], weight: np.ndarray, at: np.ndarray
) -> np.ndarray:
    """Gradient that noise alone makes of the weighted squares, (n,): what it adds to regressor^T weight (torque - regressor @ at).

    Parameters
    ----------
    machine, numbers, pieces
        As `motion_rows` takes them.
    weight : (n_instant, n_function) array
        Of the rows that it makes of these pieces.
    at : (n,) array
        Solution of the normal equations of these rows.
    """
    rng, levels, found = np.random.default_rng(0), sensor_noise(pieces), np.zeros(len(at))
    more = [[level * rng.normal(size=piece.position.shape) for level in levels] for piece in pieces]
    for way in (1.0, -1.0):
        noisy = [
            Piece(piece.time, *(v + way * n for v, n in zip(piece[1:], own, strict=True)))
            for piece, own in zip(pieces, more, strict=True)
        ]
        rows = motion_rows(machine, numbers, noisy)
        found += np.einsum("tkc,tk->c", rows.regressor, weight * (rows.torque - rows.regressor @ at))
    return found / 2.0
