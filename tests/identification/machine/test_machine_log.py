"""What circuits see, from what sensors read."""

import json

import numpy as np
import pytest

from helpers.machine_log import machine_log
from polydraulic.errors import InputError
from polydraulic.identification.machine.machine_log import Known, KnownCircuit, by_port, judged_by, judging_rows
from polydraulic.networks import Model, Network, Variable
from polydraulic.tables import Table
from polydraulic.thesis.excavator import LINKS


def test_a_missing_channel_is_named(machine):
    with pytest.raises(InputError, match=r"no column 'swing.spool'"):
        by_port(Known.of(machine), Table({"boom.spool": np.zeros(3)}, {}))


def test_units_are_those_of_si(machine):
    log = machine_log()
    with pytest.raises(InputError, match=r"column 'boom.p_a' is in 'bar'; a machine is learnt in SI, this in 'Pa'"):
        by_port(Known.of(machine), Table(log.columns, {**log.units, "boom.p_a": "bar"}))
    seen = by_port(Known.of(machine), log)
    assert {name: seen.unit(name) for name in ("time", "boom.travel", "boom.k_out", "series.q_passed")} == {
        "time": "s", "boom.travel": "m", "boom.k_out": "m3/s/Pa^0.5", "series.q_passed": "m3/s",
    }  # fmt: skip
    for link in LINKS:
        forward = log[f"{link}.spool"] > 0.0
        assert np.all(seen[f"{link}.p_in"][forward] == np.maximum(log[f"{link}.p_a"][forward], 0.0))


def test_a_closed_bypass_passes_nothing_on_whatever_enters_its_line(machine):
    known, log = Known.of(machine), machine_log()
    at = known.circuits["series"]
    assert at.closes == pytest.approx((0.0095504, 0.0095504))
    spool = np.where(np.arange(len(log)) % 2 == 0, 0.012, 0.009)
    seen = by_port(
        known, Table(log.columns | {"swing.spool": spool, "swing.q_in": np.full(len(log), 0.4 * at.flow)}, log.units)
    )
    assert np.all(seen["series.q_passed"][::2] == 0.0)
    assert seen["series.q_passed"][1::2] == pytest.approx(0.6 * at.flow)


def test_rows_with_a_shut_valve_or_at_relief_say_nothing(machine):
    known = Known.of(machine)
    log = by_port(known, machine_log())
    for link in LINKS:
        assert np.all(log[f"{link}.travel"][judging_rows(f"{link}.k_out", log, known)] > known.deadband[link])
        assert log[f"{link}.p_in"][judging_rows(f"{link}.q_in", log, known)].max() < 0.98 * known.circuit(link).relief


def test_a_bypass_that_never_closes_stands_in_a_model_file(machine):
    known = Known.of(machine)
    open_ = known.circuits["series"]._replace(closes=(np.inf, 0.01))
    known = known._replace(circuits={**known.circuits, "series": open_})
    data = json.loads(json.dumps(known.to_data(), allow_nan=False))
    assert Known.from_data(data) == known


@pytest.mark.parametrize(
    "change", [{"circuits": 3}, {"circuits": {"series": 1}}, {"deadband": {"boom": "wide"}}, {"return_pressure": None}]
)
def test_a_model_that_does_not_say_how_to_read_a_log_is_refused(machine, change):
    network = Network((), (0.0,), (1.0,), (0.0,), (1.0,), 0.0, 1.0)
    how = {**Known.of(machine).to_data(), **change}
    model = Model((Variable("boom.p_in", "Pa"),), Variable("boom.q_in", "m3/s"), (network,), training={"log": how})
    with pytest.raises(InputError, match="the model of 'boom.q_in' does not say how to read a log"):
        judged_by(model)


@pytest.mark.parametrize(
    ("output", "column", "limit", "says_below"),
    [("boom.q_in", "boom.p_a", 0.98 * 3e7, True), ("boom.k_out", "boom.p_b", 75.0 * 6894.757 + 1e5, False)],
)
def test_rows_say_something_below_the_relief_setting_and_with_75_psi_at_an_outlet(output, column, limit, says_below):
    known = Known(1e5, {"boom": 4e-3}, {"boom": KnownCircuit(2e-3, 3e7, ("boom",), (1.0,))})
    usual = {"boom.spool": 5e-3, "boom.p_a": 1e7, "boom.p_b": 4e6, "boom.q_in": 1e-3, "boom.q_out": 1e-3}
    values = {name: np.full(2, value) for name, value in usual.items()} | {column: limit * np.array([0.999, 1.001])}
    log = by_port(known, Table(values, {}))
    assert judging_rows(output, log, known).tolist() == [says_below, not says_below]
    # a conductance is that of the drop, or of 75 psi where it is less
    drop = np.maximum(log["boom.root_p_out"], np.sqrt(75.0 * 6894.757))
    assert log["boom.k_out"] == pytest.approx(1e-3 / drop, rel=1e-6)
