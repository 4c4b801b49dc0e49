"""How wide the weight of each equation of motion is: as wide as noise of positions outweighs that of pressures.

Noise of pressures is white in the torque of the oil. That of positions is multiplied by inertia and the square of the frequency, so that it is
larger from the frequency on at which both are one: rows should pass what is slower, and nothing else. A bucket, whose own inertia shows only in
fast motion, so gets a short weight, and a swing, which carries the whole arm, a long one.
"""

from collections.abc import Sequence

import numpy as np

from polydraulic.identification.equations.mechanics.inertia import Inertial, inertial_values, torque_regressor
from polydraulic.identification.equations.mechanics.motion_rows import Piece, oil_torques
from polydraulic.identification.noise import noise_of_pieces
from polydraulic.parameters.layout.schema import LayoutMachine

# s: a shorter weight does not join enough samples, and a longer one leaves few rows in which a joint moves all the while
_SHORTEST, _LONGEST = 0.03, 0.15
_HALF = float(
    np.sqrt(np.log(2.0))
)  # width of a Gaussian filter times the frequency at which it passes half of the power
_POSES = 100


def sensor_noise(pieces: Sequence[Piece]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Standard deviations of noise of positions, rad or m, and of pressures at A and B, Pa, (n_function,) each."""
    functions = range(pieces[0].position.shape[1])
    position, p_a, p_b = (
        np.array([noise_of_pieces([getattr(piece, name)[:, k] for piece in pieces]) for k in functions])
        for name in ("position", "p_a", "p_b")
    )
    return position, p_a, p_b


def weight_widths(machine: LayoutMachine, numbers: Sequence[Inertial], pieces: Sequence[Piece]) -> np.ndarray:
    """Widths for `motion_rows`, (n_function,) in s, by the machine's inertia as far as it is known.

    Parameters
    ----------
    machine : LayoutMachine
    numbers : sequence of Inertial
        All that it has.
    pieces : sequence of Piece
        Of a log with at least one row.
    """
    position = np.concatenate([piece.position for piece in pieces])
    position = position[:: max(1, len(position) // _POSES)]
    noise, *of_pressures = sensor_noise(pieces)
    none, still = np.zeros_like(position), np.zeros(position.shape[1])
    oil = sum(
        np.mean(oil_torques(machine, position, none + a, none + b) ** 2, axis=0)
        for a, b in ((of_pressures[0], still), (still, of_pressures[1]))
    )
    values, moved = inertial_values(machine, numbers), np.zeros(len(noise))
    for k, level in enumerate(noise):
        once = np.zeros_like(position)
        once[:, k] = level
        moved += np.mean((torque_regressor(machine, numbers, position, none, once, 0.0) @ values) ** 2, axis=0)
    ratio = np.sqrt(np.sqrt(moved / np.maximum(oil, np.finfo(float).tiny)))  # s, of the frequency at which both are one
    return np.clip(_HALF * ratio, _SHORTEST, _LONGEST)
