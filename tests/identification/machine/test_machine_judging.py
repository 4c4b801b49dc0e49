"""What a machine's networks are judged by: every threshold from both sides, on logs made for it."""

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.identification.arguments import table_of
from polydraulic.identification.machine.machine_judging import (
    check_numbers,
    check_rows,
    held_out,
    judged_network,
    one_sided,
    weak,
)
from polydraulic.identification.machine.machine_log import Known, KnownCircuit, by_port
from polydraulic.networks import Model, Network, Variable
from polydraulic.tables import Table

OPENS, RELIEF, FLOW = 4e-3, 3e7, 2e-3
KNOWN = Known(0.0, {"boom": OPENS}, {"boom": KnownCircuit(FLOW, RELIEF, ("boom",), (inf,))})


def log(n=1001, **columns):
    """What sensors of a boom read that moves all the time."""
    usual = {"spool": 5e-3, "p_a": 1e7, "p_b": 4e6, "q_in": 1e-3, "q_out": 1e-3}
    values = {f"boom.{name}": columns.get(name, value) + np.zeros(n) for name, value in usual.items()}
    return by_port(KNOWN, Table({"time": 0.02 * np.arange(n), **values}, {}))


def some(value, n, rest, of=1001):
    """So many rows with another value than the rest."""
    return np.where(np.arange(of) < n, value, rest)


@pytest.mark.parametrize(
    ("name", "most", "unit"), [("spool", 14.3256e-3, "m"), ("q_in", FLOW, "m3/s")], ids=["spool", "q_in"]
)
def test_a_hundredth_of_the_rows_may_go_half_beyond_what_the_machine_can_do(machine, name, most, unit):
    for value, n in ((1.499 * most, 1001), (-1.499 * most, 1001), (1.501 * most, 10)):
        check_numbers(machine, KNOWN, log(**{name: some(value, n, 1e-3)}))
    for sign in (1.0, -1.0):
        told = f"boom.{name} goes to {1.501 * most:.4g} {unit}; the machine's goes to {most:.4g} {unit}: give"
        with pytest.raises(InputError, match=told):
            check_numbers(machine, KNOWN, log(**{name: some(sign * 1.501 * most, 12, 1e-3)}))


@pytest.mark.parametrize(
    ("highest", "n", "named"),
    [
        (1.01e5, 1001, None),
        (9.9 * RELIEF, 40, None),  # in few rows: more beyond 2000 bar are no Pa
        (10.1 * RELIEF, 10, None),
        (10.1 * RELIEF, 12, "3.03e\\+08 Pa; the relief valve opens at 3e\\+07 Pa"),
        (9.9e3, 1001, "9900 Pa; the relief valve opens at 3e\\+07 Pa"),
        (1.01e4, 1001, "the largest pressure at a port of the log is 1.01e\\+04 Pa"),
    ],
)
def test_pressures_lie_between_a_tenth_of_a_bar_and_ten_times_the_relief_setting(machine, highest, n, named):
    for port, other in (("p_a", "p_b"), ("p_b", "p_a")):
        table = log(**{port: some(highest, n, min(highest, 1e6)), other: 0.0})
        if named is None:
            check_numbers(machine, KNOWN, table)
        else:
            with pytest.raises(InputError, match=named):
                check_numbers(machine, KNOWN, table)


@pytest.mark.parametrize(("learnt", "held", "enough"), [(200, 50, True), (199, 50, False), (200, 49, False)])
@pytest.mark.parametrize(("what", "useless"), [("q_in", {"p_a": 0.99 * RELIEF}), ("k_out", {"p_b": 4e5})])
def test_two_hundred_rows_teach_a_network_and_fifty_judge_it(what, useless, learnt, held, enough):
    rows = np.arange(1000)
    says = (rows < learnt) | ((rows >= 500) & (rows < 500 + held))
    (port, value), usual = *useless.items(), {"p_a": 1e7, "p_b": 4e6}
    table = log(1000, **{port: np.where(says, usual[port], value)})
    if enough:
        check_rows(table, rows >= 500, KNOWN)
    else:
        told = f"boom.{what}: {learnt} rows are of use to it, and {held} in the blocks of time held out; it takes 200 and 50"
        with pytest.raises(InputError, match=told):
            check_rows(table, rows >= 500, KNOWN)


def test_a_valve_that_never_opens_teaches_nothing():
    with pytest.raises(InputError, match=r"boom.spool goes to 0.004 m in 1001 rows and its valve opens at 0.004 m"):
        check_rows(log(spool=OPENS), np.zeros(1001, dtype=bool), KNOWN)
    with pytest.raises(InputError, match=r"boom.spool goes to 0 m in 0 rows and its valve opens at 0.004 m"):
        check_rows(log(0), np.zeros(0, dtype=bool), KNOWN)


@pytest.mark.parametrize(("n", "sides"), [(60, []), (59, ["negative"])])
def test_an_outlet_is_learnt_from_sixty_rows(n, sides):
    found = one_sided(log(spool=some(-5e-3, n, 5e-3)), KNOWN)
    told = "boom.spool opens its valve to the {} side in {} of 1001 rows: nothing is known of it there"
    assert found == [told.format(side, n) for side in sides]
    assert one_sided(log(spool=some(OPENS, 900, -5e-3)), KNOWN) == [told.format("positive", 0)]


@pytest.mark.parametrize(("r2", "share", "named"), [(0.9, 0.05, False), (0.899, 0.05, True), (0.9, 0.0501, True)])
def test_a_network_is_weak_below_nine_tenths_or_beyond_a_twentieth_of_the_pumps_flow(r2, share, named):
    model = SimpleNamespace(
        output=SimpleNamespace(name="q"), training={"held_out_flow_rms": 2.0 * share, "pump_flow": 2.0}
    )
    assert bool(weak([SimpleNamespace(model=model, r2=r2)])) == named


@pytest.mark.parametrize(("n", "blocks"), [(29_000, 20), (32_000, 21)])  # at 20 ms: 19.3 and 21.3 times half a minute
def test_blocks_last_half_a_minute_and_are_twenty_at_least(n, blocks):
    held = held_out(Table({"time": 0.02 * np.arange(n)}, {}))
    ends = np.flatnonzero(np.diff(held.astype(int)) == 1) + 1
    assert ends[0] == pytest.approx(4 * n / blocks, abs=1)
    assert held_out(Table({"time": np.zeros(1)}, {})).tolist() == [False]


def test_no_block_goes_over_the_end_of_one_of_several_logs():
    several, _ = table_of([Table({"time": 0.02 * np.arange(n), "x": np.arange(n) + n}, {}) for n in (310, 690)])
    held = held_out(several)
    counts = [held[:310].sum(), held[310:].sum()]
    assert counts == pytest.approx([60, 140], abs=50)
    assert not np.array_equal(held, held_out(Table(several.columns, {})))


def answering(value, output):
    flat = Network((), (0.0,), (1.0,), (-1.0,), (1.0,), value, 1.0)
    return Model((Variable("boom.travel", "m"),), Variable(output), (flat,))


@pytest.mark.parametrize(("off", "released"), [(2.199, True), (-2.199, True), (2.201, False), (-2.201, False)])
@pytest.mark.parametrize(("output", "drop"), [("boom.q_in", 1.0), ("boom.k_out", 2000.0)])
def test_what_errs_by_a_tenth_more_with_all_rows_is_not_released(off, released, output, drop):
    """It has seen the rows held out; the errors that are stated are those of the one that has not, which errs by 2."""
    table, held = log(q_in=8.0, q_out=8.0 * 2000.0), some(True, 200, False)
    one, earlier = answering(8.0 + off, output), answering(6.0, output)
    fit = judged_network(KNOWN, table, held, one, earlier)
    assert fit.model is (one if released else earlier)
    said = fit.model.training
    assert (said["learnt_from"], said["rows"]) == (("all rows", 1001) if released else ("rows not held out", 801))
    assert (fit.rms, said["held_out_rms"], said["pump_flow"], said["log"]) == (2.0, 2.0, FLOW, KNOWN.to_data())
    assert (said["held_out_flow_rms"], said["held_out_flow_largest"]) == (
        2.0 * drop,
        2.0 * drop,
    )  # by the root of 40 bar
    assert (len(fit.held.y), said["held_out"]) == (200, "blocks of time")
