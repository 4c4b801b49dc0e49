import numpy as np
import pytest

from helpers.logs_with_memory import memory_log
from polydraulic import AbductiveRegressor
from polydraulic.errors import InputError
from polydraulic.identification.run_plot import plot_runs, plot_separately
from polydraulic.identification.runs import lags_in_words, last_value_held, run_on, run_table
from polydraulic.networks import DynamicRegressor, Variable

LOG = memory_log(n=300)
SPANS = [(0, 150), (150, 152), (160, 300)]


@pytest.fixture(scope="module")
def fitted():
    fixed = {"input_lags": [1], "output_lags": [1, 2], "increments": False, "horizon": None}
    model = DynamicRegressor(AbductiveRegressor(max_layers=1), **fixed, raster=0.02)
    model.fit(LOG.matrix(["u"]), LOG.matrix(["y", "z"]))
    models = model.to_models([Variable("u", "V")], [Variable("y", "Pa"), Variable("z", "m")])
    return model, models


def test_runs_begin_from_measured_rows_and_short_spans_are_left_out(fitted):
    model, models = fitted
    y, z = run_on(models, LOG, SPANS)
    assert (y.n_run, y.longest) == (2, 148)
    assert y.row.tolist() == [*range(2, 150), *range(162, 300)]
    whole = model.simulate(LOG.matrix(["u"])[160:], LOG.matrix(["y", "z"])[160:])
    assert np.array_equal(np.column_stack([y.free, z.free])[148:], whole[2:])
    ahead = model.predict(LOG.matrix(["u"])[160:], LOG.matrix(["y", "z"])[160:])
    assert np.array_equal(y.one_step[148:], ahead[2:, 0])
    assert np.array_equal(z.measured, LOG["z"][z.row])
    assert np.array_equal(y.time, LOG["time"][y.row])


def test_runs_begin_anew_after_a_horizon(fitted):
    y, _ = run_on(fitted[1], LOG, SPANS, 40)
    assert np.bincount(y.number).tolist() == [40, 40, 40, 28, 40, 40, 40, 18]
    starts = np.unique(y.number, return_index=True)[1]
    assert np.array_equal(y.free[starts], y.one_step[starts])


def test_the_last_value_is_held_from_where_a_run_begins(fitted):
    y, _ = run_on(fitted[1], LOG, SPANS)
    held, before = last_value_held(y, LOG["y"])
    assert set(held[:148]) == {LOG["y"][1]}
    assert set(held[148:]) == {LOG["y"][161]}
    assert np.array_equal(before, LOG["y"][y.row - 1])


def test_no_run_fits(fitted):
    with pytest.raises(InputError, match="at most 2 rows of the table follow each other; a run needs more than 2"):
        run_on(fitted[1], LOG, [(0, 2), (5, 7)])
    with pytest.raises(InputError, match="no column 'u'"):
        run_on(fitted[1], type(LOG)({"y": LOG["y"], "z": LOG["z"]}, {}), SPANS)


def test_a_run_as_a_table_and_in_words(fitted):
    models = fitted[1]
    found = run_table(models, run_on(models, LOG, SPANS), LOG)
    assert found.names == ["time", "run", "y", "y.run", "y.one_step", "z", "z.run", "z.one_step"]
    assert (found.unit("y.run"), found.unit("z.one_step"), found.unit("time")) == ("Pa", "m", "s")
    assert lags_in_words(models[0]) == "u 1; y 1, 2; z 1, 2 rows ago"


def test_pictures_show_measured_next_to_simulated(fitted):
    models = fitted[1]
    runs = run_on(models, LOG, SPANS)
    figure = plot_runs(models, runs)
    assert [axis.get_ylabel() for axis in figure.axes] == ["y [bar]", "z [mm]"]
    measured, free = figure.axes[0].lines
    assert np.isnan(measured.get_xdata()).sum() == 1  # no line from one run to the next
    assert free.get_ydata()[:148] == pytest.approx(runs[0].free[:148] / 1e5)
    assert [axis.get_ylabel() for axis in plot_runs(models, runs, units="si").axes] == ["y [Pa]", "z [m]"]
    assert plot_runs(models, runs, began=1.7e9).axes[-1].get_xlabel() == "date and time"
    assert not figure.axes[0].collections  # no interval where none is stated
    models[0].training.update({"interval_half_widths": [0.1], "free_run_rows": 148})
    figure = plot_separately(models[0], runs[0])
    assert len(figure.axes) == 2
    assert len(figure.axes[0].collections) == 1
    models[0].training["free_run_rows"] = 40  # stated for shorter runs only
    assert not plot_separately(models[0], runs[0]).axes[0].collections
    models[0].training.clear()
