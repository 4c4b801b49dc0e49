"""Rows of the equations of motion hold for motion that is known exactly."""

import numpy as np
import pytest

from helpers.machine_motion import motion_log
from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.inertia import inertial_numbers, inertial_values
from polydraulic.identification.equations.mechanics.motion_rows import FRICTION, measured_pieces, motion_rows
from polydraulic.tables import Table


def truth_of(machine, late):
    friction = [getattr(f.friction, name) for f in machine.functions for name in FRICTION]
    return np.concatenate([inertial_values(machine, inertial_numbers(machine)), friction, [late]])


@pytest.mark.parametrize("late", [0.0, 0.004])
def test_rows_hold_with_the_true_numbers(late):
    machine = load_machine("loader_crane")
    rows = motion_rows(machine, inertial_numbers(machine), measured_pieces(machine, motion_log(machine, late=late)))
    off = np.where(rows.known, rows.regressor @ truth_of(machine, late) - rows.torque, 0.0)
    share = np.abs(off).max(axis=0) / np.abs(rows.torque).max(axis=0)
    assert rows.known.mean() > 0.2
    assert share.max() < 4e-3  # the filter acts on what is not linear, too
    without = np.where(rows.known, rows.regressor @ truth_of(machine, 0.0) - rows.torque, 0.0)
    assert late == 0.0 or np.abs(without).max() > 3.0 * np.abs(off).max()


def test_a_piece_lasts_as_long_as_a_refusal_says():
    machine = load_machine("loader_crane")
    log = motion_log(machine, seconds=3.0)
    enough, short = (Table({n: v[:rows] for n, v in log.columns.items()}, log.units) for rows in (104, 103))
    assert enough["time"][-1] - enough["time"][0] == pytest.approx(2.06)
    assert len(motion_rows(machine, inertial_numbers(machine), measured_pieces(machine, enough)).time)
    with pytest.raises(InputError, match=r"no piece of the log lasts 2.06 s without a gap; the mechanics cannot"):
        motion_rows(machine, inertial_numbers(machine), measured_pieces(machine, short))
