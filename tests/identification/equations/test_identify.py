"""A machine identified from a short log of the exact one, and what a log does not tell."""

import json
import re

import numpy as np
import pytest

from helpers.machine_log import machine_log
from helpers.small_crane import write_crossover_crane
from polydraulic import InputError, load_machine
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.identification import identify
from polydraulic.identification.equations.finished import Finished
from polydraulic.identification.equations.identify import _segments
from polydraulic.identification.equations.shooting.fit import ShootingStage
from polydraulic.machine.pump import limited_pump
from polydraulic.networks.growth.levenberg_marquardt import Descent
from polydraulic.tables import Table

SECONDS = 120.0
BOOM = ["functions.boom.valve.*", "functions.boom.pilot.*", "circuits.boom.pump.*"]


@pytest.fixture(scope="module")
def true():
    return load_machine("cat215b")


@pytest.fixture(scope="module")
def log():
    return machine_log(SECONDS)


def rough(true):
    """What is known before: where valves open and close; conductances, pumps and pilots are off."""
    values = {}
    for f in true.functions:
        v, where = f.valve, f"functions.{f.name}"
        knots = tuple(v.knots[k] for k in (0, 1, 4, 5))
        values[f"{where}.valve.knots"] = knots
        for key in ("inlet", "bypass", "outlet_positive", "outlet_negative"):
            at = np.interp(knots, v.knots, getattr(v, key))
            values[f"{where}.valve.{key}"] = (0.8 if key == "bypass" else 1.3) * np.where(at > 1e-10, at, 0.0)
        values[f"{where}.pilot.gain"] = 1.1 * f.pilot.gain
    for c in true.circuits:
        values[f"{c.pump_path}.flow"] = 1.05 * c.pump.flow
    return true.with_values(values)


@pytest.fixture(scope="module")
def found(true, log):
    told = []
    result = identify(log, rough(true), progress=lambda what, done, total: told.append((what, done, total)))
    assert told[0][0] == "swing: sensors and pilot"
    shares = [done / total for _, done, total in told]
    assert max(shares) == shares[-1] == 1.0
    # nothing is left to simulation, and knots are told one by one
    assert np.diff(shares).max() < 0.4
    return result


def without(log, *parts):
    keep = [name for name in log.names if not any(part in name for part in parts)]
    return Table({name: log[name] for name in keep}, {name: log.unit(name) for name in keep})


def test_curves_come_near_to_the_truth_where_the_log_has_been(found, true):
    for name in true.names:
        ours, exact = found.machine.function(name), true.function(name)
        at = np.linspace(exact.valve.knots[1] + 4e-4, exact.valve.knots[3] - 2e-4, 20)
        for key, near in (("inlet", 0.05), ("bypass", 0.08)):
            curves = (np.interp(at, v.knots, getattr(v, key)) for v in (ours.valve, exact.valve))
            assert np.allclose(*curves, rtol=near, atol=2e-8), (name, key)
        assert ours.pilot.gain == pytest.approx(exact.pilot.gain, rel=2e-3)
        assert ours.pilot.time_constant == pytest.approx(exact.pilot.time_constant, rel=0.02)
    for ours, exact in zip(found.machine.circuits, true.circuits, strict=True):
        value, error = found.circuits[ours.name].pump["flow"]
        assert ours.pump.flow == value
        assert value == pytest.approx(exact.pump.flow, rel=3e-3)
        assert value == pytest.approx(exact.pump.flow, abs=3.0 * error, rel=0.0)
        assert error < 5e-3 * value


def test_what_was_not_free_or_not_seen_is_as_it_was(found, true):
    assert found.machine.links == true.links
    assert found.machine.tank == true.tank
    for name in true.names:
        v = found.circuits["boom" if name == "boom" else "series"].valves[name]
        knots = np.array(found.machine.function(name).valve.knots)
        assert np.isnan(v.errors["inlet"][knots > v.seen[1] + 1e-9]).all()
        assert v.seen[1] <= knots[-1]
        assert all(
            np.diff(getattr(v.curves, key)).min() >= 0.0 for key in ("inlet", "outlet_positive", "outlet_negative")
        )
    assert "never seen" in str(found)


def test_the_words_name_numbers_with_their_errors(found):
    text = str(found)
    assert re.search(r"circuits.boom.pump.flow +177.1 l/min +168\.\d+ l/min +0\.\d+ l/min", text)
    assert re.search(r"^ +stick +\d+ +\d+ +4.775 mm to \S+ mm +\d+\.\d\d% +\d+\.\d\d%$", text, re.MULTILINE)
    assert "in3/s" in found.text("field")


def test_the_file_is_a_machine_and_says_where_it_came_from(found, log, tmp_path):
    path = tmp_path / "identified.toml"
    found.write(path)
    again = load_machine(path)
    for ours, read in zip(found.machine.numbers, again.numbers, strict=True):
        assert read.value == pytest.approx(ours.value, rel=1e-8, abs=1e-30)
    for ours, read in zip(found.machine.functions, again.functions, strict=True):
        assert read.seen == pytest.approx(ours.seen, rel=1e-8)
        assert ours.seen.travel == pytest.approx(np.abs(log[f"{ours.name}.spool"]).max(), rel=0.02)
        assert 5e6 < ours.seen.pressure < 4e7
    text = path.read_text(encoding="utf-8")
    assert "identified from table: " in text
    assert "uncertainty" in text
    with pytest.raises(InputError, match="a machine file ends in .toml"):
        found.write(tmp_path / "identified.json")


def test_without_flow_sensors_volumes_are_balanced(true, log):
    found = identify(without(log, ".q_in", ".q_out"), rough(true), free=BOOM)
    assert list(found.circuits) == ["boom"]
    assert found.circuits["boom"].valves["boom"].rows < 1000  # windows
    assert found.machine.circuit("boom").pump.flow == pytest.approx(true.circuit("boom").pump.flow, rel=0.02)
    rng = np.random.default_rng(1)
    travel, p_in = rng.uniform(5e-3, 9e-3, (500, 1)), rng.uniform(3e6, 1.2e7, (500, 1))

    def flows(machine):
        pump, p_return = machine.circuit("boom").pump, machine.tank.return_pressure
        valve = machine.function("boom").valve
        return sample_valves([valve], limited_pump(pump.flow, pump.relief, p_return, pump), travel, p_in).q_in

    off = [np.sqrt(np.mean((flows(m) - flows(true)) ** 2)) for m in (found.machine, found.before)]
    assert off[0] < 0.4 * off[1]


def test_free_numbers_alone_change_each_in_its_own_way(true, log):
    boom = true.link("boom").mass
    start = rough(true).with_values({"links.boom.mass": 1.2 * boom})
    found = identify(log, start, free=["functions.swing.pilot.*", "links.boom.mass", "functions.boom.cylinder.bore"])
    pilot = [f"functions.swing.pilot.{key}" for key in ("gain", "time_constant", "dead_time")]
    assert list(found.changes) == [*pilot, "links.boom.mass"]
    assert found.machine.link("boom").mass == pytest.approx(boom, rel=0.02)
    assert "torques of the oil, pressure" in found.changes["links.boom.mass"].source
    assert "circuits.boom: kept; none of its numbers is free" in found.kept
    assert any(
        line.startswith("functions.boom.cylinder.bore: kept; sizes, places and settings are better measured")
        for line in found.kept
    )


def test_sensors_that_are_missing_are_named(true, log):
    found = identify(without(log, "boom.spool", "stick.p_a", "swing.angle"), rough(true))
    assert not found.circuits
    assert "circuits.boom: kept; the log has no boom.spool" in found.kept
    assert "circuits.series: kept; the log has no stick.p_a" in found.kept
    assert any(line.startswith("functions.boom.pilot: kept") for line in found.kept)
    assert "through simulation: kept; the log has no swing.angle" in found.kept


def silent_at_times(log, share, seed=1):
    """Each sensor silent for half a second at a time, all at times of their own; levers are known."""
    rng, lost, columns = np.random.default_rng(seed), 25, dict(log.columns)
    for name in columns:
        if not name.endswith(("time", "segment", ".voltage")):
            begins = rng.random(len(log)) < -np.log(1.0 - share) / lost
            silent = np.convolve(begins, np.ones(lost))[: len(log)] > 0.0
            columns[name] = np.where(silent, np.nan, columns[name])
    return Table(columns, log.units).partial()


def test_what_does_not_need_a_silent_sensor_is_identified_from_its_own_rows(true, log):
    silent = silent_at_times(log, 0.15)
    whole = silent.whole([name for name in silent.names if name != "missing"])
    assert len(whole) < 0.1 * len(log)
    with pytest.raises(InputError, match=f"determines nothing of this machine: it has {len(whole)} rows"):
        identify(whole, rough(true), free=["functions.*.pilot.gain"])
    part = identify(silent, rough(true), free=["functions.*.pilot.*", *BOOM])
    assert set(part.pilots) == set(true.names)
    for name, found in part.pilots.items():
        error = found.pilot.gain / true.function(name).pilot.gain - 1.0
        assert abs(error) < 3.0 * found.errors.gain / found.pilot.gain + 1e-3
    assert part.machine.circuit("boom").pump.flow == pytest.approx(true.circuit("boom").pump.flow, rel=5e-3)
    assert not any("pilot" in line or "circuits.boom:" in line for line in part.kept)


def test_a_sensor_without_any_value_is_as_if_it_were_not_there(true, log):
    columns = dict(log.columns) | {"boom.q_in": np.full(len(log), np.nan)}
    part = identify(Table(columns, log.units).partial(), rough(true), free=["functions.*.pilot.gain", *BOOM])
    assert "boom.q_in: has no value in the whole log, and is not used" in part.kept
    other = identify(without(log, "boom.q_in"), rough(true), free=["functions.*.pilot.gain", *BOOM])
    assert part.changes == other.changes


def test_a_voltage_of_the_wrong_sign_is_named_and_changes_nothing(true, log):
    turned = Table({**log.columns, "boom.voltage": -log["boom.voltage"]}, log.units)
    found = identify(turned, rough(true), free=["functions.*.pilot.*"])
    assert [
        line for line in found.kept if line.startswith("not used: boom.voltage; boom.angle goes against boom.voltage")
    ]
    assert not [line for line in found.kept if "swing.voltage" in line]
    without_angles = identify(without(turned, ".angle"), rough(true), free=["functions.*.pilot.*"])
    told = [
        line for line in without_angles.kept if line.startswith("boom.voltage and boom.spool move against each other")
    ]
    assert told
    assert found.pilots.keys() == {"swing", "stick"}
    assert not [path for path in found.changes if path.startswith("functions.boom.")]
    assert found.machine.function("boom").pilot == rough(true).function("boom").pilot


def test_logs_of_two_rasters_are_refused_and_a_slow_one_is_told_to_say_little_of_pilots(true, log):
    slow = Table({name: log[name][::8] for name in log.names}, log.units)
    with pytest.raises(
        InputError, match="rows are 0.16 s apart, those of .* 0.02 s; import both logs with the same raster"
    ):
        identify([log, slow], true, free=["functions.*.pilot.*"])
    found = identify(slow, true, free=["functions.*.pilot.*"])
    told = [line for line in found.remarks if "what the lever does between rows is not seen" in line]
    assert [line.split(":")[0] for line in told] == [f"functions.{name}.pilot" for name in true.names]


def test_a_log_that_determines_nothing_says_why(true, log, tmp_path):
    with pytest.raises(
        InputError,
        match="determines nothing of this machine; .*circuits.series: kept; the log has no swing.spool.*; functions.swing.pilot: kept; .*; "
        "masses and friction from pressures: kept; .*no column 'swing.p_a'.*; through simulation: kept; the log has no swing.voltage",
    ):
        identify(without(log, ".spool", ".p_a", ".voltage"), rough(true))
    names = [name for name in log.names if not name.endswith(".voltage")]
    rest = {name: np.full(2000, log[name][0] if name.endswith(".angle") else 0.0) for name in names}
    still = Table(rest | {"time": 0.02 * np.arange(2000)}, log.units)
    with pytest.raises(InputError, match="the spool of boom hardly ever leaves its centre"):
        identify(still, rough(true))
    short = Table({name: log[name][:100] for name in log.names}, log.units)
    with pytest.raises(InputError, match="it has 100 rows; 500 at least"):
        identify(short, rough(true))
    with pytest.raises(InputError, match="column 'boom.p_a' is in 'bar'"):
        identify(Table(log.columns, log.units | {"boom.p_a": "bar"}), rough(true))
    backwards = Table(log.columns | {"time": log["time"][::-1].copy()}, log.units)
    with pytest.raises(InputError, match="column 'time' does not rise"):
        identify(backwards, rough(true))


@pytest.mark.parametrize(
    ("quantity", "factor", "match"),
    [
        ("spool", 1e3, "swing.spool.* must be in m;"),
        ("q_in", 6e4, "swing.q_in.* must be in m3/s;"),
        ("angle", 180.0 / np.pi, "boom.angle.* must be in rad"),
        ("p_", 1e-5, "pressures must be in Pa"),
        ("p_a", 1e-5, "swing.p_a.* comes to .* Pa at most, others to .* bar: it must be in Pa"),
        ("voltage", 100.0, "swing.voltage.* gives full travel: it must be in V, not in per cent"),
    ],
)
def test_numbers_that_are_not_in_si_are_refused_where_no_unit_is_stated(true, log, quantity, factor, match):
    other = {name: log[name] * (factor if f".{quantity}" in name else 1.0) for name in log.names}
    with pytest.raises(InputError, match=match):
        identify(Table(other, {}), true, free=BOOM)


def test_a_crossover_is_refused_by_name(tmp_path):
    machine = load_machine(write_crossover_crane(tmp_path))
    rows = 1000
    columns = {"time": np.arange(rows) * 0.02}
    for name in machine.names:
        columns |= {f"{name}.{what}": np.full(rows, 1e6) for what in ("p_a", "p_b")}
        columns |= {f"{name}.{what}": np.full(rows, 1e-4) for what in ("spool", "q_in")}
    with pytest.raises(
        InputError, match="it is of the kind 'crossover'; only circuits of valves in series are identified"
    ):
        identify(Table(columns, {}), machine)


def test_finished_circuits_are_found_again(true, log, tmp_path, monkeypatch):
    from polydraulic.identification.equations.ways import by_flows as module

    folder, fitted = tmp_path / "parts", []
    real = module.identify_circuit

    def stopped(machine, circuit, *rest):
        fitted.append(circuit.name)
        if circuit.name == "series":
            raise KeyboardInterrupt
        return real(machine, circuit, *rest)

    monkeypatch.setattr(module, "identify_circuit", stopped)
    boom = [*BOOM, "circuits.series.pump.flow"]
    with pytest.raises(KeyboardInterrupt):
        identify(log, rough(true), free=boom, parts=folder)
    assert (folder / "boom.json").exists()
    with pytest.raises(KeyboardInterrupt):
        identify(log, rough(true), free=boom, parts=folder)
    assert fitted == ["boom", "series", "series"]
    with pytest.raises(KeyboardInterrupt):  # another log does not take what this one found
        identify(without(log, "boom.voltage"), rough(true), free=boom, parts=folder)
    assert fitted[-2:] == ["boom", "series"]


def test_finished_circuits_are_read_as_they_were(found, tmp_path):
    kept = Finished(tmp_path / "parts", "digest")
    kept.keep("boom", found.circuits["boom"])
    again = kept.circuit("boom")
    ours = found.circuits["boom"].valves["boom"]
    assert again.valves["boom"].curves == ours.curves
    assert np.array_equal(again.valves["boom"].errors["inlet"], ours.errors["inlet"], equal_nan=True)
    assert again.pump == found.circuits["boom"].pump
    assert Finished(tmp_path / "parts", "other").circuit("boom") is None
    (tmp_path / "parts" / "boom.json").write_text(json.dumps({"digest": "digest"}))
    assert kept.circuit("boom") is None
    for name, text in (("model.json", '{"models": []}'), ("notes.json", "no JSON")):
        (tmp_path / "parts" / name).write_text(text)
    kept.forget()
    assert sorted(path.name for path in (tmp_path / "parts").iterdir()) == ["model.json", "notes.json"]
    for path in (tmp_path / "parts").iterdir():
        path.unlink()
    kept.keep("boom", found.circuits["boom"])
    kept.forget()
    assert not (tmp_path / "parts").exists()
    assert Finished(None, "digest").circuit("boom") is None


def test_how_far_simulation_has_come_is_read_as_it_was(tmp_path):
    kept, reached = (
        Finished(tmp_path, "digest"),
        ShootingStage(2, Descent(0.3, 5, 3, 1), np.array([0.1, 1 / 3]), np.ones((4, 8)), np.array([1e-4])),
    )
    assert kept.runs() is None
    kept.keep_runs(reached)
    again = kept.runs()
    assert again[:2] == (2, Descent(0.3, 5, 3, 1))
    assert all(np.array_equal(ours, was) for ours, was in zip(again[2:], reached[2:], strict=True))
    assert Finished(tmp_path, "other").runs() is None
    assert Finished(None, "digest").runs() is None


def test_a_log_has_five_hundred_rows_that_rise_and_is_cut_where_a_step_is_a_twentieth_off():
    def segments(time, **columns):
        return _segments(Table({"time": np.asarray(time, dtype=float), **columns}, {}), "log.csv").tolist()

    even = np.arange(500.0)
    assert segments(even) == [0] * 500
    with pytest.raises(InputError, match="log.csv determines nothing of this machine: it has 499 rows; 500 at least"):
        segments(even[1:])
    with pytest.raises(InputError, match="column 'time' does not rise from row to row"):
        segments(np.repeat(even, 2))
    for off, cut in ((0.049, 0), (-0.049, 0), (0.051, 1), (-0.051, 1)):
        assert segments(even + off * (even >= 5.0)) == [0] * 5 + [cut] * 495
    assert segments(even, segment=1.0 * (even >= 7.0)) == [0] * 7 + [1] * 493
