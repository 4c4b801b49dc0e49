"""Held-out errors of a machine learnt from a log, and what cannot be learnt."""

import json
from dataclasses import replace

import numpy as np
import pytest

from helpers.machine_log import changed, machine_log
from polydraulic import load_models, save_models
from polydraulic.errors import InputError
from polydraulic.identification import machine_fit, machine_judging, model_card
from polydraulic.identification.log_replay import Drift
from polydraulic.identification.machine_card import HEADS, kept, machine_coverage, summary, write_machine_card
from polydraulic.identification.machine_fit import Known, by_port, learn
from polydraulic.identification.machine_judging import as_judged, judging_rows, learn_and_judge, one_sided
from polydraulic.identification.validity import validity
from polydraulic.parameters.schema import LINKS
from polydraulic.tables import Table

OUTPUTS = ["boom.q_in", "swing.q_in", "stick.q_in", "swing.k_out", "boom.k_out", "stick.k_out"]


@pytest.fixture(scope="module")
def known(machine):
    return Known.of(machine)


@pytest.fixture(scope="module")
def log(known):
    return by_port(known, machine_log())


@pytest.fixture(scope="module")
def said():
    return []


@pytest.fixture(scope="module")
def learnt(machine, log, said):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(machine_fit, "REGIONS", 2)
        patch.setattr(machine_fit, "ROWS", 1000)
        return learn_and_judge(machine, log, lambda *call: said.append(call))


def test_errors_are_those_of_networks_that_have_not_seen_the_blocks(learnt, log, known, said):
    assert [model.output.name for model in learnt.models] == OUTPUTS
    steps = [f"{o}: {how}" for how in ("hold out", "all rows") for o in OUTPUTS]
    assert said == [(step, done, 12) for done, step in enumerate(steps)]
    edges = np.flatnonzero(np.diff(learnt.held.astype(int)))
    assert len(edges) == 7  # twenty blocks, every fifth held out
    for fit, earlier in zip(learnt.fits, learnt.without, strict=True):
        name, training = fit.model.output.name, fit.model.training
        rows = learnt.held & judging_rows(name, log, known)
        X = log.matrix([variable.name for variable in earlier.inputs])[rows]
        error = earlier.predict(X) - log[name][rows]
        assert training["held_out_rms"] == pytest.approx(np.sqrt(np.mean(error**2)))
        assert training["held_out_largest"] >= training["held_out_rms"] > 0.0
        assert sum(region["rows"] for region in training["held_out_by_region"]) == rows.sum()
        assert training["rows"] == (len(log) if training["learnt_from"] == "all rows" else np.sum(~learnt.held))
        assert 0.0 < training["held_out_flow_rms"] < 0.2 * training["pump_flow"]
    inlet, outlet = learnt.fits[0].model.training, learnt.fits[4].model.training
    assert inlet["held_out_flow_rms"] == pytest.approx(inlet["held_out_rms"])
    rows = learnt.held & judging_rows("boom.k_out", log, known)
    error = learnt.fits[4].held.predicted - learnt.fits[4].held.y
    flows = error * log["boom.root_p_out"][rows]
    assert outlet["held_out_flow_rms"] == pytest.approx(np.sqrt(np.mean(flows**2)))


def test_a_search_that_ended_worse_with_all_rows_is_not_released(machine, log, monkeypatch):
    def learn(machine, rows, progress):
        scale = 1.6 if len(rows) == len(log) else 1.0  # all rows: too much flow
        other = Table(
            {name: v * (scale if name.endswith("q_in") else 1.0) for name, v in rows.columns.items()}, rows.units
        )
        return original(machine, other, progress)

    original = machine_judging.learn
    monkeypatch.setattr(machine_judging, "learn", learn)
    monkeypatch.setattr(machine_fit, "REGIONS", 1)
    monkeypatch.setattr(machine_fit, "ROWS", 500)
    found = learn_and_judge(machine, log)
    sources = [fit.model.training["learnt_from"] for fit in found.fits]
    assert sources[:3] == ["rows not held out"] * 3
    assert found.models[0] is found.without[0]
    assert kept(found.fits).endswith(
        ": " + ", ".join(o for o, s in zip(OUTPUTS, sources, strict=True) if s != "all rows")
    )


def test_rows_at_the_relief_setting_say_nothing(machine, log, known, monkeypatch):
    monkeypatch.setattr(machine_fit, "REGIONS", 1)
    monkeypatch.setattr(machine_fit, "ROWS", 500)
    rows = judging_rows("boom.q_in", log, known)
    assert log["boom.p_in"][rows].max() < known.relief
    stopped = (log["boom.travel"] > known.deadband) & ~rows
    assert stopped.sum() > 0
    other = Table(log.columns | {"boom.q_in": np.where(stopped, 0.5, 1.0) * log["boom.q_in"]}, log.units)
    assert learn(machine, other)[0] == learn(machine, log)[0]


def test_a_table_in_the_units_of_the_field(learnt):
    rows = summary(learnt.fits)
    assert [row[0] for row in rows] == OUTPUTS
    training = learnt.fits[0].model.training
    assert float(rows[0][HEADS.index("rms [l/min]")]) == pytest.approx(6e4 * training["held_out_flow_rms"], abs=0.006)
    share = 100.0 * training["held_out_flow_rms"] / training["pump_flow"]
    assert float(rows[0][HEADS.index("of the pump")].rstrip("%")) == pytest.approx(share, abs=0.006)


def test_a_model_file_reads_another_log_by_itself(learnt, tmp_path):
    save_models(learnt.models, tmp_path / "machine.json")
    later = machine_log(40.0, seed=2)
    models = load_models(tmp_path / "machine.json")
    judged = {model.output.name: validity(model, as_judged(model, later)) for model in models}
    expected = models[0].training["held_out_rms"]
    assert judged["boom.q_in"].rms < 4.0 * expected
    worn = changed(later, boom_q_in=0.7 * later["boom.q_in"])  # a pump that has lost a third of its flow
    assert validity(models[0], as_judged(models[0], worn)).rms > 4.0 * judged["boom.q_in"].rms
    assert not validity(models[0], as_judged(models[0], worn)).holds
    with pytest.raises(InputError, match=r"column 'swing.q_in' is in 'l/min'"):
        as_judged(models[0], Table(later.columns, {**later.units, "swing.q_in": "l/min"}))
    still = changed(later, boom_spool=np.zeros(len(later)))
    with pytest.raises(InputError, match=r"no row of 2001 says anything of 'boom.q_in': its valve never opens"):
        as_judged(models[0], still)


def test_tables_of_other_models_stay_as_they_are(learnt):
    model = replace(learnt.models[0], training={})
    assert as_judged(model, (table := machine_log())) is table


def test_the_card_holds_all_networks_and_the_holes(machine, learnt, log, tmp_path, monkeypatch):
    monkeypatch.setattr(model_card, "_EFFORT", 2)
    monkeypatch.setattr(model_card, "_SHOWN", 1)
    covered = {c.output: c for c in machine_coverage(machine, learnt.models, log)}
    assert list(covered) == OUTPUTS
    assert covered["boom.q_in"].found.box["boom.p_in"] == (0.0, machine.pumps.relief)
    assert 0.1 < covered["swing.q_in"].share < 1.0
    drift = [Drift("boom", "deg", 0.1, np.inf, 20.0)]  # one run left all reason
    card = write_machine_card(machine, learnt, log, "log.parquet", tmp_path / "card.html", drift, "run so & so")
    assert [model["output"].split(" ")[0] for model in card["models"]] == OUTPUTS
    assert {column["name"] for column in card["data"]["columns"]} >= {"boom.travel", "stick.spool", "series.q_passed"}
    assert [c["output"] for c in card["data"]["coverage"]] == OUTPUTS
    assert any("no rows with" in hole and "bar" in hole for c in card["data"]["coverage"] for hole in c["holes"])
    assert card["data"]["drift"] == [{"name": "boom", "unit": "deg", "median": 0.1, "largest": None, "moved": 20.0}]
    assert json.loads((tmp_path / "card.card.json").read_text()) == card
    page = (tmp_path / "card.html").read_text()
    for text in (
        "Run so &amp; so",
        "0.10 deg",
        "inf deg",
        "Proved",
        "90% intervals",
        "Where the log has been",
        "l/min",
    ):
        assert text in page
    assert page.count("data:image/svg+xml") == 6 + 2 * 6  # maps; errors and drawings


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"boom_spool": lambda x: 1000.0 * x}, r"boom.spool goes to \S+ m; the machine's goes to 0.01433 m: give the channel map"),
        ({"stick_q_in": lambda x: 6e4 * x}, r"stick.q_in goes to \S+ m3/s; the machine's goes to 0.00281 m3/s"),
        ({"swing_p_a": lambda x: 1e-5 * x, "swing_p_b": lambda x: 1e-5 * x}, r"swing.p_a and swing.p_b go to \S+ Pa; the relief valve"),
        ({"swing_spool": lambda x: 0.2 * x}, r"swing.spool goes to 0.00\d+ m in 4501 rows and its valve opens at 0.004775 m: nothing"),
    ],
)  # fmt: skip
def test_numbers_that_cannot_be_are_named(machine, known, columns, message):
    table = machine_log()
    other = {name: change(table[name.replace("_", ".", 1)]) for name, change in columns.items()}
    with pytest.raises(InputError, match=message):
        learn_and_judge(machine, by_port(known, changed(table, **other)))


@pytest.mark.parametrize("n", [1, 100, 600])
def test_a_short_log_is_refused(machine, known, n):
    short = Table({name: values[200 : 200 + n] for name, values in machine_log().columns.items()}, {})
    with pytest.raises(InputError, match=r"rows say something of it, .* record longer|nothing can be learnt of it"):
        learn_and_judge(machine, by_port(known, short))


def test_a_spool_that_moves_one_way_alone_is_told(known):
    table = machine_log()
    assert one_sided(by_port(known, table), known) == []
    one_way = by_port(known, changed(table, boom_spool=np.abs(table["boom.spool"])))
    (statement,) = one_sided(one_way, known)
    assert statement.startswith("boom.spool opens its valve to the negative side in 0 of 4501 rows")


def test_every_link_is_judged_by_open_valves(log, known):
    for link in LINKS:
        assert np.all(log[f"{link}.travel"][judging_rows(f"{link}.k_out", log, known)] > known.deadband)
