"""`polydraulic watch` as a user calls it."""

import pytest

from helpers.watched_logs import healthy_log, log_of
from polydraulic import load_machine, write_table


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
