"""docs/measured_logs.md, block by block."""

import re
import shlex
import sys
from pathlib import Path

import numpy as np

from polydraulic import cli
from polydraulic.tables import read_table

PAGE = Path(__file__).parents[2] / "docs" / "measured_logs.md"


def test_the_page_runs_from_top_to_bottom(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {}
    blocks = re.findall(r"```(python|sh)\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) == 9
    for kind, block in blocks:
        if kind == "python":
            exec(compile(block, PAGE.name, "exec"), names)
            continue
        for command in block.strip().splitlines():
            # a shorter run shows as much
            monkeypatch.setattr(sys, "argv", shlex.split(command.replace(":120", ":40")))
            cli.app(standalone_mode=False)
    table = read_table("table.parquet")
    assert table.names == ["time", "segment", "boom.spool", "boom.p_a", "boom.q_in"]
    assert [table.unit(name) for name in table.names] == ["s", "1", "m", "Pa", "m3/s"]
    assert table.info["outputs"] == ["boom.q_in"]
    assert len(table) > 3000
    assert all(np.array_equal(table[n], read_table("again.parquet")[n]) for n in table.names)
    assert Path("first.toml").read_text().count("[[channel]]") == 3
    assert Path("table.quality.html").read_text().startswith("<!doctype html>")
    printed = capsys.readouterr().out
    assert "boom.q_in answers boom.spool below" in printed
    assert "a cubic over 0.11 s" in printed
    assert re.search(r"boom.q_in \[l/min\]: (holds|does not hold any more)", printed)
    assert "blocks of time" in Path("q_in.html").read_text()
