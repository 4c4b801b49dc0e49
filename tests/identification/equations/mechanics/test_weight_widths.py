"""Weights are as wide as noise of positions asks for."""

import numpy as np
import pytest

from helpers.machine_motion import motion_log
from polydraulic import load_machine
from polydraulic.identification.equations.mechanics.inertia import inertial_numbers
from polydraulic.identification.equations.mechanics.motion_rows import measured_pieces
from polydraulic.identification.equations.mechanics.weight_widths import sensor_noise, weight_widths


def test_sensors_are_as_noisy_as_they_are():
    machine = load_machine("wheel_loader")
    position, p_a, p_b = sensor_noise(measured_pieces(machine, motion_log(machine, seconds=40.0, noise=2.0)))
    assert position == pytest.approx(1e-3, rel=0.1)
    assert np.concatenate([p_a, p_b]) == pytest.approx(2e5, rel=0.1)


def with_noise(pieces, of_position, of_pressure):
    rng = np.random.default_rng(0)
    return [
        piece._replace(
            position=piece.position + of_position * rng.normal(size=piece.position.shape),
            p_a=piece.p_a + of_pressure * rng.normal(size=piece.p_a.shape),
            p_b=piece.p_b + of_pressure * rng.normal(size=piece.p_b.shape),
        )
        for piece in pieces
    ]


def test_what_is_light_gets_a_shorter_weight():
    machine = load_machine("cat215b_bucket")
    pieces = with_noise(measured_pieces(machine, motion_log(machine, seconds=20.0)), 5e-4, 1e5)
    widths = weight_widths(machine, inertial_numbers(machine), pieces)
    assert list(np.argsort(widths)) == [3, 2, 1, 0]  # bucket, stick, boom, swing
    assert 0.03 <= widths.min() < 0.05
    assert widths.max() == 0.15


def test_four_times_the_noise_of_positions_takes_twice_the_width():
    machine = load_machine("cat215b_bucket")
    numbers, clean = inertial_numbers(machine), measured_pieces(machine, motion_log(machine, seconds=20.0))
    once, more, pressed = (
        weight_widths(machine, numbers, with_noise(clean, of_position, of_pressure))[3]
        for of_position, of_pressure in ((1e-3, 1e5), (4e-3, 1e5), (4e-3, 4e5))
    )
    assert more == pytest.approx(2.0 * once, rel=0.1)
    assert pressed == pytest.approx(once, rel=0.1)
