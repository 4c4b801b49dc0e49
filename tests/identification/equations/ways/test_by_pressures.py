"""Masses and friction change where they are marked, or where a log tells nothing else."""

import numpy as np
import pytest

from helpers.machine_motion import motion_log
from helpers.operator_log import operator_log
from polydraulic import load_machine
from polydraulic.identification import identify
from polydraulic.identification.equations.mechanics.fit import fit_mechanics
from polydraulic.identification.equations.ways.by_pressures import beyond_noise
from polydraulic.tables import Table

NAME = "loader_crane"


def test_friction_from_pressures_and_positions_alone():
    true = load_machine(NAME)
    log = operator_log(NAME, seconds=30.0)
    names = [n for n in log.names if n == "time" or n.endswith((".p_a", ".p_b", ".angle", ".position"))]
    start = true.with_values({"functions.inner.friction.viscous": 1.3 * true.function("inner").friction.viscous})
    found = identify(Table({n: log[n] for n in names}, {n: log.unit(n) for n in names}), start)
    assert found.mechanics is not None
    assert found.runs is None
    number = found.mechanics.estimates.of("functions.inner.friction.viscous")
    assert number.determined
    assert number.value == pytest.approx(true.function("inner").friction.viscous, abs=4.0 * number.sd, rel=0.0)
    assert all(path.startswith("links.") or ".friction." in path for path in found.changes)
    assert "through simulation: kept; the log has no slew.voltage" in " ".join(found.kept)


def test_a_load_during_a_part_of_the_log_is_said():
    machine = load_machine(NAME)
    carried = machine.with_values({"links.grapple.mass": machine.link("grapple").mass + 400.0})
    parts = [motion_log(m, seconds=15.0, noise=1.0, seed=3) for m in (machine, carried)]
    columns = {n: np.concatenate([part[n] for part in parts]) for n in parts[0].names}
    columns["segment"] = np.repeat([0.0, 1.0], len(parts[0]))
    columns["time"] = np.arange(2 * len(parts[0])) * 0.02
    both = fit_mechanics(Table(columns, parts[0].units), machine)
    alone = fit_mechanics(parts[0], machine)
    said = [
        line for line in beyond_noise(machine, both) if line.startswith("torques at inner: what the equations leave")
    ]
    assert len(said) == 1
    assert "times what noise of the sensors makes; the log has something that they do not, such as a load" in said[0]
    assert not beyond_noise(machine, alone)
    assert both.residual[1] > 3.0 * max(both.noise[1], alone.residual[1])
