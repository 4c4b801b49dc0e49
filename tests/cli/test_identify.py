"""`polydraulic identify`: what is refused before any work, and a log that determines nothing, one that lacks most sensors."""

from types import SimpleNamespace

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.identification.equations.residuals import ResidualModels
from polydraulic.tables import Table, write_table


@pytest.fixture
def silent(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = 800
    columns = {"time": np.arange(rows) * 0.02, "lift.angle": np.sin(np.arange(rows) * 0.01)}
    write_table(Table(columns, {"time": "s", "lift.angle": "rad"}), tmp_path / "silent.csv")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("silent.csv --machine wheel_loader --out m.json", "m.json: a machine file ends in .toml"),
        ("silent.csv --machine wheel_loader --out m.toml --card c.pdf", "c.pdf: a card ends in .html"),
        ("silent.csv --machine wheel_loader --out m.toml --residuals r.csv", "r.csv"),
        ("silent.csv --machine wheel_loader", "an identification needs --out MACHINE.toml; --plan says"),
        (
            "silent.csv --machine wheel_loader --plan --out m.toml",
            "--plan writes nothing; --out, --card and --residuals go with",
        ),
        ("silent.csv --machine wheel_loader --plan", "the log has no column 'lift.voltage'"),
        ("silent.csv --machine none --out m.toml", "unknown parameter set 'none'"),
        ("none.csv --machine wheel_loader --out m.toml", "none.csv"),
        (
            "silent.csv --machine wheel_loader --out m.toml --free links.*.weight",
            "--free 'links.*.weight' fits no number of the machine",
        ),
        (
            "silent.csv --machine wheel_loader --out m.toml",
            "silent.csv determines nothing of this machine; circuits.work: kept; the log has no ",
        ),
        (
            "silent.csv --machine wheel_loader --out m.toml",
            "; functions.lift.pilot: kept; the log has no voltage with a spool that follows it; ",
        ),
    ],
)
def test_what_cannot_be_identified_is_one_line_and_no_file(call, silent, tmp_path, line, words):
    code, out, err = call(f"identify {line}")
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert words in err
    assert not list(tmp_path.glob("m.*"))


@pytest.mark.parametrize("option", ["--out", "--card", "--residuals"])
def test_a_place_where_nothing_can_be_written_is_refused_before_any_work(call, silent, tmp_path, monkeypatch, option):
    def never(*_, **__):
        raise AssertionError

    monkeypatch.setattr("polydraulic.identification.equations.identify.identify", never)
    (tmp_path / "file").write_text("")
    ending = {"--out": "m.toml", "--card": "m.html", "--residuals": "m.json"}[option]
    first = "" if option == "--out" else "--out m.toml "
    code, out, err = call(f"identify silent.csv --machine wheel_loader {first}{option} file/{ending}")
    assert (code, out) == (2, "")
    assert f"cannot write file/{ending}" in err
    assert not list(tmp_path.glob("m.*"))


def test_the_machine_to_begin_from_is_not_replaced(call, silent, tmp_path):
    assert call("machine new m.toml --like wheel_loader")[0] == 0
    before = (tmp_path / "m.toml").read_bytes()
    code, _, err = call("identify silent.csv --machine m.toml --out m.toml")
    assert code == 2
    assert "m.toml: is the file that is read, which would be replaced" in err
    assert (tmp_path / "m.toml").read_bytes() == before


def test_a_log_in_which_no_lever_moves_is_not_simulated(call, silent, tmp_path):
    log = {"time": np.arange(800) * 0.02} | {
        f"{name}.{what}": np.zeros(800) for name in ("lift", "tilt") for what in ("voltage", "angle")
    }
    write_table(Table(log, {}), tmp_path / "still.csv")
    code, _, err = call("identify still.csv --machine wheel_loader --out m.toml")
    assert code == 2
    assert "through simulation: kept; no lever moves in the log" in err


def test_a_recording_of_commands_and_angles_alone_gives_pilot_and_pump(call, tmp_path):
    """From `record` to a machine file that runs, with no sensor of pressure, spool or flow."""
    sensors, channels = (
        ["seed = 4"],
        ['raster = "20 ms"', "[[channel]]", 'source = "time"', 'role = "time"', 'unit = "s"'],
    )
    for name in ("lift", "tilt"):
        for what, unit, noise, role in (("voltage", "V", 0.001, "input"), ("angle", "deg", 0.03, "output")):
            sensors += [
                "[[sensor]]",
                f'column = "{name}.{what}"',
                f'unit = "{unit}"',
                'raster = "20 ms"',
                f"noise = {noise}",
            ]
            channels += [
                "[[channel]]",
                f'source = "{name}.{what}"',
                f'role = "{role}"',
                f'unit = "{unit}"',
                "range = [-200, 200]",
            ]
    (tmp_path / "sensors.toml").write_text("\n".join(sensors))
    (tmp_path / "map.toml").write_text("\n".join(channels))
    assert call("machine new guess.toml --like wheel_loader")[0] == 0
    guess = tmp_path / "guess.toml"
    guess.write_text(guess.read_text().replace("flow = { value = 180.0", "flow = { value = 200.0"))
    assert (
        call("record random:7:14 --full-stroke --machine wheel_loader --sensors sensors.toml --out log.parquet")[0] == 0
    )
    assert call("import log.parquet --channels map.toml --out table.parquet")[0] == 0
    code, out, err = call(
        "identify table.parquet --machine guess.toml --out found.toml --free *.pump.flow --free functions.lift.pilot.gain --residuals left.json"
    )
    assert (code, err.count("\n")) == (2, 1)  # of a log without flows; what was identified is told
    assert err.startswith("error: circuits.work: no network of what is left; the log has no ")
    assert "found.toml: written" in out
    assert not (tmp_path / "left.json").exists()
    assert "windows of 2 s against sensors" in out
    assert "circuits.work: not by regression; the log has no" in out
    found, true = load_machine(tmp_path / "found.toml"), load_machine("wheel_loader")
    assert found.circuit("work").pump.flow == pytest.approx(true.circuit("work").pump.flow, rel=0.01)
    assert "identified from table.parquet: simulation of" in (tmp_path / "found.toml").read_text()
    code, out, err = call("identify table.parquet --machine found.toml --plan --free functions.lift.pilot.gain")
    assert (code, err) == (0, "")
    assert "best further sensor" in out
    assert "all functions, full stroke" in out


def test_networks_of_an_earlier_machine_are_named(call, silent, tmp_path, monkeypatch):
    found = SimpleNamespace(write=lambda path: None, text=lambda units: "found")
    monkeypatch.setattr("polydraulic.identification.equations.identify.identify", lambda *_, **__: found)
    nothing = ResidualModels((), (), ())
    monkeypatch.setattr("polydraulic.identification.equations.residuals.learn_residuals", lambda *_, **__: nothing)
    line = "identify silent.csv --machine wheel_loader --out m.toml --residuals left.json"
    assert call(line)[1].endswith("left.json: not written, no network holds on blocks held out\n")
    (tmp_path / "left.json").write_text("{}")
    assert call(line)[1].endswith("held out; the file of that name belongs to an earlier machine\n")


def test_files_that_were_written_are_named(call, silent, monkeypatch):
    found = SimpleNamespace(write=lambda path: None, text=lambda units: "found")
    monkeypatch.setattr("polydraulic.identification.equations.identify.identify", lambda *_, **__: found)
    monkeypatch.setattr("polydraulic.identification.equations.card.write_identification_card", lambda *_, **__: None)
    line = "identify silent.csv --machine wheel_loader --out m.toml"
    assert call(line)[1] == "found\nm.toml: written\n"
    assert call(f"{line} --card m.html")[1] == "found\nm.toml: written\nm.html: written\n"
