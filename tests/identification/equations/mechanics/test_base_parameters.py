"""Base parameters hold all that a motion can tell of masses."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.identification.equations.mechanics.base_parameters import base_parameters, combined
from polydraulic.identification.equations.mechanics.inertia import Inertial, inertial_values, torque_regressor


@pytest.mark.parametrize("name", ["loader_crane", "cat215b_bucket"])
def test_machines_with_the_same_base_parameters_need_the_same_torques(name):
    machine, rng = load_machine(name), np.random.default_rng(1)
    base = base_parameters(machine)
    values = inertial_values(machine, base.numbers)
    hidden = np.linalg.svd(base.combine)[2][len(base.combine) :]  # directions that no base parameter sees
    others = values + rng.normal(size=len(hidden)) @ hidden * np.abs(values).max()
    n = len(machine.names)
    regressor = torque_regressor(machine, base.numbers, *rng.normal(size=(3, 30, n)), machine.gravity)
    needed, same = regressor @ values, regressor @ others
    assert not np.allclose(values, others)
    assert np.allclose(needed, same, rtol=0.0, atol=1e-6 * np.abs(needed).max())


def test_what_no_motion_shows_is_in_no_base_parameter():
    base = base_parameters(load_machine("loader_crane"))
    assert not any("column mass" in text or "column h.z" in text for text in base.texts)
    assert "extension mass + grapple mass" in base.texts


def test_dependent_columns_are_added_to_those_that_are_kept():
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(2, 50))
    base = combined(
        [Inertial("a", "mass"), Inertial("b", "mass"), Inertial("c", "mass")], np.column_stack([a, b, 2.0 * b])
    )
    assert len(base.texts) == 2
    assert np.allclose(base.combine @ [1.0, 1.0, 1.0], [1.0, 1.5]) or np.allclose(
        base.combine @ [1.0, 1.0, 1.0], [1.0, 3.0]
    )
