"""Networks of what circuits leave are kept where they hold on blocks of time that they have not seen, and nowhere else."""

from types import SimpleNamespace

import numpy as np
import pytest

from helpers.lagging_log import LAG, SPRING, lagging_log
from helpers.machine_log import machine_log
from polydraulic import InputError, load_machine
from polydraulic.identification import learn_residuals
from polydraulic.identification.equations import residuals
from polydraulic.identification.equations.residuals import _learnt, residual_rows
from polydraulic.networks import Model, Network
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


def test_spools_are_driven_with_the_effects_that_the_machine_declares(log):
    lagging, machine = lagging_log(), load_machine("cat215b")
    table = Table({**lagging.columns, "boom.q_in": log["boom.q_in"]}, log.units)
    boom = machine.function("boom")
    knowing = boom._replace(effects=boom.effects._replace(hysteresis=LAG, flow_force=SPRING))
    off = {}
    for name, f in (("none", boom), ("both", knowing)):
        own = machine._replace(functions=tuple(f if g.name == "boom" else g for g in machine.functions))
        at, _ = residual_rows(own, own.circuit("boom"), table)
        off[name] = np.std(at[:, 0] - np.abs(table["boom.spool"]))
    assert off["both"] < 8e-5 < 2e-4 < off["none"]


def test_circuits_without_sensors_are_named(log):
    few = Table({n: log[n] for n in log.names if n != "stick.q_in"}, log.units)
    learnt = learn_residuals(SimpleNamespace(machine=load_machine("cat215b"), table=few))
    assert [r.function for r in learnt.judged] == ["boom"]
    assert learnt.lacks == ["circuits.series: no network of what is left; the log has no stick.q_in"]
    with pytest.raises(InputError, match="the log has no boom.q_in"):
        none = Table({n: log[n] for n in log.names if not n.endswith(".q_in")}, log.units)
        learn_residuals(SimpleNamespace(machine=load_machine("cat215b"), table=none))


class Halving:
    """In place of a network: of what its first input says is left it gives the share that the second one says."""

    bounds: list = []  # noqa: RUF012

    def __init__(self, output_bounds):
        self.bounds.append(output_bounds)

    def fit(self, at, off):
        assert len(at) == len(off)
        return self

    def predict(self, at):
        return at[:, 0] * at[:, 1]

    def to_model(self, inputs, output):
        flat = Network((), (0.0,) * 2, (1.0,) * 2, (-1.0,) * 2, (1.0,) * 2, 0.0, 1.0)
        return Model(tuple(inputs), output, (flat,))


def judged_with(monkeypatch, *, n=1400, held=280, shares=(0.5,) * 4, empty=()):
    """What is said of networks that give such shares of what is left in the four blocks held out of twenty."""
    monkeypatch.setattr(residuals, "AbductiveRegressor", Halving)
    machine = load_machine("cat215b")
    time = np.arange(n) / n
    block = np.arange(n) * 20 // n
    hold = block % 5 == 4
    kept = ~hold | ((np.cumsum(hold[::-1])[::-1] <= held) & ~np.isin(block, empty))
    off = np.where(np.arange(n) % 2, 1e-4, -1e-4)
    at = np.column_stack([off, np.array(shares)[block // 5]])[kept]
    return _learnt(machine, machine.circuit("boom"), "boom", at, off[kept], time[kept])


@pytest.mark.parametrize(
    ("shares", "kept"),
    [
        ((0.0515,) * 4, True),  # what is left of the squares: (1 - share)^2
        ((0.0510,) * 4, False),
        ((0.9, 0.9, 0.9, -0.1), True),
        ((0.9, 0.9, -0.1, -0.1), False),  # half of the blocks are no most
    ],
)
def test_a_network_saves_a_tenth_of_the_squares_and_helps_in_most_blocks(monkeypatch, shares, kept):
    found, _ = judged_with(monkeypatch, shares=shares)
    flow = load_machine("cat215b").circuit("boom").pump.flow
    assert found.kept == kept
    assert found.before == pytest.approx(1e-4 / flow)
    assert found.after == pytest.approx(1e-4 / flow * np.sqrt(np.mean((1.0 - np.array(shares)) ** 2)))


@pytest.mark.parametrize(
    ("rows", "enough"),
    [({"held": 200}, True), ({"held": 199}, False), ({"empty": (4,)}, True), ({"empty": (4, 9)}, False)],
)
def test_two_hundred_rows_of_three_blocks_judge_a_network(monkeypatch, rows, enough):
    assert (judged_with(monkeypatch, **rows) is not None) == enough


def test_a_network_gives_no_more_than_all_but_a_thousandth_of_what_was_left(monkeypatch):
    monkeypatch.setattr(residuals, "AbductiveRegressor", Halving)
    Halving.bounds.clear()
    machine, off = load_machine("cat215b"), np.arange(4001.0) - 2000.0
    _learnt(machine, machine.circuit("boom"), "boom", np.zeros((4001, 2)), off, np.arange(4001.0))
    assert Halving.bounds == [pytest.approx((-1996.0, 1996.0))] * 2


@pytest.mark.parametrize(("share", "told"), [(0.949, True), (0.951, False)])
def test_rows_near_the_relief_setting_say_nothing(log, share, told):
    machine = load_machine("cat215b")
    p = np.full(len(log), share * machine.circuit("boom").pump.relief)
    near = Table({**log.columns, "boom.p_a": p, "boom.p_b": p}, log.units)
    _, off = residual_rows(machine, machine.circuit("boom"), near)
    assert np.isfinite(off).any() == told
