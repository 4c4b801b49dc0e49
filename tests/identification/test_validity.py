"""Whether a model still holds: every threshold from both sides, on models whose errors are known exactly."""

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.identification.validity import run_validity, validity
from polydraulic.networks import Dynamics, Lag, Model, Network, Split, Variable
from polydraulic.tables import Table

FLAT = Network((), (0.0,), (1.0,), (-1.0,), (1.0,), 0.0, 1.0)  # answers 0, in a domain from -1 to 1


def static(**training):
    return Model((Variable("a", "m"),), Variable("y", "V"), (FLAT,), training=training)


def judged(errors, model, a=0.0, size=0.0):
    """What is said of a model that errs by so much, in rows at `a`; `size` is the largest output."""
    errors = np.asarray(errors, dtype=float)
    return validity(model, Table({"a": a + np.zeros(len(errors)), "y": size - errors}, {"a": "m", "y": "V"}), "si")


def test_errors_are_those_of_the_rows():
    found = judged([3.0, -4.0, 0.0, 0.0], static())
    assert (found.rms, found.largest, found.covered, found.outside) == (2.5, 4.0, None, 0.0)
    assert found.holds
    assert found.statements == ["rms error 2.5 V; the model does not state what it was when it was fitted"]
    assert [(r["rows"], r["rms"]) for r in found.regions] == [(4, 2.5)]


@pytest.mark.parametrize(
    ("error", "holds"), [(1.0, True), (1.1, True), (1.38, True), (1.5, True), (1.51, False), (2.0, False)]
)
def test_errors_may_grow_by_half(error, holds):
    found = judged([error, -error], static(held_out_rms=1.0))
    said = "as good as it was" if error <= 1.1 else f"{error:.2g} times what it was, and it holds up to 1.5 times"
    said = said if holds else "it errs more than it did"
    assert found.holds == holds
    assert found.statements == [f"rms error {error:g} V, 1 V on rows held out when it was fitted: {said}"]


@pytest.mark.parametrize(("error", "holds"), [(0.9, True), (1.1, False)])
def test_of_a_model_without_error_rounding_is_none(error, holds):
    table = Table({"a": np.zeros(2), "y": np.array([1e9, -1e9])}, {})
    lines = Network((), (0.0,), (1.0,), (-1.0,), (1.0,), 1e9 + error, 1.0)
    model = Model((Variable("a"),), Variable("y"), (lines,), training={"held_out_rms": 0.0})
    assert validity(model, Table({"a": table["a"][:1], "y": table["y"][:1]}, {})).holds == holds


@pytest.mark.parametrize(
    ("inside", "before", "holds", "said"),
    [
        (95, None, True, "95% of the rows lie in their 90% intervals (80% must): the intervals hold"),
        (80, None, True, "80% of the rows lie in their 90% intervals (80% must): the intervals hold"),
        (79, None, False, "79% of the rows lie in their 90% intervals (80% must): the intervals no longer hold"),
        (
            79,
            1.0,
            False,
            "79% of the rows lie in their 90% intervals (100% did when it was fitted, 80% must): the intervals no longer hold",
        ),
        (
            61,
            0.7,
            True,
            "61% of the rows lie in their 90% intervals (70% did when it was fitted, 60% must): about as many as when it was fitted",
        ),
        (
            59,
            0.7,
            False,
            "59% of the rows lie in their 90% intervals (70% did when it was fitted, 60% must): the intervals no longer hold",
        ),
        (
            80,
            0.7,
            True,
            "80% of the rows lie in their 90% intervals (70% did when it was fitted, 60% must): the intervals hold",
        ),
    ],
)
def test_intervals_may_lose_a_tenth_of_the_rows_of_what_they_held(inside, before, holds, said):
    training = {"interval_level": 0.9, "interval_half_widths": [2.0], "interval_covered": before}
    errors = np.repeat([2.0, -2.0, 2.1], [inside - 1, 1, 100 - inside])  # the ends belong to the interval
    found = judged(errors, static(**training))
    assert (found.covered, found.holds) == (inside / 100, holds)
    assert found.statements[1] == said


def test_every_region_has_its_interval():
    model = Model(
        (Variable("a"),), Variable("y"), (FLAT, FLAT), Split(0, 0.0, 0, 1),
        training={"interval_level": 0.9, "interval_half_widths": [1.0, 3.0]},
    )  # fmt: skip
    table = Table({"a": np.repeat([-0.5, 0.5], 10), "y": np.full(20, 2.0)}, {})
    found = validity(model, table)
    assert (found.covered, found.holds) == (0.5, False)
    assert [r["rows"] for r in found.regions] == [10, 10]
    above = validity(model, Table({"a": np.full(3, 0.5), "y": np.zeros(3)}, {}))
    assert above.statements[-1] == "no rows in 1 of its 2 regions: nothing is said about these"
    few = Model(model.inputs, model.output, model.networks, model.partition, {"interval_half_widths": [1.0]})
    assert validity(few, table).covered is None


@pytest.mark.parametrize(
    ("outside", "holds", "said"),
    [
        (0, True, None),
        (5, True, "5.0% of the rows lie outside its domain: few"),
        (6, True, "6.0% of the rows lie outside its domain: inputs were moved to the border of what it knows"),
        (50, True, "50.0% of the rows lie outside its domain: inputs were moved to the border of what it knows"),
        (51, False, "51.0% of the rows lie outside its domain: inputs were moved to the border of what it knows"),
    ],
)
def test_a_model_that_mostly_has_to_guess_does_not_hold(outside, holds, said):
    a = np.repeat([1.0, -1.0, 1.01, -1.01], [1, 99 - outside, outside // 2, outside - outside // 2])
    found = judged(np.zeros(100), static(held_out_rms=1.0), a)
    assert (found.outside, found.holds) == (outside / 100, holds)
    share = f"{outside:.1f}%"
    assert found.statements[1:] == ([] if said is None else [f"{said}; a in {share}, known from -1 m to 1 m"])


def test_inputs_that_leave_the_domain_are_named_the_worst_first():
    shares = {"a": 5, "b": 40, "c": 0, "d": 30, "e": 20, "f": 20}
    flat = Network((), (0.0,) * 6, (1.0,) * 6, (-1.0,) * 6, (1.0,) * 6, 0.0, 1.0)
    model = Model(tuple(Variable(name, "Pa") for name in shares), Variable("y"), (flat,))
    columns = {name: np.where(np.arange(100) < share, 2.0, 0.0) for name, share in shares.items()}
    table = Table({**columns, "y": np.zeros(100)}, {})
    assert validity(model, table, "si").statements[-1] == (
        "40.0% of the rows lie outside its domain: inputs were moved to the border of what it knows; b in 40.0%, known from -1 Pa to 1 Pa, "
        "d in 30.0%, known from -1 Pa to 1 Pa, e in 20.0%, known from -1 Pa to 1 Pa"
    )
    assert "b in 40.0%, known from -1e-05 bar to 1e-05 bar" in validity(model, table).statements[-1]


def test_lags_of_a_signal_are_named_as_one():
    flat = Network((), (0.0,) * 3, (1.0,) * 3, (-1.0, -1.0, -9.0), (1.0, 1.0, 9.0), 0.0, 1.0)
    read = (Variable("u[t-1]", "V"), Variable("u[t-3]", "V"), Variable("y[t-1]", "V"))
    model = Model(read, Variable("y", "V"), (flat,), dynamics=Dynamics((Lag("u", 1), Lag("u", 3), Lag("y", 1))))
    log = rows(np.zeros(103), u=np.where(np.arange(103) == 50, 2.0, 0.0))
    (found,) = run_validity([model], log)
    assert found.outside == 0.02
    assert "2.0% of the rows lie outside its domain: few; u in 2.0%, known from -1 V to 1 V" in found.statements


def test_one_reason_is_enough():
    training = {"held_out_rms": 1.0, "interval_level": 0.9, "interval_half_widths": [0.1]}
    assert not judged(np.ones(20), static(**training)).holds  # too few in their intervals, though it errs no more
    training["interval_half_widths"] = [9.0]
    assert not judged(np.full(20, 2.0), static(**training)).holds
    assert judged(np.ones(20), static(**training)).holds
    assert not judged(np.full(20, 2.0), static(**training), np.repeat([0.0, 1.01], [19, 1])).holds
    assert judged(np.ones(20), static(interval_level=0.9)).statements == judged(np.ones(20), static()).statements


def test_small_outputs_are_judged_as_large_ones_are():
    assert not judged([1e-12, -1e-12], static(held_out_rms=1e-14)).holds
    assert judged([1e-12, -1e-12], static(held_out_rms=1e-12)).holds


def test_errors_are_told_in_the_units_asked_for():
    output = Variable("y", "Pa")
    table = Table({"a": np.zeros(4), "y": np.array([1e5, -1e5, 1e5, -1e5])}, {"a": "m", "y": "Pa"})
    for units, one, two in (("metric", "1 bar", "2 bar"), ("si", "100000 Pa", "200000 Pa")):
        for training, said in (
            ({"held_out_rms": 2e5}, f"rms error {one}, {two} on rows held out when it was fitted: as good as it was"),
            ({}, f"rms error {one}; the model does not state what it was when it was fitted"),
        ):
            model = Model((Variable("a", "m"),), output, (FLAT,), training=training)
            assert validity(model, table, units).statements == [said]


def test_units_are_compared_where_both_are_known():
    rows = {"a": np.zeros(3), "y": np.zeros(3)}
    for units in ({"a": "m", "y": "V"}, {"a": "m"}, {}):
        assert validity(static(), Table(rows, units)).holds
    bare = Model((Variable("a"),), Variable("y"), (FLAT,))
    assert validity(bare, Table(rows, {"a": "m", "y": "V"})).holds
    for name, units in (("a", {"a": "mm", "y": "V"}), ("y", {"a": "m", "y": "mV"})):
        with pytest.raises(InputError, match=f"column '{name}' is in '{units[name]}'; the model was fitted in"):
            validity(static(), Table(rows, units))


def stepping(answer=0.0, unit="V", **training):
    """The next row is `answer`, whatever the last ones were."""
    flat = Network((), (0.0,), (1.0,), (-9.0,), (9.0,), answer, 1.0)
    inputs, output = (Variable("y[t-2]", unit),), Variable("y", unit)
    return Model(inputs, output, (flat,), training=training, dynamics=Dynamics((Lag("y", 2),)))


def rows(y, **columns):
    y = np.asarray(y, dtype=float)
    return Table({"time": 0.02 * np.arange(len(y)), "y": y, **columns}, {"time": "s", "y": "V"})


def test_runs_begin_anew_as_when_the_model_was_fitted():
    log = rows([5.0, 5.0, *np.tile([1.0, -1.0], 11)])
    (found,) = run_validity([stepping(free_run_rms=0.7, free_run_rows=10, one_step_rms=0.5)], log, "si")
    assert (found.rms, found.largest, found.outside, found.regions, found.holds) == (1.0, 1.0, 0.0, [], True)
    assert found.statements == [
        "3 free run(s) of up to 10 rows: rms error 1 V, 0.7 V on rows held out when it was fitted: 1.4 times what it was, and it holds up to 1.5 times",
        "one step ahead: rms error 1 V, 0.5 V when it was fitted",
        "run through without a restart, up to 22 rows: 1 V",
    ]
    for training in ({}, {"free_run_rows": 0}, {"free_run_rows": 22}):
        (whole,) = run_validity([stepping(**training)], log, "si")
        assert whole.statements == [
            "1 free run(s) of up to 22 rows: rms error 1 V; the model does not state what it was when it was fitted",
            "one step ahead: rms error 1 V",
        ]
    (single,) = run_validity([stepping(free_run_rows=1)], log, "si")
    assert single.statements[0].startswith("22 free run(s) of up to 1 rows")
    assert not run_validity([stepping(free_run_rms=0.6)], log)[0].holds


def test_inputs_of_runs_are_those_that_the_lags_read():
    y = np.zeros(22)
    y[:3] = 10.0  # beyond the domain; rows 2, 3 and 4 read them
    (found,) = run_validity([stepping()], rows(y))
    assert found.outside == 3 / 20
    with pytest.raises(InputError, match="column 'y' is in 'mV'; the model was fitted in 'V'"):
        run_validity([stepping()], Table(rows(y).columns, {"time": "s", "y": "mV"}))


def test_runs_stop_where_rows_do_not_follow_each_other():
    log = rows([5.0, 5.0, *np.tile([1.0, -1.0], 11)])
    log = Table({**log.columns, "time": log["time"] + 5.0 * (np.arange(24) >= 12)}, log.units)
    (found,) = run_validity([stepping()], log)
    assert found.statements[0].startswith("2 free run(s) of up to 10 rows: rms error")


def test_units_of_all_that_runs_read_are_compared():
    flat = Network((), (0.0, 0.0), (1.0, 1.0), (-9.0, -9.0), (9.0, 9.0), 0.0, 1.0)
    read = (Variable("u[t-1]", "A"), Variable("y[t-1]", "V"))
    model = Model(read, Variable("y", "V"), (flat,), dynamics=Dynamics((Lag("u", 1), Lag("y", 1))))
    log = rows(np.zeros(20), u=np.zeros(20))
    assert run_validity([model], Table(log.columns, {**log.units, "u": "A"}))[0].holds
    with pytest.raises(InputError, match="column 'u' is in 'mA'; the model was fitted in 'A'"):
        run_validity([model], Table(log.columns, {**log.units, "u": "mA"}))


def test_runs_are_told_in_the_units_asked_for():
    log = rows([5.0, 5.0, *np.tile([4e5, 2e5], 11)])
    model = stepping(3e5, "Pa", free_run_rms=1e5, free_run_rows=10, one_step_rms=2e5)
    for units, one, two in (("metric", "1 bar", "2 bar"), ("si", "100000 Pa", "200000 Pa")):
        (found,) = run_validity([model], Table(log.columns, {"time": "s", "y": "Pa"}), units)
        assert (found.rms, found.largest) == (1e5, 1e5)
        assert found.statements[0].startswith(
            f"3 free run(s) of up to 10 rows: rms error {one}, {one} on rows held out"
        )
        assert found.statements[-2] == f"one step ahead: rms error {one}, {two} when it was fitted"
        assert found.statements[-1] == f"run through without a restart, up to 22 rows: {one}"
