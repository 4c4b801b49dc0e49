"""Networks of what circuits leave are kept where they hold on blocks of time that they have not seen, and nowhere else."""

from types import SimpleNamespace

import numpy as np
import pytest

from helpers.machine_log import machine_log
from polydraulic import InputError, load_machine
from polydraulic.identification import learn_residuals
from polydraulic.identification.equations.residuals import residual_rows
from polydraulic.tables import Table

SECONDS = 120.0


@pytest.fixture(scope="module")
def log():
    return machine_log(SECONDS)


def found_in(log, **columns):
    """What an identification that has found the truth leaves to be learnt."""
    other = Table({**log.columns, **columns}, log.units)
    return SimpleNamespace(machine=load_machine("cat215b"), table=other)


def test_what_the_equations_do_not_have_is_learnt(log):
    open_ = np.abs(log["boom.spool"]) > 6e-3
    p_in = np.where(log["boom.spool"] > 0.0, log["boom.p_a"], log["boom.p_b"])
    lost = np.where(open_, 2e-4 + 1e-11 * p_in, 0.0)
    learnt = learn_residuals(found_in(log, **{"boom.q_in": log["boom.q_in"] - lost}))
    boom = next(r for r in learnt.judged if r.function == "boom")
    assert boom.kept
    assert boom.after < 0.6 * boom.before
    assert boom.low < -0.05
    assert boom.high < 0.1
    assert [m.output.name for m in learnt.models if m.output.name.startswith("boom")] == ["boom.q_in_residual"]
    assert "boom" in str(learnt)
    assert "yes" in str(learnt)


def test_nothing_is_kept_where_equations_hold(log):
    quiet = {f"{name}.q_in": log[f"{name}.q_in"] for name in ("swing", "boom", "stick")}
    learnt = learn_residuals(found_in(log, **quiet))
    assert all(r.before < 0.05 for r in learnt.judged)
    assert all(r.after > 0.8 * r.before for r in learnt.judged)


def test_rows_are_those_of_a_run(log):
    machine = load_machine("cat215b")
    at, off = residual_rows(machine, machine.circuit("boom"), log)
    assert at.shape == (len(log), 2)
    open_ = np.abs(log["boom.spool"]) > 6e-3
    assert at[open_, 0] == pytest.approx(np.abs(log["boom.spool"][open_]), abs=1e-3)
    assert np.isnan(off[np.abs(log["boom.spool"]) < 3e-3]).all()
    told = np.isfinite(off)
    assert np.median(np.abs(off[told])) < 0.02 * machine.circuit("boom").pump.flow


def test_circuits_without_sensors_are_named(log):
    few = Table({n: log[n] for n in log.names if n != "stick.q_in"}, log.units)
    learnt = learn_residuals(SimpleNamespace(machine=load_machine("cat215b"), table=few))
    assert [r.function for r in learnt.judged] == ["boom"]
    assert learnt.lacks == ["circuits.series: no network of what is left; the log has no stick.q_in"]
    with pytest.raises(InputError, match="the log has no boom.q_in"):
        none = Table({n: log[n] for n in log.names if not n.endswith(".q_in")}, log.units)
        learn_residuals(SimpleNamespace(machine=load_machine("cat215b"), table=none))
