"""Rows of noisy positions and pressures are as sure as they say, and pull towards the truth."""

import numpy as np
import pytest

from helpers.machine_motion import motion_log
from polydraulic import load_machine
from polydraulic.identification.equations.mechanics import noisy_motion
from polydraulic.identification.equations.mechanics.base_parameters import base_parameters
from polydraulic.identification.equations.mechanics.inertia import inertial_values
from polydraulic.identification.equations.mechanics.motion_rows import FRICTION, measured_pieces
from polydraulic.identification.equations.mechanics.noisy_motion import NoisyMotion
from polydraulic.identification.equations.mechanics.weight_widths import sensor_noise
from polydraulic.tables import Table

LATE = 0.007  # s


def truth_of(machine):
    base = base_parameters(machine)
    friction = [getattr(f.friction, name) for f in machine.functions for name in FRICTION]
    return np.concatenate([base.combine @ inertial_values(machine, base.numbers), friction, [LATE]])


def motion_of(machine, noise, seed=0, log=None, late=LATE):
    base = base_parameters(machine)
    pieces = measured_pieces(machine, log or motion_log(machine, seconds=60.0, late=LATE, noise=noise, seed=seed))
    own = inertial_values(machine, base.numbers)
    return NoisyMotion(machine, base, own, pieces, sensor_noise(pieces), late, 0.0)


@pytest.mark.parametrize("at", [0.0, -0.25, 0.5])
def test_stencils_are_exact_for_quartics(at):
    rng = np.random.default_rng(0)
    curve = np.polynomial.Polynomial(rng.normal(size=5))
    made = noisy_motion._stencil(at) @ curve(np.arange(-2.0, 3.0))
    assert made == pytest.approx([curve(at), curve.deriv()(at), curve.deriv(2)(at)])


def test_what_is_left_at_the_truth_is_what_noise_makes_and_pulls_no_further_than_that():
    machine = load_machine("wheel_loader")
    truth, errors, spreads = truth_of(machine), [], []
    for seed in range(4):
        motion = motion_of(machine, 1.0, seed)
        for _ in range(2):
            information, pull = (of.sum(0) for of in motion.rows_at(truth))
        shown = np.diagonal(information) > 0.0
        scale = np.sqrt(np.diagonal(information)[shown])
        values, vectors = np.linalg.eigh(information[np.ix_(shown, shown)] / np.outer(scale, scale))
        errors.append((vectors.T @ (pull[shown] / scale))[values > 1e-6] / np.sqrt(values[values > 1e-6]))
        spreads.append(motion.spread)
    assert np.mean(spreads) == pytest.approx(1.0, abs=0.1)
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(1.0, abs=0.25)  # of standard normal numbers
    assert np.abs(np.mean(errors, axis=0)).max() < 3.0 / np.sqrt(len(errors))


def test_rows_near_stops_rest_and_blows_are_left_out():
    machine = load_machine("wheel_loader")
    log = motion_log(machine, seconds=20.0)
    name, stop = f"{machine.names[1]}.angle", machine.functions[1].stops.high
    struck = np.minimum(log[name] - log[name][400] + stop, stop)  # is at its stop in row 400
    (chunk,) = motion_of(machine, 0.0, log=Table({**log.columns, name: struck}, log.units), late=0.0).chunks
    rate = np.diff(struck) / 0.02
    blows = np.flatnonzero((np.abs(rate[:-1]) > 0.02) & (rate[1:] == 0.0)) + 1
    assert len(blows)
    for blow in blows:
        assert not chunk.known[blow - 4 : blow + 1].any()
    assert chunk.known[:, 0].mean() > 0.3
    assert not chunk.known[struck[2:-2] == stop, 1].any()
    slow = (
        np.abs(np.gradient(log[f"{machine.names[0]}.angle"], 0.02)[2:-2]) < 0.9 * machine.functions[0].friction.stribeck
    )
    assert slow.any()
    assert not chunk.known[slow, 0].any()


def test_it_makes_no_difference_where_a_log_is_cut(monkeypatch):
    machine = load_machine("wheel_loader")
    truth = truth_of(machine)
    whole, pull = (of.sum(0) for of in motion_of(machine, 1.0).rows_at(truth))
    monkeypatch.setattr(noisy_motion, "_CHUNK", 1000)
    cut, pull_of_cut = (of.sum(0) for of in motion_of(machine, 1.0).rows_at(truth))
    scale = np.sqrt(np.diagonal(whole)) + 1e-300
    assert np.diagonal(cut) / scale**2 == pytest.approx(np.ones(len(scale)), abs=0.04)
    assert (pull_of_cut - pull) / scale == pytest.approx(np.zeros(len(scale)), abs=0.5)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6])
def test_a_few_rows_at_the_end_of_a_piece_have_the_covariance_that_their_slopes_make(count):
    rng = np.random.default_rng(0)
    of_motion, own = rng.normal(size=(count, 2, 5, 3)), rng.uniform(1.0, 2.0, size=(count, 2))
    over_positions = np.zeros((count, 2, count + 4, 3))
    for row in range(count):
        over_positions[row, :, row : row + 5] = of_motion[row]
    flat = over_positions.reshape(2 * count, -1)
    whole = flat @ flat.T + np.diag(own.ravel())
    band = noisy_motion._covariance(of_motion, own)
    for below, diagonal in enumerate(band[: 2 * count]):
        assert diagonal[: 2 * count - below] == pytest.approx(np.diagonal(whole, -below))


def test_the_last_chunk_of_a_piece_may_have_any_number_of_rows(monkeypatch):
    machine = load_machine("wheel_loader")
    log, truth = motion_log(machine, seconds=20.0, noise=1.0), truth_of(machine)
    for last in range(1, 8):
        monkeypatch.setattr(noisy_motion, "_CHUNK", len(log) - 4 - last)
        motion = motion_of(machine, 1.0, log=log, late=0.0)
        assert len(motion.chunks[1].known) == last
        assert np.isfinite(motion.rows_at(truth).gram).all()


@pytest.mark.parametrize("rows", range(5, 13))
def test_a_piece_may_have_any_number_of_rows(rows):
    machine = load_machine("wheel_loader")
    log = motion_log(machine, seconds=20.0, noise=1.0)
    after = np.arange(len(log)) >= len(log) - rows
    motion = motion_of(
        machine,
        1.0,
        log=Table({**log.columns, "segment": after.astype(float)}, {**log.units, "segment": "1"}),
        late=0.0,
    )
    assert [len(chunk.known) for chunk in motion.chunks] == [len(log) - rows - 4, *([rows - 4] if rows > 8 else [])]
    assert np.isfinite(motion.rows_at(truth_of(machine)).gram).all()


def test_a_load_for_a_while_loosens_its_rows():
    machine = load_machine("wheel_loader")
    log = motion_log(machine, seconds=60.0, noise=1.0)
    pressure = f"{machine.names[0]}.p_a"
    pushed = log[pressure] + 2e6 * ((log["time"] > 20.0) & (log["time"] < 22.0))
    motion = motion_of(machine, 1.0, log=Table({**log.columns, pressure: pushed}, log.units), late=0.0)
    for _ in range(2):
        motion.rows_at(np.append(truth_of(machine)[:-1], 0.0))
    (chunk,) = motion.chunks
    during = (log["time"][2:-2] > 20.3) & (log["time"][2:-2] < 21.7) & chunk.known[:, 0]
    assert during.any()
    assert chunk.looser[during, 0].min() > 3.0 * np.median(chunk.looser[:, 0])
