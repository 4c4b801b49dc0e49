"""Commands for measured logs as a user meets them."""

import json
import re

import numpy as np
import pytest

from helpers.can_made import DBC, bus, write_bus
from helpers.logs_made import MAP, healthy, write_csv
from helpers.machine_log import machine_log
from polydraulic.identification.log_replay import driven
from polydraulic.identification.machine.machine_log import MEASURED
from polydraulic.measure.bench import sensors
from polydraulic.measure.bench.sensors import load_sensors
from polydraulic.parameters.load import load_machine
from polydraulic.tables import Table, write_table


@pytest.fixture
def files(tmp_path):
    columns = healthy(n=600)
    write_csv(tmp_path / "log.csv", columns)
    columns["p_head"][10] = 999.0
    write_csv(tmp_path / "bad.csv", columns)
    columns["p_head"][:] = 999.0
    write_csv(tmp_path / "none.csv", columns)
    (tmp_path / "map.toml").write_text(MAP)
    return tmp_path


def test_a_map_is_suggested(call, files):
    code, out, _ = call("import --suggest log.csv")
    assert code == 0
    assert 'source = "p_head"\nrole = "input"\nunit = "bar"' in out
    assert call("import --suggest log.csv --out first.toml")[1].startswith(
        "first.toml: a first channel map; go through it: say "
    )
    assert call("import --suggest log.csv --out first.toml")[2] == (
        "error: first.toml is there already; choose another name, or remove it first\n"
    )
    assert (files / "first.toml").read_text() == out


def test_sensors_to_begin_with_read_all_that_a_machine_is_learnt_from_and_run_against(call, tmp_path):
    code, out, _ = call("record --example")
    assert code == 0
    assert call("record --example --out s.toml")[1] == "s.toml: sensors to begin with; change them as you like\n"
    assert "s.toml is there already" in call("record --example --out s.toml")[2]
    assert (tmp_path / "s.toml").read_text() == out
    read = {sensor.column for sensor in load_sensors(tmp_path / "s.toml").sensors}
    learnt = {f"{link}.{what}" for link in ("swing", "boom", "stick") for what in MEASURED}
    assert read == learnt | set(driven(load_machine("cat215b")))


def test_sensors_to_begin_with_explain_every_key(call):
    explained = call("record --example")[1].partition("seed =")[0]
    for key in sensors._SENSOR | sensors._FILE - {"sensor"}:
        assert re.search(rf"\b{key}\b", explained), key


def test_full_strokes_are_asked_for_of_random_operators_alone(call):
    call("record --example --out s.toml")
    code, out, err = call("record task random:1:9:0.5 --full-stroke --sensors s.toml --out log.csv")
    assert (code, out) == (2, "")
    assert err == (
        "error: --full-stroke gives random operators their voltage, random:SEED:SECONDS; task, random:1:9:0.5 have their own\n"
    )


def test_a_recording_is_not_written_over_by_what_is_recorded_of_it(call, tmp_path):
    recorded = "time,swing,boom,stick\n0,0,0.5,0\n1,0,0.4,0\n"
    (tmp_path / "r2.csv").write_text(recorded)
    call("record --example --out s.toml")
    code, _, error = call("record r2.csv --sensors s.toml --out r2.csv")
    assert (code, "r2.csv: is the file that is read, which would be replaced" in error) == (2, True)
    assert (tmp_path / "r2.csv").read_text() == recorded


def test_findings_are_printed_and_the_report_lies_beside_the_table(call, files):
    code, out, _ = call("import bad.csv --channels map.toml --out table.csv")
    assert code == 0
    assert out.startswith("error: implausible 'p_head' (1 row) in row 11: values beyond the plausible range")
    assert "table.csv: 599 rows in 1 segment(s); table.quality.html: 1 finding(s)" in out
    assert (files / "table.quality.json").is_file()
    assert "0 finding(s)" in call("import log.csv --channels map.toml --out t.parquet --report r/q.html")[1]
    assert (files / "r" / "q.html").is_file()


def test_dropouts_of_many_channels_are_one_line_behind_the_errors(call, files):
    columns = healthy(n=600)
    columns["p_head"][100:150] = np.nan
    write_csv(files / "one.csv", columns)
    assert (
        "warning: dropout 'p_head' (1 gap) before row 151" in call("import one.csv --channels map.toml --out t.csv")[1]
    )
    columns["lever"][300:400] = np.nan
    columns["p_head"][10] = 999.0
    write_csv(files / "many.csv", columns)
    told = call("import many.csv --channels map.toml --out t.csv")[1].splitlines()
    assert [line.partition(" 'p")[0] for line in told[:2]] == [
        "error: implausible",
        "warning: dropouts in 2 channels, up to 1.01 s in one; the table has no rows there; --partial keeps what other channels read; see t.quality.html",
    ]
    assert not any("dropout '" in line for line in told)


def test_a_partial_table_says_how_many_values_are_missing(call, files):
    columns = healthy(n=600)
    columns["p_head"][100:150] = np.nan
    write_csv(files / "one.csv", columns)
    code, out, _ = call("import one.csv --channels map.toml --out t.csv --partial")
    assert code == 0
    assert "rows in which a channel has no value, kept as missing: boom.p_a 50, speed 1" in out
    assert "t.csv: 600 rows in 1 segment(s)" in out
    assert "kept as missing: speed 1\n" in call("import log.csv --channels map.toml --out l.csv --partial")[1]
    assert call("import --suggest log.csv --partial")[0] == 2


def test_strict_is_an_exit_code_for_what_is_wrong(call, files):
    code, out, _ = call("import bad.csv --channels map.toml --out table.csv --strict")
    assert code == 1
    assert "range [5, 250] bar, such as 999" in out
    assert out.endswith("--strict: 1 error(s) above\n")
    assert (files / "table.csv").is_file()
    assert call("import log.csv --channels map.toml --out t.csv --strict")[0] == 0


def test_several_files_are_one_campaign(call, files):
    code, out, _ = call("import bad.csv log.csv --channels map.toml --out table.csv")
    assert code == 0
    assert "warning: files begin anew" in out
    assert "table.csv: 1198 rows in 2 segment(s)" in out
    assert call('import "none.*" --channels map.toml --out t.csv')[0] == 2
    assert "no file matches" in call('import "x*.csv" --channels map.toml --out t.csv')[2]
    highest = re.findall(r"range = \[.*, (.*)\]", call("import --suggest log.csv bad.csv")[1])
    assert max(map(float, highest)) > 999.0


def test_a_log_without_a_row_is_an_error_with_a_report(call, files):
    code, out, error = call("import none.csv --channels map.toml --out table.csv")
    assert code == 2
    assert "error: implausible 'p_head' (600 rows)" in out
    assert "gives no row of a table; table.quality.html says why" in error
    assert not (files / "table.csv").exists()
    assert (files / "table.quality.html").is_file()


def test_a_bus_log_is_imported_by_its_databases(call, tmp_path):
    (tmp_path / "bus.dbc").write_text(DBC)
    write_bus(tmp_path / "bus.blf", bus(100))
    code, _, error = call("import --suggest bus.blf")
    assert code != 0
    assert "a raw bus log" in error
    assert "--dbc" in error
    assert call("import --suggest bus.blf --dbc bus.dbc --out map.toml")[0] == 0
    text = (tmp_path / "map.toml").read_text()
    assert 'source = "p_head"' in text
    (tmp_path / "map.toml").write_text("""raster = "10 ms"
[[channel]]
source = "speed"
role = "input"
unit = "rpm"
[[channel]]
source = "p_head"
role = "output"
unit = "bar"
""")
    code, out, _ = call("import bus.blf --dbc bus.dbc --channels map.toml --out t.parquet")
    assert code == 0
    assert "status 'speed' (20 rows)" in out
    assert "(frames that no database knows)" in out


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("import log.csv", "an import needs --channels MAP.toml and --out TABLE"),
        ("import log.csv --channels map.toml --out table.xls", "a table ends in .csv or .parquet"),
        ("import log.csv --channels map.toml --out t.csv --report q.pdf", "a quality report ends in .html"),
        ("import log.csv --channels none.toml --out t.csv", "none.toml: no such file"),
        ("import none.mf4 --channels map.toml --out t.csv", "none.mf4: no such file"),
        ("import --suggest log.csv --channels map.toml", "--suggest writes a channel map"),
        ("import --suggest map.toml", "a log ends in one of"),
        ("import log.csv --channels map.toml --out log.csv", "log.csv: is the file that is read"),
        ("import --suggest *.csv --out log.csv", "log.csv: is the file that is read"),
        ("simulate log.csv --out log.csv", "log.csv: is the file that is read"),
        ("payload log.csv --out log.csv", "log.csv: is the file that is read"),
        ("run model.json log.csv --out log.csv", "log.csv: is the file that is read"),
        ("record random:1:1 --sensors none.toml --out log.csv", "none.toml: no such file"),
        ("record random:1:1 --sensors map.toml --out log.xls", "a recorded log ends in one of"),
        ("record random:1:1 --sensors map.toml --out log.csv", "map.toml: unknown key"),
        (
            "record random:1:1 --out log.csv",
            "a recording needs a scenario, --sensors SENSORS.toml and --out LOG; --example",
        ),
        ("record --sensors map.toml --out log.csv", "a recording needs a scenario"),
        ("record random:1:1 --example --out s.toml", "--example writes sensors; scenarios and --sensors go with"),
        ("record --example --out log.csv", "log.csv: sensors are a .toml file"),
        ("fit-machine log.csv --out machine.toml", "machine.toml: a model file ends in .json"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(call, files, line, message):
    code, _, error = call(line)
    assert code == 2
    assert message in error
    assert error.count("\n") == 1


@pytest.fixture
def machine_files(tmp_path):
    log = machine_log(90.0)
    write_table(log, tmp_path / "table.parquet")
    later = machine_log(20.0, seed=3)
    write_table(later, tmp_path / "later.parquet")
    silent = {name: values for name, values in log.columns.items() if not name.endswith("voltage")}
    write_table(Table(silent, log.units), tmp_path / "silent.csv")
    write_table(Table(later.columns, {**later.units, "boom.p_a": "bar"}), tmp_path / "bar.parquet")
    return tmp_path


def test_a_machine_from_its_log_with_card_and_check(call, machine_files):
    quick = "--regions 1 --rows 400 --blocks 5 --boxes 2"
    code, out, _ = call(f"fit-machine table.parquet --out machine.json --card machine.html {quick}")
    assert code == 0
    assert "of 4501 rows held out, every fifth block of time" in out
    assert out.endswith("\nmachine.json: written\nmachine.html: written\n")
    shares = [float(share) for share in re.findall(r"^  \w+\.\w+ .*?(\S+)%", out, re.MULTILINE)]
    assert len(shares) == 6
    assert all(0.0 < share < 20.0 for share in shares)
    assert "run against the log: 1 windows of 10 s in the blocks held out" in out
    assert re.search(r"^  boom +\S+ deg", out, re.MULTILINE)
    data = json.loads((machine_files / "machine.card.json").read_text())
    assert len(data["models"]) == 6
    assert data["data"]["drift"][3]["name"] == "tip"
    code, out, _ = call("check machine.json --data later.parquet")  # of an import, without the columns that are derived
    assert len(re.findall(r"^\S+ \[\S+\]: (?:holds|does not hold)", out, re.MULTILINE)) == 6
    code, out, _ = call("replay later.parquet --model machine.json --seconds 6 --plot replay.svg")
    assert code == 0
    assert "3 windows of 6 s, each started from the measured state" in out
    assert (machine_files / "replay.svg").is_file()
    assert "18 windows of 6 s" in call("replay later.parquet table.parquet --model machine.json --seconds 6")[1]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("fit-machine table.parquet --out m.json --card m.pdf", "m.pdf: a model card ends in .html"),
        ("fit-machine silent.csv --out m.json --machine none", "unknown parameter set 'none'"),
        ("fit-machine later.parquet --out m.json", "record longer"),
        ("fit-machine bar.parquet --out m.json", "column 'boom.p_a' is in 'bar'"),
        ("replay silent.csv", "no column 'swing.voltage'"),
        ("replay later.parquet --seconds 60", "later.parquet: no piece of 60 s without a gap; choose shorter windows"),
        ("replay later.parquet --plot r.txt", "a picture ends in one of"),
        ("replay later.parquet --flow exact --model m.json", "--model goes with --flow polynomial, neural or residual"),
    ],
)
def test_bad_machine_logs_are_one_line_and_exit_code_2(call, machine_files, line, message):
    before = sorted(machine_files.iterdir())
    code, _, error = call(line)
    assert code == 2
    assert message in error
    assert error.count("\n") == 1
    assert sorted(machine_files.iterdir()) == before
