from types import SimpleNamespace

import numpy as np
import pytest

from polydraulic import AbductiveRegressor
from polydraulic.errors import InputError
from polydraulic.identification import fit_table
from polydraulic.identification.judging import r2_text
from polydraulic.identification.table_fit import _copied
from polydraulic.networks.hold_out import held_rows
from polydraulic.tables import Table, write_table

RNG = np.random.default_rng(4)
COLUMNS = {"a": RNG.uniform(size=100), "b": RNG.uniform(size=100), "flat": np.full(100, 3.0)}
COLUMNS["y"] = COLUMNS["a"] * COLUMNS["b"]
COLUMNS["z"] = COLUMNS["a"] + 0.01 * RNG.normal(size=100)
TABLE = Table(COLUMNS, {"a": "m", "y": "Pa"})


def fit(inputs, outputs, edges=None, table=TABLE):
    return fit_table(table, inputs, outputs, edges=edges, estimator=AbductiveRegressor(max_layers=2)).outputs


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
        (["a"], ["y"], {"a": [0.5, 0.5]}, r"edges of 'a' = \[0.5, 0.5\]: must be rising finite numbers"),
        (["a"], ["y"], {"a": "0.5"}, "edges of 'a' = '0.5': must be rising finite numbers"),
        (["a"], ["y"], {"a": [np.nan]}, "edges of 'a' = .*: must be rising finite numbers"),
        (
            ["a"],
            ["y"],
            {"a": [-9.0, 0.5]},
            "edges of 'a': no rows lie beyond -9000 mm, the column goes from .* mm: add .*; an edge without a unit is in m$",
        ),
        (["a"], ["y"], {"a": [0.5, 9.0]}, "edges of 'a': no rows lie beyond 9000 mm, the column goes from"),
        (["b"], ["y"], {"b": [0.5, 9.0]}, "edges of 'b': no rows lie beyond 9, the column goes from .* move the edge$"),
        (["a", "c"], ["y"], {}, "no column 'c'"),
    ],
)
def test_bad_requests_are_named(inputs, outputs, edges, message):
    with pytest.raises(InputError, match=message):
        fit(inputs, outputs, edges)


@pytest.mark.parametrize("regions", [0, -1, 1.5, "2", True])
def test_regions_are_whole_numbers(regions):
    with pytest.raises(InputError, match=f"max_regions = {regions!r}: must be a whole number, at least 1"):
        fit_table(Table(COLUMNS, {}), ["a"], ["y"], max_regions=regions)


def test_what_counts_as_names_and_as_a_whole_number_may_be_of_numpy():
    found = fit_table(TABLE, np.array(["a", "b"]), np.array(["y"]), max_regions=np.int64(1))
    assert found.models == fit_table(TABLE, ["a", "b"], ["y"]).models
    with pytest.raises(InputError, match="no input is given"):
        fit_table(TABLE, np.array([], dtype=str), ["y"])


def test_the_error_of_as_few_rows_as_are_taken_is_that_of_such_a_model():
    x = np.linspace(-2.0, 2.0, 14)
    curve = Table({"x": x, "y": x**2 + 3.0 * x + 1.0}, {})
    found = fit_table(curve, ["x"], ["y"])
    assert found.outputs[0].r2 > 0.999
    assert not warnings_of(found)
    fewer = Table({name: values[:13] for name, values in curve.columns.items()}, {})
    with pytest.raises(InputError, match="the table has 13 rows; fitting and holding out takes 14 or more"):
        fit_table(fewer, ["x"], ["y"])


def test_too_few_rows_are_named():
    few = Table({name: values[:3] for name, values in COLUMNS.items()}, {})
    with pytest.raises(ValueError, match="the table has 3 rows; fitting and holding out takes 14 or more"):
        fit(["a"], ["y"], table=few)
    with pytest.raises(InputError, match="the table has no rows"):
        fit(["a"], ["y"], table=Table({"a": np.zeros(0), "y": np.zeros(0)}, {}))


def test_a_table_in_memory_is_held_to_what_a_file_is():
    gap = np.where(np.arange(100) == 6, np.nan, COLUMNS["a"])
    with pytest.raises(
        InputError, match=r"column 'a' holds nan in row 7 \(1 of 100 rows\); every value must be a finite"
    ):
        fit(["a"], ["y"], table=Table({**COLUMNS, "a": gap}, {}))
    assert fit(["b"], ["z"], table=Table({**COLUMNS, "a": gap}, {}))  # what is not read may be anything


def test_a_file_gives_what_its_table_gives(tmp_path):
    write_table(TABLE, tmp_path / "t.parquet")
    here, there = (fit_table(table, ["a", "b"], ["y", "z"]) for table in (TABLE, tmp_path / "t.parquet"))
    assert here.models == there.models
    assert (here.source, there.source) == ("table", "t.parquet")
    assert there.table.names == ["a", "b", "y", "z"]


def test_what_was_found_is_said_and_progress_told():
    told = []
    found = fit_table(TABLE, ["a", "b"], ["y", "z"], progress=lambda *step: told.append(step))
    assert told == [("y", 0, 2), ("z", 1, 2)]
    z = found.outputs[1]
    line, where = str(found).splitlines()[2:]
    assert line == (
        f"z: 1 network(s), {z.model.n_coefficients} coefficients; "
        f"held-out {r2_text(z.r2)}, rms {z.rms:.4g}, largest {z.largest:.4g}"
    )
    row = np.argmax(np.abs(z.held.predicted - z.held.y))
    a, b = z.held.X[row]
    assert where == (
        f"  the largest error is at a = {1e3 * a:.4g} mm, b = {b:.4g}: {z.held.predicted[row]:.4g} predicted, {z.held.y[row]:.4g} in the table"
    )


@pytest.mark.parametrize(
    ("r2", "said"),
    [
        (0.99746, "R2 0.9975"),
        (0.99995, "R2 1 - 5e-05"),
        (1.0 - 2.5e-9, "R2 1 - 2.5e-09"),
        (1.0, "R2 1.0000"),
        (-3.0, "R2 -3.0000"),
    ],
)
def test_an_r2_below_one_is_not_read_as_one(r2, said):
    assert r2_text(r2) == said


def test_regions_that_were_asked_for_and_not_found_are_told():
    a = np.random.default_rng(2).uniform(size=400)
    smooth, kinked = Table({"a": a, "y": a * a}, {}), Table({"a": a, "y": np.abs(a - 0.4)}, {})
    said = "  up to 3 regions were asked for: no cut lowers the predicted squared error enough, so it stays one"
    assert said in fit_table(smooth, ["a"], ["y"], max_regions=3).text().splitlines()
    assert "asked for" not in fit_table(smooth, ["a"], ["y"]).text()
    assert "asked for" not in fit_table(kinked, ["a"], ["y"], max_regions=3).text()


def test_rows_beyond_bounds_are_told_rather_than_that_nothing_was_learnt():
    a = np.random.default_rng(2).uniform(size=400)
    table = Table({"a": a, "y": 10.0 * a * a}, {"y": "bar"})
    beyond = int((10.0 * a * a > 1.05).sum())
    bounded = fit_table(table, ["a"], ["y"], estimator=AbductiveRegressor(output_bounds=(0.0, 1.0)))
    assert bounded.doubts == [
        f"y: {beyond} of 400 rows lie beyond its bounds, 0 bar to 1 bar, which the model cannot leave: widen them, unless these rows are wrong"
    ]
    near = fit_table(table, ["a"], ["y"], estimator=AbductiveRegressor(output_bounds=(0.2, 9.9)))
    assert not any("bounds" in doubt for doubt in near.doubts)


def test_bounds_are_told_in_the_units_that_are_shown():
    a = np.random.default_rng(2).uniform(size=400)
    bounded = fit_table(
        Table({"a": a, "q": 1e-3 * a}, {"q": "m3/s"}),
        ["a"],
        ["q"],
        estimator=AbductiveRegressor(output_bounds=(0.0, 5e-4)),
    )
    assert "beyond its bounds, 0 l/min to 30 l/min, which" in bounded.text()
    assert "beyond its bounds, 0 m3/s to 0.0005 m3/s, which" in bounded.text("si")


@pytest.mark.parametrize(("beyond", "sentences"), [(1, 2), (40, 2), (41, 1)])
def test_few_rows_beyond_bounds_do_not_hide_that_nothing_was_learnt(beyond, sentences):
    a, y = np.random.default_rng(5).uniform(size=(2, 400))
    y[:beyond] += 2.0
    table = Table({"a": a, "y": y}, {})
    doubts = fit_table(table, ["a"], ["y"], estimator=AbductiveRegressor(output_bounds=(0.0, 1.0))).doubts
    assert len(doubts) == sentences
    assert doubts[0].startswith(f"y: {beyond} of 400 rows lie beyond its bounds, 0 to 1, ")


def test_tiny_numbers_are_no_copies_of_each_other():
    a, b = np.random.default_rng(3).uniform(size=(2, 200))
    found = fit_table(Table({"a": 1e-300 * a, "b": b, "y": a * b}, {}), ["a", "b"], ["y"])
    assert found.doubts == []


def test_regions_of_the_rows_not_held_out_are_those_of_the_model():
    a = np.random.default_rng(2).uniform(size=400)
    found = fit_table(Table({"a": a, "y": np.abs(a - 0.4)}, {}), ["a"], ["y"], max_regions=2)
    learn = ~held_rows(400)
    below, above = a[learn & (a <= 0.4)].max(), a[learn & (a > 0.4)].min()
    assert found.models[0].partition.at == pytest.approx(0.5 * (below + above), abs=1e-12)
    assert found.models[0].training["rows"] == 400


def log(n=2000, noise=0.01, seed=0):
    rng = np.random.default_rng(seed)
    t = 0.01 * np.arange(n)
    a, b = np.sin(t), np.cos(0.37 * t)
    y = np.abs(a) * b + noise * rng.normal(size=n)
    return Table({"time": t, "a": a, "b": b, "y": y}, {"time": "s", "a": "m", "y": "Pa"})


def test_of_a_log_blocks_of_time_are_held_out():
    def rows(table):
        return np.isin(table["a"], fit(["a", "b"], ["y"], table=table)[0].held.X[:, 0])

    table = log()
    held = rows(table)
    assert held.sum() == 400
    assert np.flatnonzero(np.diff(held.astype(int))).tolist() == [399, 499, 899, 999, 1399, 1499, 1899]
    untimed = Table({name: table[name] for name in "aby"}, {})
    assert np.flatnonzero(rows(untimed))[:3].tolist() == [4, 9, 14]
    short = log(190)  # too short for blocks of ten rows
    assert np.flatnonzero(rows(short))[:3].tolist() == [4, 9, 14]


def test_intervals_hold_on_rows_they_were_not_set_by():
    found = fit(["a", "b"], ["y"], {"a": [0.0]}, table=log())[0]
    assert found.held.by_time
    assert 0.8 < found.covered <= 1.0
    assert all(0.01 < width < 0.03 for width in found.half_widths)  # 1.64 sigma
    training = found.model.training
    assert training["interval_covered"] == found.covered
    assert [r["region"] for r in training["held_out_by_region"]] == found.model.region_names()
    assert sum(r["rows"] for r in training["held_out_by_region"]) == 400


@pytest.fixture(scope="module")
def in_si():
    rng = np.random.default_rng(0)
    x, p = rng.uniform(0.0, 0.01, 400), rng.uniform(0.0, 2e7, 400)
    rows = Table(
        {"x": x, "p": p, "q": 0.2 * x * (1.0 + 1e-8 * p) + rng.normal(0.0, 1e-6, 400)},
        {"x": "m", "p": "Pa", "q": "m3/s"},
    )
    return fit_table(rows, ["x", "p"], ["q"], estimator=AbductiveRegressor(max_layers=1), edges={"x": [0.005]})


def test_errors_and_rows_of_a_fit(in_si):
    fit = in_si.outputs[0]
    read = fit.shown()
    assert str(fit).startswith("q [l/min]: 2 network(s)")
    assert f"rms {6e4 * fit.rms:.4g} l/min" in fit.text()
    assert "m3/s" in fit.text("si")
    assert read.rms == pytest.approx(6e4 * fit.rms)
    assert read.held.y == pytest.approx(6e4 * fit.held.y)
    assert read.held.X[:, 1] == pytest.approx(1e-5 * fit.held.X[:, 1])
    assert (read.r2, read.covered) == (fit.r2, fit.covered)
    assert in_si.text("field").startswith("q [in3/s]: 2 network(s)")


def test_of_several_logs_no_block_goes_over_the_end_of_one():
    one, two = log(700, seed=1), log(1100, seed=2)
    both = fit_table([one, two], ["a", "b"], ["y"], estimator=AbductiveRegressor(max_layers=1))
    held = both.outputs[0].held
    a = np.concatenate([one["a"], two["a"]])
    expected = held_rows(1800, 20, [700, 1100])
    assert np.array_equal(held.X[:, 0], a[expected])
    begun = np.flatnonzero(expected & ~np.roll(expected, 1))
    assert len(begun) == 4
    assert not (expected[699] and expected[700])
    assert not np.array_equal(expected, held_rows(1800, 20))
    assert (both.source, both.outputs[0].model.training["rows"]) == ("table (1), table (2)", 1800)


def warnings_of(found):
    said = [line.removeprefix("warning: ") for line in str(found).splitlines() if line.startswith("warning: ")]
    assert said == found.doubts
    return said


def test_inputs_that_do_not_determine_an_output_are_named():
    rng = np.random.default_rng(3)
    noise = Table({name: rng.uniform(size=80) for name in "abcy"}, {})
    found = fit_table(noise, ["a", "b", "c"], ["y"])
    assert found.models[0].n_coefficients == 0
    (said,) = warnings_of(found)
    assert said.startswith(
        "y: these inputs do not determine it: of 80 rows no network explains more than a search as wide"
    )
    assert not warnings_of(fit_table(TABLE, ["a", "b"], ["y"], estimator=AbductiveRegressor(max_layers=1)))


def test_a_model_that_is_no_better_than_the_mean_is_named():
    from_noise = AbductiveRegressor(leave_one_out=False)  # as the predicted squared error alone has it
    rng = np.random.default_rng(3)
    noise = Table({name: rng.uniform(size=80) for name in "abcdefy"}, {})
    found = fit_table(noise, list("abcdef"), ["y"], estimator=from_noise)
    assert found.outputs[0].r2 <= 0.0
    (said,) = warnings_of(found)
    assert said.startswith("y: nothing was learnt from 80 rows that helps on others: the mean would do as well")


@pytest.mark.parametrize("edges", [None, {"a": [0.5]}])
@pytest.mark.filterwarnings("error")
def test_a_value_far_from_all_others_is_named_by_its_row_in_the_table(edges):
    far = TABLE.columns | {"y": np.where(np.arange(100) == 17, 1e6, COLUMNS["y"])}
    found = fit_table(Table(far, {"y": "Pa"}), ["a", "b"], ["y", "z"], edges=edges)
    (said,) = warnings_of(found)  # not that the inputs do not determine it, too, which nothing shows
    assert said.startswith("y [Pa] holds 1e+06 in row 18, ")
    assert "leave the row out" in said
    assert said.endswith("the model is a constant") == (found.models[0].n_coefficients == 0)


def test_a_model_that_is_the_mean_is_named_where_the_rows_held_out_tell_nothing():
    rng = np.random.default_rng(0)
    once = np.where(np.arange(100) == 50, 1.0, 0.0)
    found = fit_table(Table({"a": rng.uniform(size=100), "y": once}, {}), ["a"], ["y"])
    assert found.models[0].n_coefficients == 0
    assert "warning: y: these inputs do not determine it: of 100 rows" in str(found)


@pytest.mark.parametrize("copied", [lambda v: np.repeat(v, 10), lambda v: np.tile(v, 10)])
def test_copies_of_rows_are_held_out_with_them(copied):
    rng = np.random.default_rng(0)
    found = fit_table(Table({name: copied(rng.normal(size=50)) for name in "aby"}, {}), ["a", "b"], ["y"])
    assert found.outputs[0].r2 <= 0.0  # of noise nothing can be known
    held = found.outputs[0].held
    assert len(held.y) == 100
    assert len(np.unique(held.y)) == 10
    few = Table({name: np.tile(rng.normal(size=9), 10) for name in "ay"}, {})
    with pytest.raises(InputError, match="the table has 90 rows, of which 9 differ; fitting and holding out takes 14"):
        fit_table(few, ["a"], ["y"])


def test_an_input_that_is_the_output_and_times_are_named():
    rng = np.random.default_rng(0)
    a, b = rng.uniform(size=(2, 100))
    columns = {
        "time": np.arange(100.0),
        "a": a,
        "y": a * b,
        "psi": 14.5 * a * b + 1.0,
        "near": a * b + 1e-3 * rng.normal(size=100),
    }
    found = fit_table(Table(columns, {}), ["a", "psi"], ["y"])
    assert "warning: y: psi is the same but for scale and offset" in str(found)
    assert "warning: " not in str(fit_table(Table(columns, {}), ["a", "near"], ["y"]))
    assert "warning: time is an input" in str(fit_table(Table(columns, {}), ["a", "time"], ["y"]))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("noise", "same"), [(1.35e-5, True), (1.5e-5, False)])
def test_no_two_sensors_agree_to_ten_digits_of_their_correlation(noise, same, sign):
    """1 - r is half of the square of what noise adds to the spread: 0.91e-10 and 1.1e-10."""
    t = 2.0 * np.pi * np.arange(400) / 400.0
    table = Table({"y": np.sin(t), "x": sign * (np.sin(t) + noise * np.cos(t)) + 3.0}, {})
    model = SimpleNamespace(output=SimpleNamespace(name="y"), inputs=[SimpleNamespace(name="x")])
    assert bool(_copied(SimpleNamespace(model=model), table)) == same
