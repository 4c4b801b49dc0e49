"""A log whose torques do not go with its motion is refused, with what mends it."""

import numpy as np
import pytest

from helpers.machine_motion import motion_log
from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.fit import fit_mechanics
from polydraulic.identification.equations.mechanics.inertia import inertial_numbers, inertial_values
from polydraulic.identification.equations.mechanics.motion_rows import FRICTION, measured_pieces, motion_rows
from polydraulic.identification.equations.mechanics.torque_check import torque_agreement
from polydraulic.tables import Table


@pytest.fixture(scope="module")
def machine():
    return load_machine("cat215b")


@pytest.fixture(scope="module")
def log(machine):
    return motion_log(machine, seconds=20.0, noise=1.0)


def scaled(log, factors):
    return Table({n: v * factors.get(n, 1.0) for n, v in log.columns.items()}, log.units)


def test_torques_of_a_right_log_go_with_those_of_a_file_whose_masses_are_half_off(machine, log):
    numbers = inertial_numbers(machine)
    rows = motion_rows(machine, numbers, measured_pieces(machine, log), np.full(3, 0.08))
    friction = np.array([getattr(f.friction, name) for f in machine.functions for name in FRICTION])
    truth = np.concatenate([inertial_values(machine, numbers), friction, [0.0]])
    exact = torque_agreement(rows, truth)
    assert exact.factor == pytest.approx(np.ones(3), abs=0.05)
    assert exact.correlation.min() > 0.98
    for seed in range(10):
        off = truth * np.exp(0.5 * np.random.default_rng(seed).normal(size=len(truth)))
        assert torque_agreement(rows, off).goes.all()


@pytest.mark.parametrize("name", ["boom", "stick"])
def test_exchanged_ports_are_named(machine, log, name):
    columns = dict(log.columns)
    columns[f"{name}.p_a"], columns[f"{name}.p_b"] = columns[f"{name}.p_b"], columns[f"{name}.p_a"]
    with pytest.raises(InputError, match=rf"at {name} \(.*: they go together where {name}.p_a and {name}.p_b are exch"):
        fit_mechanics(Table(columns, log.units), machine)


def test_a_turned_sign_is_named(machine, log):
    with pytest.raises(InputError, match="or the sign of swing.angle is turned; mend that where the log is imported"):
        fit_mechanics(scaled(log, {"swing.angle": -1.0}), machine)
    with pytest.raises(InputError, match="torques of the oil do not go with motion.*the sign of boom.angle is turned"):
        fit_mechanics(scaled(log, {"boom.angle": -1.0}), machine)


@pytest.mark.parametrize("factor", [0.1, 10.0])
def test_pressures_in_another_unit_are_named(machine, log, factor):
    said = f"{factor:.2g}".replace(".", r"\.")
    with pytest.raises(
        InputError, match=rf"at boom are {said[:3]}.* times those that masses.*boom.p_a and boom.p_b must"
    ):
        fit_mechanics(scaled(log, {"boom.p_a": factor, "boom.p_b": factor}), machine)


def test_a_single_port_in_another_unit_is_no_exchange(machine, log):
    with pytest.raises(InputError, match="at boom .*: look at the signs of positions, at ports that are exchanged"):
        fit_mechanics(scaled(log, {"boom.p_a": 0.1}), machine)
