"""docs/measured_logs.md, block by block, and what comes out of it."""

import re
from pathlib import Path

import numpy as np

from helpers.pages import ROOT, run_page
from polydraulic.tables import read_table


def test_the_page_runs_from_top_to_bottom(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    printed = run_page(ROOT / "docs" / "measured_logs.md", monkeypatch, capfd)
    table = read_table("table.parquet")
    assert table.names == ["time", "segment", "boom.spool", "boom.p_a", "boom.q_in"]
    assert [table.unit(name) for name in table.names] == ["s", "1", "m", "Pa", "m3/s"]
    assert table.info["outputs"] == ["boom.q_in"]
    assert len(table) > 3000
    assert all(np.array_equal(table[n], read_table("again.parquet")[n]) for n in table.names)
    assert Path("first.toml").read_text().count("[[channel]]") == 3
    assert Path("table.quality.html").read_text().startswith("<!doctype html>")
    assert "boom.q_in answers boom.spool below" in printed
    assert "a cubic over 0.11 s" in printed
    assert re.search(r"boom.q_in \[l/min\]: (holds|does not hold any more)", printed)
    assert "blocks of time" in Path("q_in.html").read_text()
