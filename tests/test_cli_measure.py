"""Commands for measured logs as a user meets them."""

import sys

import pytest

from measure.logs_made import MAP, healthy, write_csv
from polydraulic import cli


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    def run(line):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["polydraulic", *line.split()])
        with pytest.raises(SystemExit) as stop:
            cli.main()
            sys.exit(0)
        printed = capsys.readouterr()
        return stop.value.code or 0, printed.out, printed.err

    return run


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
    assert call("import --suggest log.csv --out first.toml")[1] == "first.toml: a first channel map; go through it\n"
    assert (files / "first.toml").read_text() == out


def test_findings_are_printed_and_the_report_lies_beside_the_table(call, files):
    code, out, _ = call("import bad.csv --channels map.toml --out table.csv")
    assert code == 0
    assert out.startswith("error: implausible 'p_head' (1 row) in row 11: values beyond the plausible range")
    assert "table.csv: 599 rows in 1 segment(s); table.quality.html: 1 finding(s)" in out
    assert (files / "table.quality.json").is_file()
    assert "0 finding(s)" in call("import log.csv --channels map.toml --out t.parquet --report r/q.html")[1]
    assert (files / "r" / "q.html").is_file()


def test_a_log_without_a_row_is_an_error_with_a_report(call, files):
    code, out, error = call("import none.csv --channels map.toml --out table.csv")
    assert code == 2
    assert "error: implausible 'p_head' (600 rows)" in out
    assert "no row of a table came of it; table.quality.html says why" in error
    assert not (files / "table.csv").exists()
    assert (files / "table.quality.html").is_file()


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
        ("record random:1:1 --sensors none.toml --out log.csv", "none.toml: no such file"),
        ("record random:1:1 --sensors map.toml --out log.xls", "a recorded log ends in one of"),
        ("record random:1:1 --sensors map.toml --out log.csv", "map.toml: unknown key"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(call, files, line, message):
    code, _, error = call(line)
    assert code == 2
    assert message in error
    assert error.count("\n") == 1
