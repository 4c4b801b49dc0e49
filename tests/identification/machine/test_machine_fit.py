"""Held-out errors of a machine learnt from a log, and what cannot be learnt."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from helpers.machine_log import changed, machine_log
from polydraulic import build_flow, load_machine, load_models, save_models
from polydraulic.errors import InputError
from polydraulic.flow import sample_circuit
from polydraulic.identification import Drift, fit_machine, machine_coverage, write_card
from polydraulic.identification.log_replay import drift_rows
from polydraulic.identification.machine import machine_fit
from polydraulic.identification.machine.machine_fit import heads, kept, summary
from polydraulic.identification.machine.machine_judging import contradicted, held_out, one_sided, weak
from polydraulic.identification.machine.machine_log import Known, as_judged, by_port, judging_rows
from polydraulic.identification.validity import validity
from polydraulic.tables import Table
from polydraulic.thesis.excavator import pump_of
from polydraulic.unit_table import CUBIC_INCH

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


def silent():
    """The log without voltages: nothing is run against it."""
    table = machine_log()
    return Table({name: v for name, v in table.columns.items() if not name.endswith("voltage")}, table.units)


@pytest.fixture(scope="module")
def learnt(machine, said):
    def tell(*step):
        said.append(step)

    return fit_machine(silent(), machine, max_regions=2, max_rows=400, progress=tell)


def test_errors_are_those_of_networks_that_have_not_seen_the_blocks(learnt, log, known, said):
    assert [model.output.name for model in learnt.models] == OUTPUTS
    assert said == [(what, done, 7) for done, what in enumerate([*OUTPUTS, "run against the log"])]
    edges = np.flatnonzero(np.diff(learnt.held.astype(int)))
    assert len(edges) == 7  # twenty blocks, every fifth held out
    for fit, earlier in zip(learnt.outputs, learnt.without, strict=True):
        assert fit.model.partition == earlier.partition or not fit.model.output.name.endswith("q_in")
        name, training = fit.model.output.name, fit.model.training
        rows = learnt.held & judging_rows(name, log, known)
        X = log.matrix([variable.name for variable in earlier.inputs])[rows]
        error = earlier.predict(X) - log[name][rows]
        assert training["held_out_rms"] == pytest.approx(np.sqrt(np.mean(error**2)))
        assert training["held_out_largest"] >= training["held_out_rms"] > 0.0
        assert sum(region["rows"] for region in training["held_out_by_region"]) == rows.sum()
        assert training["rows"] == (len(log) if training["learnt_from"] == "all rows" else np.sum(~learnt.held))
        assert 0.0 < training["held_out_flow_rms"] < 0.2 * training["pump_flow"]
    inlet, outlet = learnt.outputs[0].model.training, learnt.outputs[4].model.training
    assert inlet["held_out_flow_rms"] == pytest.approx(inlet["held_out_rms"])
    rows = learnt.held & judging_rows("boom.k_out", log, known)
    error = learnt.outputs[4].held.predicted - learnt.outputs[4].held.y
    flows = error * log["boom.root_p_out"][rows]
    assert outlet["held_out_flow_rms"] == pytest.approx(np.sqrt(np.mean(flows**2)))


def test_a_search_that_ended_worse_with_all_rows_is_not_released(machine, log, monkeypatch):
    def tasks_of(machine, known, rows, **options):
        scale = 1.6 if len(rows) == len(log) else 1.0  # all rows: too much flow
        other = Table(
            {name: v * (scale if name.endswith("q_in") else 1.0) for name, v in rows.columns.items()}, rows.units
        )
        return original(machine, known, other, **options)

    original = machine_fit.tasks_of
    monkeypatch.setattr(machine_fit, "tasks_of", tasks_of)
    found = fit_machine(silent(), machine, max_regions=1, max_rows=500)
    sources = [fit.model.training["learnt_from"] for fit in found.outputs]
    assert sources[:3] == ["rows not held out"] * 3
    assert found.models[0] is found.without[0]
    names = ", ".join(o for o, s in zip(OUTPUTS, sources, strict=True) if s != "all rows")
    assert kept(found.outputs).endswith(f": {names}")
    assert kept(found.outputs) in str(found).splitlines()


def test_a_table_in_the_units_asked_for(learnt):
    rows = summary(learnt.outputs)
    assert [row[0] for row in rows] == OUTPUTS
    training = learnt.outputs[0].model.training
    assert float(rows[0][heads().index("rms [l/min]")]) == pytest.approx(6e4 * training["held_out_flow_rms"], rel=0.006)
    share = 100.0 * training["held_out_flow_rms"] / training["pump_flow"]
    assert float(rows[0][heads().index("of the pump")].rstrip("%")) == pytest.approx(share, abs=0.006)
    field = summary(learnt.outputs, "field")
    assert float(field[0][heads("field").index("rms [in3/s]")]) == pytest.approx(
        training["held_out_flow_rms"] / CUBIC_INCH, rel=0.006
    )
    assert "rms [in3/s]" in learnt.text("field")
    drift = [Drift("boom", "rad", np.radians(0.5), np.inf, 0.5), Drift("tip", "m", 0.012, 0.5, 2.0)]
    assert drift_rows(drift) == [["boom", "0.50 deg", "diverged", "28.65 deg"], ["tip", "12 mm", "500 mm", "2000 mm"]]
    assert drift_rows(drift, "si")[1] == ["tip", "0.012 m", "0.500 m", "2.000 m"]
    lines = str(learnt).splitlines()
    assert lines[0].startswith(f"{learnt.held.sum()} of 4501 rows held out, every fifth block of time")
    assert lines[2].split()[:2] == rows[0][:2]
    assert lines[-2] == learnt.windows == "not run against the log: it has no swing.voltage"
    assert lines[-1].startswith("warning: weak on the rows held out: ")


def test_blocks_last_half_a_minute_of_a_long_log():
    minutes = np.arange(0.0, 1200.0, 0.1)
    held = held_out(Table({"time": minutes}, {}))
    edges = np.flatnonzero(np.diff(held.astype(int))) + 1
    assert set(np.diff(edges)) == {300, 1200}
    assert held.sum() == 2400
    few = held_out(Table({"time": minutes}, {}), 60)
    assert set(np.diff(np.flatnonzero(np.diff(few.astype(int))))) == {200, 800}


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
    with pytest.raises(InputError, match=r"no row of 2001 says anything about 'boom.q_in': its valve never opens"):
        as_judged(models[0], still)


def test_tables_of_other_models_stay_as_they_are(learnt):
    model = replace(learnt.models[0], training={})
    assert as_judged(model, (table := machine_log())) is table


def test_the_card_holds_all_networks_and_the_holes(machine, learnt, tmp_path):
    covered = {c.output: c for c in machine_coverage(machine_log(), learnt.models, machine)}
    assert list(covered) == OUTPUTS
    assert covered["boom.q_in"].found.box["boom.p_in"] == (0.0, pump_of(machine, "boom").relief)
    assert 0.1 < covered["swing.q_in"].share < 1.0
    drift = [Drift("boom", "rad", 0.1, np.inf, 2.0)]  # one run diverged
    told = replace(learnt, drifts=drift, windows="run so & so")
    card = write_card(told, tmp_path / "card.html", source="log.parquet", max_boxes=2, shown=1)
    assert card["data"]["source"] == "log.parquet"
    assert [model["output"].split(" ")[0] for model in card["models"]] == OUTPUTS
    assert {column["name"] for column in card["data"]["columns"]} >= {"boom.travel", "stick.spool", "series.q_passed"}
    assert [c["output"] for c in card["data"]["coverage"]] == OUTPUTS
    assert any("no rows with" in hole and "bar" in hole for c in card["data"]["coverage"] for hole in c["holes"])
    assert card["data"]["drift"] == [{"name": "boom", "unit": "rad", "median": 0.1, "largest": None, "moved": 2.0}]
    assert json.loads((tmp_path / "card.card.json").read_text()) == card
    page = (tmp_path / "card.html").read_text()
    for text in (
        "Run so &amp; so",
        "5.73 deg",
        "diverged",
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
        ({"swing_p_a": lambda x: 1e-5 * x}, r"column 'swing.p_a' comes to \S+ Pa at most, others to .* bar: it must be in Pa"),
        ({"swing_spool": lambda x: 0.2 * x}, r"swing.spool goes to 0.00\d+ m in 4501 rows and its valve opens at 0.004775 m: nothing"),
    ],
)  # fmt: skip
def test_numbers_that_cannot_be_are_named(machine, columns, message):
    table = machine_log()
    other = {name: change(table[name.replace("_", ".", 1)]) for name, change in columns.items()}
    with pytest.raises(InputError, match=message):
        fit_machine(changed(table, **other), machine)


@pytest.mark.parametrize("n", [1, 100, 600])
def test_a_short_log_is_refused(machine, n):
    short = Table({name: values[200 : 200 + n] for name, values in machine_log().columns.items()}, {})
    with pytest.raises(InputError, match=r"rows are of use to it, .* record longer|nothing can be learnt of it"):
        fit_machine(short, machine)


def test_a_spool_that_moves_one_way_alone_is_told(known):
    table = machine_log()
    assert one_sided(by_port(known, table), known) == []
    one_way = by_port(known, changed(table, boom_spool=np.abs(table["boom.spool"])))
    (statement,) = one_sided(one_way, known)
    assert statement.startswith("boom.spool opens its valve to the negative side in 0 of 4501 rows")


def test_sensors_of_a_valve_that_contradict_each_other_are_named(known):
    def output(name, rms):
        return SimpleNamespace(
            model=SimpleNamespace(output=SimpleNamespace(name=name), training={"held_out_flow_rms": rms})
        )

    flow = known.circuit("boom").flow
    fits = [output("boom.q_in", 0.1 * flow), output("boom.k_out", 0.9 * flow), output("stick.k_out", 0.05 * flow)]
    (statement,) = contradicted(fits, known)
    assert statement.startswith("flows of boom are 90 % of the pump's off on rows held out")


def points_of(machine, circuit, n=3000):
    """Measurements at random points of a circuit, in an order that means nothing."""
    table = sample_circuit(machine, circuit, n, rng=np.random.default_rng(3))
    columns = {"time": 0.02 * np.arange(n)}
    for f in machine.circuit(circuit).functions:
        forward = table[f"{f}.spool"] > 0.0
        for port, side in (("p_a", forward), ("p_b", ~forward)):
            columns[f"{f}.{port}"] = np.where(side, table[f"{f}.p_in"], table[f"{f}.p_out"])
        columns |= {f"{f}.{what}": table[f"{f}.{what}"] for what in ("spool", "q_in", "q_out")}
    return Table(columns, {})


@pytest.mark.parametrize(
    ("r2", "rms", "words"),
    [
        (0.99, 0.04, None),
        (0.85, 0.04, "boom.q_in (R2 0.850, rms 4.0% of the pump's flow); a longer log"),
        (0.99, 0.06, "boom.q_in (R2 0.990, rms 6.0% of the pump's flow); a longer log"),
    ],
)
def test_weak_networks_are_named(r2, rms, words):
    model = SimpleNamespace(
        output=SimpleNamespace(name="boom.q_in"), training={"held_out_flow_rms": rms, "pump_flow": 1.0}
    )
    found = weak([SimpleNamespace(model=model, r2=r2)])
    assert found == [] if words is None else words in found[0]


def test_a_pump_at_its_torque_limit_is_learnt_of_another_machine():
    loader = load_machine("wheel_loader")
    found = fit_machine(points_of(loader, "work"), loader, max_regions=6)
    assert [model.output.name for model in found.models] == ["tilt.q_in", "lift.q_in", "lift.k_out", "tilt.k_out"]
    lift = found.models[1]
    assert [variable.name for variable in lift.inputs] == ["tilt.travel", "lift.travel", "tilt.p_in", "lift.p_in"]
    assert lift.training["held_out_flow_rms"] < 0.06 * loader.circuits[0].pump.flow
    assert build_flow("polynomial", loader, models=found.models).served == loader.names
    assert [c.output for c in machine_coverage(found.table, found.models, loader)][:2] == ["tilt.q_in", "lift.q_in"]


def test_one_circuit_of_several_is_learnt_from_its_own_sensors():
    crane = load_machine("loader_crane")
    found = fit_machine(points_of(crane, "lift"), crane, circuits=["lift"], max_regions=1)
    assert [model.output.name for model in found.models] == ["inner.q_in", "outer.q_in", "inner.k_out", "outer.k_out"]
    assert (found.windows, found.drifts) == ("not run against the log: nothing is learnt of slew, reach, tilt", [])
    assert build_flow("polynomial", crane, models=found.models).served == ("inner", "outer")
    assert len(machine_coverage(points_of(crane, "lift"), found.models, crane)) == 4
    with pytest.raises(InputError, match=r"unknown circuit 'boom'; choose one of \['lift', 'slew_and_reach'\]"):
        fit_machine(points_of(crane, "lift"), crane, circuits=["boom"])


def test_a_circuit_that_no_networks_stand_for_is_named_with_what_serves_it():
    with pytest.raises(
        InputError, match=r"circuit 'main_giving' is of the kind 'crossover'; .* `polydraulic fit-joints`"
    ):
        fit_machine(silent(), "cat215b_crossover")


def test_times_in_milliseconds_are_refused(machine):
    table = silent()
    with pytest.raises(InputError, match="rows come every .* column 'time' must be in s"):
        fit_machine(Table({**table.columns, "time": 1e3 * table["time"]}, table.units), machine)
