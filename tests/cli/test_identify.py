"""`polydraulic identify`: what is refused before any work, and a log that determines nothing."""

import numpy as np
import pytest

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
        ("silent.csv --machine none --out m.toml", "unknown parameter set 'none'"),
        ("none.csv --machine wheel_loader --out m.toml", "none.csv"),
        (
            "silent.csv --machine wheel_loader --out m.toml --free links.*.weight",
            "--free 'links.*.weight' fits no number of the machine",
        ),
        (
            "silent.csv --machine wheel_loader --out m.toml",
            "silent.csv determines nothing of this machine; functions.lift.pilot: kept; the log has no voltage with a spool that follows it; ",
        ),
    ],
)
def test_what_cannot_be_identified_is_one_line_and_no_file(call, silent, tmp_path, line, words):
    code, out, err = call(f"identify {line}")
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert words in err
    assert not list(tmp_path.glob("m.*"))
