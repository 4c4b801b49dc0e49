"""Lift capacity against statics that are computed another way: weights in MuJoCo, forces of cylinders from their pins."""

from math import pi

import numpy as np
import pytest

from helpers.statics import Statics, lever_of
from polydraulic import InputError, load_machine
from polydraulic.machine.stability.lifting import lift_limits

MACHINES = ("excavator_22t", "loader_crane", "wheel_loader")


def independent(machine, positions, lifting):
    """Tipping load, hydraulic load and capacity of one pose."""
    statics = Statics(machine, positions)
    corners = machine.chassis.corners
    parts = [*statics.masses(), (machine.chassis.mass, np.array([machine.chassis.cg.get(c, 0.0) for c in "xyz"]))]
    tipping = np.inf
    for k, (x0, y0, _) in enumerate(corners):
        x1, y1, _ = corners[(k + 1) % len(corners)]
        axis = np.array([x1 - x0, y1 - y0, 0.0])
        origin, down = np.array([x0, y0, 0.0]), np.array([0.0, 0.0, -1.0])
        moment = sum(m * np.cross(at - origin, down) @ axis for m, at in parts)
        of_load = np.cross(statics.tip - origin, down) @ axis
        if of_load > 0.0:
            tipping = min(tipping, max(-moment / of_load, 0.0))
    hydraulic, p_return = np.inf, machine.tank.return_pressure
    for place, f in enumerate(machine.functions):
        bare, per_kg = statics.torques[place], statics.torques_per_kg[place]
        if f.actuator == "motor":
            assert abs(per_kg) < 1e-9
            continue
        head, rod = (f.drive.number * pi / 4.0 * (f.drive.bore**2 - d**2) for d in (0.0, f.drive.rod))
        pump = next(c.pump for c in machine.circuits if f.name in c.functions)
        most = min(pump.relief, f.line.relief) if f.name == lifting else f.line.relief
        lever = lever_of(statics, f, positions[place])
        ends = sorted([lever * (most * head - p_return * rod), -lever * (most * rod - p_return * head)])
        own = ((ends[1] - bare) if per_kg > 0.0 else (ends[0] - bare)) / per_kg if abs(per_kg) > 1e-8 else np.inf
        hydraulic = min(hydraulic, max(own, 0.0) if ends[0] <= bare <= ends[1] else 0.0)
    return tipping, hydraulic, min(0.75 * tipping, 0.87 * hydraulic)


def poses(machine, count=7):
    rng = np.random.default_rng(3)
    low, high = (
        np.array([np.clip(getattr(f.stops, e), -2.0, 2.0) for f in machine.functions]) for e in ("low", "high")
    )
    return low + (high - low) * rng.random((count, len(low)))


@pytest.mark.parametrize("name", MACHINES)
def test_capacity_is_that_of_independent_statics(name):
    machine = load_machine(name)
    lifting, rows = machine.names[-2], poses(machine)
    found = lift_limits(machine, rows, lifting)
    for k, row in enumerate(rows):
        tipping, hydraulic, capacity = independent(machine, row, lifting)
        assert found.tipping[k] == pytest.approx(tipping, rel=1e-9)
        assert found.hydraulic[k] == pytest.approx(hydraulic, rel=1e-9, abs=1e-7)
        assert found.capacity[k] == pytest.approx(capacity, rel=1e-9, abs=1e-7)
    assert found.by_tipping.any() != found.by_tipping.all() or name != "excavator_22t"


def test_nothing_is_lifted_without_gravity():
    with pytest.raises(InputError, match="gravity = 0"):
        lift_limits(load_machine("wheel_loader")._replace(gravity=0.0), np.zeros((1, 2)), "lift")
