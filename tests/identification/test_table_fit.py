import numpy as np
import pytest

from polydraulic import AbductiveRegressor
from polydraulic.errors import InputError
from polydraulic.identification.table_fit import fit_table, held_out
from polydraulic.tables import Table

RNG = np.random.default_rng(4)
COLUMNS = {"a": RNG.uniform(size=100), "b": RNG.uniform(size=100), "flat": np.full(100, 3.0)}
COLUMNS["y"] = COLUMNS["a"] * COLUMNS["b"]
COLUMNS["z"] = COLUMNS["a"] + 0.01 * RNG.normal(size=100)
TABLE = Table(COLUMNS, {"a": "m", "y": "Pa"})


def fit(inputs, outputs, edges=None, table=TABLE):
    return fit_table(table, inputs, outputs, AbductiveRegressor(max_layers=2), edges or {})


def test_one_model_an_output():
    y, z = fit(["a", "b"], ["y", "z"])
    assert (str(y.model.output), str(z.model.output)) == ("y [Pa]", "z")
    assert y.r2 > 0.999  # held-out rows outside the training box are moved to its border
    assert 0.99 < z.r2 < 1.0
    assert y.model.training["rows"] == 100


def test_held_out_errors_come_from_rows_not_fitted():
    model = fit(["a", "b"], ["z"])[0]
    assert model.rms == pytest.approx(0.01, rel=0.8)
    assert model.largest >= model.rms


def test_regions_by_name():
    assert len(fit(["a", "b"], ["y"], {"b": [0.3, 0.6]})[0].model.networks) == 3


@pytest.mark.parametrize(
    ("inputs", "outputs", "edges", "message"),
    [
        (["a", "y"], ["y"], {}, "column 'y' is both input and output"),
        (["a", "flat"], ["y"], {}, "column 'flat' is 3 in all 100 rows; it cannot explain anything: leave it out"),
        (["a"], ["flat"], {}, "column 'flat' is 3 in all 100 rows; it needs no model"),
        (["a"], ["y"], {"b": [0.5]}, r"edges name the column 'b'; the inputs are \['a'\]"),
        (["a", "c"], ["y"], {}, "no column 'c'"),
    ],
)
def test_bad_requests_are_named(inputs, outputs, edges, message):
    with pytest.raises(InputError, match=message):
        fit(inputs, outputs, edges)


def test_too_few_rows_are_named():
    few = Table({name: values[:3] for name, values in COLUMNS.items()}, {})
    with pytest.raises(ValueError, match="the table has 3 rows; fitting and holding out takes more than 5"):
        fit(["a"], ["y"], table=few)


def log(n=2000, noise=0.01, seed=0):
    rng = np.random.default_rng(seed)
    t = 0.01 * np.arange(n)
    a, b = np.sin(t), np.cos(0.37 * t)
    y = np.abs(a) * b + noise * rng.normal(size=n)
    return Table({"time": t, "a": a, "b": b, "y": y}, {"time": "s", "a": "m", "y": "Pa"})


def test_of_a_log_blocks_of_time_are_held_out():
    held = held_out(2000, by_time=True)
    edges = np.flatnonzero(np.diff(held.astype(int)))
    assert len(edges) == 7  # four blocks, the last one ends with the log
    assert held.sum() == 400
    assert held_out(2000, by_time=False).sum() == 400
    assert np.flatnonzero(held_out(10, by_time=True)).tolist() == [4, 9]


def test_intervals_hold_on_rows_they_were_not_set_by():
    found = fit(["a", "b"], ["y"], {"a": [0.0]}, table=log())[0]
    assert found.held.by_time
    assert 0.8 < found.covered <= 1.0
    assert all(0.01 < width < 0.03 for width in found.half_widths)  # 1.64 sigma
    training = found.model.training
    assert training["interval_covered"] == found.covered
    assert [r["region"] for r in training["held_out_by_region"]] == found.model.region_names()
    assert sum(r["rows"] for r in training["held_out_by_region"]) == 400
