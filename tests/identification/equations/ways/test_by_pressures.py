"""Masses and friction change where they are marked, or where a log tells nothing else."""

import pytest

from helpers.operator_log import operator_log
from polydraulic import load_machine
from polydraulic.identification import identify
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
