import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.studies import sample_boom
from polydraulic.units import CUBIC_INCH, from_si


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
