import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.identification.arguments import table_of
from polydraulic.identification.log_rows import log_rows, rows_for
from polydraulic.networks import Dynamics, Lag, Model, Network, Variable
from polydraulic.tables import Table


def table(time, segment=None):
    columns = {"time": np.array(time, dtype=float)}
    return Table(columns if segment is None else columns | {"segment": np.array(segment, dtype=float)}, {})


def model(raster):
    constant = Network((), (0.0,), (1.0,), (0.0,), (1.0,), 2.0, 1.0)
    return Model((Variable("u[t-1]"),), Variable("y"), (constant,), dynamics=Dynamics((Lag("u", 1),), raster=raster))


def test_a_segment_begins_where_the_label_changes_or_time_jumps():
    found = log_rows(table([0.0, 0.1, 0.2, 0.3, 7.0, 7.1, 7.2, 7.3, 7.4, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8,
                            0.9, 1.0, 1.1, 1.2, 1.3]))  # fmt: skip
    assert found.segments.tolist() == [0] * 4 + [1] * 5 + [2] * 14
    assert (found.raster, found.n_segment) == (0.1, 3)
    assert log_rows(table([0.0, 1.0, 2.0, 3.0, 4.0], [0, 0, 0, 1, 1])).segments.tolist() == [0, 0, 0, 1, 1]


def test_the_raster_of_rounded_times_is_their_mean_step():
    exact = np.arange(601) / 60.0
    assert log_rows(table(np.round(exact, 3))).raster == pytest.approx(1.0 / 60.0, rel=1e-4)


@pytest.mark.parametrize(
    ("time", "segment", "message"),
    [
        ([0.0], None, "the table has 1 row"),
        ([0.0, 0.0, 0.0], None, "the usual step of the column 'time' is 0 s"),
        ([3.0, 2.0, 1.0], None, "is -1 s; rows must be in order of time"),
        ([0.0, 1.0, 2.0], [0, 1, 2], "each of the 3 rows is a segment of its own"),
        ([0.0, 1.0, 2.0, 4.0, 5.0, 9.0], None, "the column 'time' has no raster: 2 of 5 steps are not the usual 1 s"),
    ],
)
def test_times_without_a_raster_are_refused(time, segment, message):
    with pytest.raises(InputError, match=message):
        log_rows(table(time, segment))


def test_a_table_without_time_or_of_another_raster_is_refused():
    rows = Table({"u": np.zeros(5)}, {})
    with pytest.raises(InputError, match="no column 'time': a dynamic model needs the raster"):
        log_rows(rows)
    with pytest.raises(InputError, match="no column 'time'"):
        rows_for([model(0.1)], rows)
    with pytest.raises(InputError, match=r'are 0.1 s apart, those of the model 0.02 s: import .* raster = "20 ms"'):
        rows_for([model(0.02)], table(0.1 * np.arange(9)))
    assert rows_for([model(0.1)], table(0.1 * np.arange(9))).raster == 0.1


def test_a_model_without_a_raster_takes_rows_as_they_are():
    found = rows_for([model(None)], Table({"u": np.zeros(5)}, {}))
    assert (found.segments.tolist(), found.raster) == ([0] * 5, None)
    assert rows_for([model(None)], table([0.0, 1.0, 2.0])).raster == 1.0


@pytest.mark.parametrize(("step", "segments"), [(1.5, 1), (1.51, 2), (0.5, 1), (0.49, 2), (-1.0, 2)])
def test_a_step_that_is_half_off_begins_a_segment(step, segments):
    found = log_rows(table(np.cumsum([0.0, *[1.0] * 10, step, *[1.0] * 10])))
    assert found.n_segment == segments
    assert found.segments.tolist() == [0] * 11 + [segments - 1] * 11
    assert found.raster == pytest.approx(1.0 if segments == 2 else (20.0 + step) / 21.0, rel=1e-5)


@pytest.mark.parametrize(("n", "has_one"), [(10, True), (9, False)])
def test_a_tenth_of_the_steps_may_jump(n, has_one):
    time = np.cumsum([0.0, *[1.0] * (n - 1), 3.0])
    if has_one:
        assert log_rows(table(time)).n_segment == 2
    else:
        with pytest.raises(InputError, match=f"no raster: 1 of {n} steps are not the usual 1 s"):
            log_rows(table(time))


@pytest.mark.parametrize(("raster", "same"), [(0.1009, True), (0.1011, False), (0.0991, True), (0.0989, False)])
def test_rasters_are_the_same_within_a_hundredth(raster, same):
    first, second = (Table({"time": step * np.arange(20), "u": np.arange(20) + step}, {}) for step in (0.1, raster))
    both, _ = table_of([first, second])
    if same:
        assert log_rows(both).n_segment == 2
        assert rows_for([model(0.1)], second).raster == raster
    else:
        with pytest.raises(InputError, match=rf"rows are {raster:g} s apart, those of table \(1\) 0.1 s; import both"):
            log_rows(both)
        with pytest.raises(InputError, match=f"are {raster:g} s apart, those of the model 0.1 s"):
            rows_for([model(0.1)], second)


def test_two_rows_follow_each_other():
    found = log_rows(table([3.0, 3.5]))
    assert (found.segments.tolist(), found.raster) == ([0, 0], 0.5)
