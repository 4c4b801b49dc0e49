import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.flow import exact_flow
from polydraulic.flow.database import sample_boom, sample_series
from polydraulic.flow.sample import sample_fed
from polydraulic.unit_table import CUBIC_INCH
from polydraulic.units import from_si


def test_statistics_of_the_boom_map(machine):
    """Mean 122.3, standard deviation 61.9 and maximum 171.5 in3/s within 0.5 %."""
    active = (machine.spool.deadband, machine.spool.knots[-1])
    n = 20_000
    table = sample_boom(machine, n, rng=np.random.default_rng(0), travel=active, relief=False)
    # a grid in place of random points, so that the answer does not depend on luck
    q = table["boom.q_in"] / CUBIC_INCH
    slack = 3.0 * 61.9 / n**0.5
    assert q.mean() == pytest.approx(122.3, rel=0.005, abs=slack)
    assert q.std() == pytest.approx(61.9, rel=0.005, abs=slack)
    assert q.max() == pytest.approx(171.5, rel=0.005)


def test_columns_belong_together(machine):
    table = sample_boom(machine, 200, rng=np.random.default_rng(1))
    assert np.array_equal(table["boom.travel"], np.abs(table["boom.spool"]))
    drop = table["boom.p_out"] - machine.tank.return_pressure
    assert table["boom.root_p_out"] == pytest.approx(np.sqrt(np.maximum(drop, 0.0)))
    assert (table["boom.spool"] < 0).any()
    assert (table["boom.spool"] > 0).any()
    assert from_si(table["boom.p_in"].max(), "psi") <= 4000.0
    assert table.unit("boom.q_in") == "m3/s"


def test_the_seed_decides(machine):
    a, b, c = (sample_boom(machine, 50, rng=np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert np.array_equal(a["boom.q_in"], b["boom.q_in"])
    assert not np.array_equal(a["boom.q_in"], c["boom.q_in"])


def test_rows_must_be_positive(machine):
    with pytest.raises(InputError, match="rows = 0: must be at least 1"):
        sample_boom(machine, 0, rng=np.random.default_rng(1))


@pytest.mark.parametrize("limited", [False, True])
def test_series_columns_belong_together(machine, limited):
    machine = machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=limited))
    table = sample_series(machine, 2000, rng=np.random.default_rng(1))
    full = machine.pumps.series_flow
    passed, swing, stick = table["series.q_passed"], table["swing.q_in"], table["stick.q_in"]
    assert np.all(stick <= passed + 1e-9 * full)
    assert np.all(swing + passed <= full * (1.0 + 1e-9))
    # below relief and limit all of the pump's flow is somewhere
    free = table["series.p_pump"] < (machine.pumps.torque_limit_start if limited else machine.pumps.relief)
    assert (swing + passed)[free] == pytest.approx(full, rel=1e-9)
    shut = table["swing.travel"] > machine.spool.bypass_closed
    assert np.abs(passed[shut]).max() <= 1e-9 * full
    assert table["stick.q_out"] == pytest.approx(table["stick.k_out"] * table["stick.root_p_out"])


def test_stick_is_a_function_of_what_the_swing_leaves(machine):
    table = sample_series(machine, 500, rng=np.random.default_rng(2))
    exact = exact_flow(machine)
    points = table.matrix(["series.q_passed", "stick.spool", "stick.p_in"])
    below = table["series.p_pump"] < 0.999 * machine.pumps.relief  # there the pump's own pressure decides as well
    again = sample_fed(exact.valves.stick, exact.series_pump, points)
    assert again[below] == pytest.approx(table["stick.q_in"][below], abs=1e-9 * machine.pumps.series_flow)
