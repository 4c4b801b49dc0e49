"""What noise pulls is found from the noise itself."""

import numpy as np
import pytest

from helpers.machine_motion import motion_log
from polydraulic import load_machine
from polydraulic.identification.equations.mechanics.inertia import inertial_numbers, inertial_values
from polydraulic.identification.equations.mechanics.motion_rows import FRICTION, measured_pieces, motion_rows
from polydraulic.identification.equations.mechanics.noise_bias import noise_pull

NOISE, LOGS = 4.0, 4


def test_the_pull_is_what_noise_makes_of_the_gradient_at_the_truth():
    machine = load_machine("wheel_loader")
    numbers = inertial_numbers(machine)
    truth = np.array(
        [
            *inertial_values(machine, numbers),
            *(getattr(f.friction, k) for f in machine.functions for k in FRICTION),
            0.0,
        ]
    )
    clean = measured_pieces(machine, motion_log(machine, seconds=30.0))

    def rows_of(pieces):
        return motion_rows(machine, numbers, pieces, np.full(len(machine.names), 0.08))

    still = rows_of(clean)
    weight = still.known / np.square(still.torque.std(axis=0))
    length = np.sqrt(np.einsum("tkc,tk,tkc->c", still.regressor, weight, still.regressor)) + 1e-300

    def gradient(pieces):
        rows = rows_of(pieces)
        return np.einsum("tkc,tk->c", rows.regressor, weight * (rows.torque - rows.regressor @ truth)) / length

    without, made, told = gradient(clean), [], []
    for seed in range(LOGS):
        rng = np.random.default_rng(seed)
        noise = [NOISE * 5e-4 * rng.normal(size=p.position.shape) for p in clean]
        for way in (1.0, -1.0):  # the first order is none of the pull
            pieces = [p._replace(position=p.position + way * n) for p, n in zip(clean, noise, strict=True)]
            here = gradient(pieces)
            made.append(here - without)
            told.append(noise_pull(rows_of, pieces, weight, truth).gradient / length - here)
    own, said = (
        np.mean(of, axis=0)[: len(numbers)] for of in (made, told)
    )  # friction near rest is no matter of small noise
    assert own @ said / (said @ said) == pytest.approx(1.0, abs=0.2)
    assert own @ said / np.sqrt(own @ own * (said @ said)) > 0.97
    assert np.abs(own).max() > 20.0 * np.abs(without[: len(numbers)]).max()
