"""Dynamic models of logs: errors of runs through rows held out, cards, and whether a model still holds."""

import copy
import json
from dataclasses import replace

import numpy as np
import pytest

from helpers.logs_with_memory import memory_log
from polydraulic import AbductiveRegressor, load_models, save_models
from polydraulic.errors import InputError
from polydraulic.identification import Errors, RunErrors, check_models, fit_dynamic, write_card
from polydraulic.identification.dynamic_fit import LAST, LINEAR, _held_out, statements
from polydraulic.identification.runs import run_models, run_on
from polydraulic.identification.validity import run_validity
from polydraulic.networks.dynamic.free_run import dynamics_of
from polydraulic.tables import Table

ONE = AbductiveRegressor(max_layers=1)
LOG = memory_log(n=440)


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def found(told):
    def tell(*step):
        told.append(step)

    return fit_dynamic(LOG, ["u"], ["y", "z"], estimator=ONE, longest_lag=1, progress=tell)


@pytest.fixture(scope="module")
def fits(found):
    return found.outputs


def fit(table, outputs=("y",), inputs=("u",)):
    return fit_dynamic(table, inputs, outputs, estimator=ONE, longest_lag=1).outputs


def test_errors_are_those_of_runs_through_blocks_that_were_not_fitted(fits):
    y, z = fits
    assert (str(y.model.output), str(z.model.output)) == ("y [Pa]", "z [m]")
    assert (y.held.n_run, y.held.longest) == (4, 22 - y.model.dynamics.warm_up)
    assert set(y.held.row // 22) == {4, 9, 14, 19}
    error = y.held.free - y.held.measured
    assert y.errors.free_run.rms == pytest.approx(np.sqrt(np.mean(error**2)))
    assert y.errors.one_step.largest == np.abs(y.held.one_step - y.held.measured).max()
    assert 0.002 < y.errors.free_run.rms < 0.01  # noise of 0.003
    assert y.errors.free_run.rms < 0.1 * y.others["linear, same lags"].free_run.rms  # a square is not linear
    assert y.errors.one_step.rms < 0.2 * y.others["last value held"].one_step.rms
    again = run_on([fit.model for fit in fits], LOG, [(88, 110)])[0]
    assert not np.array_equal(again.free, y.held.free[: len(again.row)])  # the model of all rows is another one


@pytest.mark.slow
def test_rows_held_out_play_no_part_in_what_is_judged():
    spoilt = LOG["y"].copy()
    held = np.arange(440) // 22 == 9
    spoilt[held] += 3.0
    found, other = (fit(Table({**LOG.columns, "y": y}, LOG.units))[0].held for y in (LOG["y"], spoilt))
    rest = found.row // 22 != 9
    assert np.array_equal(found.free[rest], other.free[rest])


def test_the_model_states_what_was_found(fits, tmp_path):
    y = fits[0]
    save_models([fit.model for fit in fits], tmp_path / "m.json")
    training = load_models(tmp_path / "m.json")[0].training
    assert training["free_run_rms"] == y.errors.free_run.rms
    assert training["one_step_r2"] == y.errors.one_step.r2
    assert training["for_scale"]["last value held"]["free_run_largest"] == y.others["last value held"].free_run.largest
    assert training["free_run_rows"] == y.held.longest
    assert training["interval_half_widths"] == [y.half_width]
    assert y.model.dynamics.raster == 0.02
    assert {lag.steps for lag in y.model.dynamics.lags} == {1}
    words = "\n".join(statements(y))
    for text in ("4 free runs of up to", "one step ahead: R2 0.9", "rms for scale", "90% intervals", "rows ago; "):
        assert text in words
    assert "would err less" not in words
    assert str(y) == "\n  ".join(["y [bar]", *statements(y.shown())])


def test_intervals_come_from_half_of_the_runs(fits):
    y = fits[0]
    size, sets = np.abs(y.held.free - y.held.measured), y.held.number % 2 == 0
    assert np.mean(size[sets] <= y.half_width) == pytest.approx(0.9, abs=0.04)
    assert y.covered == np.mean(size[~sets] <= y.half_width)


def test_intervals_that_held_for_few_rows_are_held_to_that(fits):
    y = fits[0]._replace(covered=0.5)
    assert any(
        "hold for 50% of the rows that they were not set by: the blocks differ" in text for text in statements(y)
    )
    few = [replace(fit.model, training=dict(fit.model.training)) for fit in fits]
    few[0].training.update({"interval_covered": 0.5, "interval_half_widths": [0.8 * fits[0].errors.free_run.rms]})
    found = run_validity(few, memory_log(seed=1))[0]
    assert 0.4 < found.covered < 0.8
    assert found.holds
    assert "(50% did when it was fitted, 40% must): about as many as" in found.statements[1]
    few[0].training["interval_covered"] = 0.9
    assert not run_validity(few, memory_log(seed=1))[0].holds


def test_another_choice_than_the_one_that_was_judged_is_said(fits):
    y = fits[0]
    model = replace(y.model, training=copy.deepcopy(y.model.training))
    same = y._replace(model=model)
    model.training["choice"] = model.training["choice_held_out"] = {
        "input_lags": [1], "output_lags": [1, 2], "increments": True, "horizon": None, "terms": None
    }  # fmt: skip
    assert not any("led to another" in text for text in statements(same))
    assert statements(same)[-1].endswith("coefficients, of increments, fitted one step ahead")
    model.training["choice"] = model.training["choice"] | {"horizon": 8}
    assert (
        "these errors are of the choice without the rows held out: lags of inputs 1, of outputs 1, 2, "
        "of increments, fitted one step ahead; all rows led to another" in statements(same)
    )


def test_a_search_tells_what_it_tries(fits, told):
    assert fits
    assert sum(what.startswith("hold out: choice") for what, _, _ in told) >= 4
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told)
    assert told[-1] == ("all rows", 2, 2)


@pytest.mark.slow
def test_nothing_is_learnt_across_a_jump_in_time():
    found = fit(memory_log(n=440, pause=False))[0].model.dynamics
    order = np.r_[220:440, 0:220]
    whole = memory_log(n=440, pause=False)
    cut = Table({name: values[order] for name, values in whole.columns.items()}, whole.units)
    cut.columns["y"][220:] += 50.0  # a step that no rows of one segment show
    assert fit(cut)[0].model.dynamics.step[1] < found.step[1] + 0.1


def test_what_runs_worse_than_the_mean_or_the_last_value_is_said(fits):
    bad = RunErrors(Errors(0.6, 5.0, 9.0), fits[0].errors.one_step)
    others = fits[0].others
    worse = fits[0]._replace(errors=bad)
    assert "over such runs the mean would err less: do not simulate with it" in statements(worse)
    assert "a linear model of the same lags runs better on the blocks held out" in statements(worse)
    held = others["last value held"]._replace(free_run=Errors(0.7, 4.0, 9.0))
    worse = worse._replace(others=others | {"last value held": held})
    assert "over such runs the last value held would err less: do not simulate with it" in statements(worse)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"y": np.full(440, 2.0)}, "column 'y' is 2 in all 440 rows; it needs no model"),
        ({"time": np.zeros(440)}, "the usual step of the column 'time' is 0 s"),
        ({"segment": np.arange(440)}, "each of the 440 rows is a segment of its own"),
    ],
)
def test_logs_that_cannot_be_learnt_are_named(columns, message):
    with pytest.raises(InputError, match=message):
        fit(Table(LOG.columns | columns, LOG.units))


def test_few_rows_and_shared_columns_are_named():
    few = Table({name: values[:200] for name, values in LOG.columns.items()}, LOG.units)
    with pytest.raises(InputError, match=r"the log has 200 rows; to hold blocks of time out it takes 280 .* lag of 8"):
        fit_dynamic(few, ["u"], ["y"])
    with pytest.raises(InputError, match="column 'y' is both input and output"):
        fit(LOG, inputs=["u", "y"])


@pytest.mark.parametrize(("n", "blocks"), [(280, 10), (559, 10), (560, 20), (700, 20)])
def test_blocks_hold_twenty_rows_beside_the_longest_lag_and_are_twenty_where_that_is_so(n, blocks):
    held = _held_out([(0, n)], 8, [n])
    assert [b - a for a, b in held] == pytest.approx([n / blocks] * (blocks // 5), abs=1)
    assert held[0][0] == pytest.approx(4 * n / blocks, abs=1)
    with pytest.raises(
        InputError, match="the log has 279 rows; to hold blocks of time out it takes 280 with a longest"
    ):
        _held_out([(0, 279)], 8, [279])


@pytest.mark.parametrize(("covered", "doubted"), [(0.8, False), (0.799, True)])
def test_intervals_are_doubted_a_tenth_below_their_level(fits, covered, doubted):
    assert (
        any("the blocks differ too much" in text for text in statements(fits[0]._replace(covered=covered))) == doubted
    )


@pytest.mark.parametrize(
    ("scale", "said"),
    [
        (1.0, ["the last value held would err less"]),
        (1.001, []),
        (0.999, ["would err less", "a linear model", "one step ahead the last value"]),
    ],
)
def test_models_for_scale_are_told_where_they_are_better_and_the_last_value_where_it_is_as_good(fits, scale, said):
    y, (free, one) = fits[0], fits[0].errors
    other = RunErrors(free._replace(rms=scale * free.rms), one._replace(rms=scale * one.rms))
    words = "\n".join(statements(y._replace(others={LAST: other, LINEAR: other}))[3:])
    for text in ("would err less", "a linear model", "one step ahead the last value"):
        assert (text in words) == any(text in one for one in said)


def test_a_run_as_good_as_the_mean_is_no_better(fits):
    y = fits[0]
    for r2, said in ((0.0, True), (0.001, False)):
        free = y.errors.free_run._replace(r2=r2)
        assert ("would err less" in "\n".join(statements(y._replace(errors=y.errors._replace(free_run=free))))) == said


def test_the_card_shows_the_runs(found, fits, tmp_path):
    card = write_card(found, tmp_path / "card.html", source="machine.parquet")
    assert json.loads((tmp_path / "card.card.json").read_text()) == json.loads(json.dumps(card))
    model = card["models"][0]
    assert model["raster"] == 0.02
    assert model["largest_steps"] == list(fits[0].model.dynamics.step)
    assert model["training"]["free_run_rms"] == fits[0].errors.free_run.rms
    assert [column["name"] for column in card["data"]["columns"]] == ["u", "y", "z"]
    page = (tmp_path / "card.html").read_text()
    for text in (
        "this model",
        "linear, same lags",
        "last value held",
        "held out",
        "rows 0.02 s apart",
        "Domain",
        "y[t-1]",
    ):
        assert text in page
    assert page.count("data:image/svg+xml") == 1 + 2 * 3


def test_a_model_holds_on_more_of_the_same_and_not_on_something_else(fits, tmp_path):
    save_models([fit.model for fit in fits], tmp_path / "m.json")
    models = load_models(tmp_path / "m.json")
    y, z = run_validity(models, memory_log(seed=1))
    assert y.holds
    assert y.covered > 0.85
    assert z.rms < 1.5 * fits[1].errors.free_run.rms
    assert "on rows held out when it was fitted: as good as it was" in y.statements[0]
    assert f"of up to {fits[0].held.longest} rows" in y.statements[0]  # begun anew as when it was fitted
    assert any("when it was fitted" in text and text.startswith("one step ahead") for text in y.statements)
    assert "run through without a restart, up to" in y.statements[-1]
    worn, _ = run_validity(models, memory_log(seed=1, gain=0.2))
    assert not worn.holds
    assert "it errs more than it did" in worn.statements[0]


def test_other_units_rasters_and_missing_columns_are_named(fits):
    models = [fit.model for fit in fits]
    with pytest.raises(InputError, match="column 'u' is in 'mV'; the model was fitted in 'V'"):
        run_validity(models, Table(LOG.columns, LOG.units | {"u": "mV"}))
    with pytest.raises(InputError, match="the rows of the table are 0.01 s apart, those of the model 0.02 s"):
        run_validity(models, memory_log(raster=0.01))
    with pytest.raises(InputError, match="no column 'z'"):
        run_validity(models, Table({name: LOG[name] for name in ("time", "u", "y")}, LOG.units))


def halves():
    """The log in two, each with a clock of its own; and as one with two segments."""
    parts = [slice(0, 220), slice(220, None)]
    cut = [Table({n: v[part] for n, v in LOG.columns.items()}, LOG.units) for part in parts]
    anew = [Table({**half.columns, "time": half["time"] - half["time"][0]}, LOG.units) for half in cut]
    return anew, Table({**LOG.columns, "segment": np.repeat([0.0, 1.0], 220)}, LOG.units)


def test_of_several_logs_neither_lags_nor_blocks_go_over_the_end_of_one(found):
    apart, segments = halves()
    both = fit_dynamic(apart, ["u"], ["y", "z"], estimator=ONE, longest_lag=1)
    assert both.models == fit_dynamic(segments, ["u"], ["y", "z"], estimator=ONE, longest_lag=1).models
    assert both.table["segment"].tolist() == segments["segment"].tolist()
    short = Table({n: v[:150] for n, v in apart[0].columns.items()}, LOG.units)
    run = fit_dynamic([short, apart[1]], ["u"], ["y", "z"], estimator=ONE, longest_lag=1).outputs[0].held
    for number in range(run.n_run):
        rows = run.row[run.number == number]
        assert np.all(np.diff(rows) == 1)
        assert rows[-1] < 150 or rows[0] > 150  # the first row behind the border is only read


def test_logs_of_different_rasters_are_named():
    apart, _ = halves()
    slow = Table({**apart[1].columns, "time": 2.0 * apart[1]["time"]}, LOG.units)
    with pytest.raises(InputError, match=r"table \(2\): rows are 0.04 s apart, those of table \(1\) 0.02 s"):
        fit_dynamic([apart[0], slow], ["u"], ["y"], estimator=ONE, longest_lag=1)


def test_a_model_is_judged_by_several_logs(found):
    apart, segments = halves()
    here, there = (check_models(found.models, data=data) for data in (apart, segments))
    assert str(here) == str(there)
    assert here.found[0].statements[0].startswith("22 free run(s) of up to 21 rows")


def silent_at_times(every):
    """The log, whose sensor `y` has no value in one of so many rows."""
    columns = {name: values.copy() for name, values in LOG.columns.items()}
    columns["y"][::every] = np.nan
    return Table(columns, LOG.units).partial()


def test_rows_that_are_not_used_or_only_read_are_counted(found):
    assert found.doubts == []
    fit = fit_dynamic(silent_at_times(20), ["u"], ["y"], estimator=ONE, longest_lag=2)
    unused, *others = fit.doubts
    assert unused == "22 of 440 rows are not used, since columns that are read have no value there: y in 22"
    first = max(dynamics_of(model).warm_up for model in fit.models)
    only = (
        f"{22 * first} of 418 rows are read and teach nothing: the first {first} of each of 22 pieces without a gap, "
    )
    assert [doubt.startswith(only) for doubt in others] == [True] * (first > 1)
    assert f"warning: {unused}" in str(fit)
    here = check_models(fit.models, data=silent_at_times(20))
    assert str(here).startswith(f"note: {unused}\n")
    assert run_models(fit.models, silent_at_times(20)).text().startswith(f"warning: {unused}\n")


def test_a_run_needs_no_value_of_what_its_models_do_not_read(found):
    fit = fit_dynamic(LOG, ["u"], ["y"], estimator=ONE, longest_lag=1)
    whole = run_models(fit.models, LOG)
    columns = LOG.columns | {"z": np.where(np.arange(len(LOG)) % 3, LOG["z"], np.nan)}
    run = run_models(fit.models, Table(columns, LOG.units).partial())
    assert np.array_equal(run.runs[0].free, whole.runs[0].free)
    assert run.text() == whole.text()
