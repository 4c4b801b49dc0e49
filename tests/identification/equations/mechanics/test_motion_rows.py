"""Rows of the equations of motion hold for motion that is known exactly."""

import numpy as np
import pytest

from helpers.machine_motion import motion_log
from polydraulic import load_machine, random_operator, simulate
from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.inertia import inertial_numbers, inertial_values
from polydraulic.identification.equations.mechanics.motion_rows import FRICTION, measured_pieces, motion_rows
from polydraulic.tables import Table

WIDTH = 0.08  # s


def truth_of(machine, late):
    friction = [getattr(f.friction, name) for f in machine.functions for name in FRICTION]
    return np.concatenate([inertial_values(machine, inertial_numbers(machine)), friction, [late]])


@pytest.mark.parametrize("late", [0.0, 0.004])
def test_rows_hold_with_the_true_numbers(late):
    machine = load_machine("loader_crane")
    pieces = measured_pieces(machine, motion_log(machine, late=late))
    rows = motion_rows(machine, inertial_numbers(machine), pieces, np.full(len(machine.names), WIDTH))
    off = np.where(rows.known, rows.regressor @ truth_of(machine, late) - rows.torque, 0.0)
    share = np.abs(off).max(axis=0) / np.abs(rows.torque).max(axis=0)
    assert rows.known.mean() > 0.2
    assert share.max() < 4e-3  # the filter acts on what is not linear, too
    without = np.where(rows.known, rows.regressor @ truth_of(machine, 0.0) - rows.torque, 0.0)
    assert late == 0.0 or np.abs(without).max() > 3.0 * np.abs(off).max()


def test_a_piece_lasts_as_long_as_a_refusal_says():
    machine = load_machine("loader_crane")
    widths = np.full(len(machine.names), WIDTH)
    log = motion_log(machine, seconds=3.0)
    enough, short = (Table({n: v[:rows] for n, v in log.columns.items()}, log.units) for rows in (84, 83))
    assert enough["time"][-1] - enough["time"][0] == pytest.approx(1.66)
    assert len(motion_rows(machine, inertial_numbers(machine), measured_pieces(machine, enough), widths).time)
    with pytest.raises(InputError, match=r"no piece of the log lasts 1.66 s without a gap; the mechanics cannot"):
        motion_rows(machine, inertial_numbers(machine), measured_pieces(machine, short), widths)


def test_each_equation_has_the_rows_of_its_own_weight_at_the_same_instants():
    machine = load_machine("loader_crane")
    numbers, n = inertial_numbers(machine), len(machine.names)
    pieces = measured_pieces(machine, motion_log(machine, seconds=20.0))
    short, long = 0.04, 0.12
    apart = motion_rows(machine, numbers, pieces, np.array([long] + (n - 1) * [short]))
    of_short, of_long = (motion_rows(machine, numbers, pieces, np.full(n, width)) for width in (short, long))
    for k, other in enumerate([of_long] + (n - 1) * [of_short]):
        pairs = [(i, j) for i, t in enumerate(apart.time) for j in np.flatnonzero(np.abs(other.time - t) < 1e-9)]
        assert len(pairs) > 100
        ours, theirs = np.transpose(pairs)
        scale = np.abs(other.regressor[:, k]).max(axis=0) + 1e-9
        assert np.allclose(apart.regressor[ours, k] / scale, other.regressor[theirs, k] / scale, rtol=0.0, atol=1e-9)
        assert np.allclose(apart.torque[ours, k], other.torque[theirs, k], rtol=1e-9)
        assert np.array_equal(apart.known[ours, k], other.known[theirs, k])


def test_rows_of_which_no_two_follow_each_other_are_refused():
    machine = load_machine("cat215b")
    log = motion_log(machine, seconds=2.0)
    pieces = measured_pieces(machine, Table(log.columns | {"segment": np.arange(len(log)) // 2}, log.units))
    single = [piece._replace(**{name: v[:1] for name, v in piece._asdict().items()}) for piece in pieces]
    with pytest.raises(InputError, match="no two rows of the log with positions and pressures of all functions follow"):
        motion_rows(machine, inertial_numbers(machine), single, np.full(3, WIDTH))


def test_friction_of_a_run_acts_half_a_step_late():
    machine, step = load_machine("cat215b_bucket"), 5e-3
    run = simulate(machine, "exact", random_operator(12, 60.0, functions=machine.names), dt=step, every=4)
    pieces, numbers = measured_pieces(machine, run), inertial_numbers(machine)
    widths = np.array([0.08, 0.08, 0.08, 0.04])
    truth, off = truth_of(machine, step), {}
    for own in (0.0, step):
        rows = motion_rows(machine, numbers, pieces, widths, own)
        left = (rows.regressor @ truth - rows.torque)[:, -1]
        off[own] = np.sqrt(np.mean(left[rows.known[:, -1]] ** 2))
    assert off[step] < 0.8 * off[0.0]  # what else is left comes of the filter, and is the same
