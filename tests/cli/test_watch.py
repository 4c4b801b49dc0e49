"""`polydraulic watch` as a user calls it."""

import pytest

from helpers.watched_logs import healthy_log, known, log_of, made_networks
from polydraulic import load_machine, write_table
from polydraulic.identification.watching.fault_networks import save_fault_networks


@pytest.fixture
def logs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_table(healthy_log(), "healthy.parquet")
    write_table(log_of(load_machine("wheel_loader"), 31, 40.0, ["work.pump_worn from 10 s"]), "worn.parquet")


def test_what_is_wrong_is_said_and_shown(call, logs, tmp_path):
    code, out, _ = call("watch worn.parquet --machine wheel_loader --healthy healthy.parquet --out watch.html")
    assert code == 0
    assert "pump of work worn: its flow is" in out
    assert "watch.html: written" in out
    assert "pump of work worn" in (tmp_path / "watch.html").read_text(encoding="utf-8")
    code, _, _ = call("watch worn.parquet --machine wheel_loader --healthy healthy.parquet --strict")
    assert code == 1


def test_networks_go_along_with_what_is_exported(call, logs, tmp_path):
    save_fault_networks(made_networks(known()[0].directions), "names.json")
    line = "watch worn.parquet --machine wheel_loader --healthy healthy.parquet --networks names.json --export worn_c"
    code, out, _ = call(line)
    assert code == 0
    assert "worn_c.h" in out
    assert "it tests itself: gcc -std=c99 -DWORN_C_SELF_TEST worn_c/worn_c.c -lm, and run" in out
    header = (tmp_path / "worn_c" / "worn_c.h").read_text(encoding="utf-8")
    assert "int worn_c_kind(const worn_c_state *w);" in header


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("watch worn.parquet --machine wheel_loader --healthy healthy.parquet --out watch.txt", "ends in .html"),
        ("watch worn.parquet --machine wheel_loader --healthy healthy.parquet --false-alarms 0", "must be above 0"),
        ("watch worn.parquet --machine wheel_loader --healthy healthy.parquet --sensors x.p_a", "called so"),
        ("watch worn.parquet --machine wheel_loader --healthy healthy.parquet --networks x.pkl", "ends in .json"),
        ("watch worn.parquet --machine cat215b --healthy healthy.parquet", "no column is of a sensor of"),
        ("watch nothing.parquet --machine wheel_loader", "nothing.parquet"),
    ],
)
def test_what_cannot_be_done_is_one_line(call, logs, line, words):
    code, _, err = call(line)
    assert code == 2
    assert words in err
    assert err.count("\n") <= 2
