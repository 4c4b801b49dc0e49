"""`polydraulic loadchart` and `payload`, and what `machine check` says of a chassis, as a user calls them."""

import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import Table, load_machine, read_table, write_table
from polydraulic.machine.stability.statics import holding_pressures


def test_a_chart_is_printed_and_written(call, tmp_path):
    code, out, _ = call("loadchart --machine excavator_22t --step 2 --out chart.csv")
    assert code == 0
    assert out.startswith("Excavator of the 22 t class: moved by boom and stick, boom lifts")
    assert "over the front, capacity in kg and what limits it, by height and reach of the tip:" in out
    assert "over the side" in out
    table = read_table(tmp_path / "chart.csv")
    assert f"{table['capacity'].max():.0f} " in out
    code, _, _ = call("loadchart --machine wheel_loader --step 1 --out chart.html")
    assert code == 0
    assert "ISO 10567" in (tmp_path / "chart.html").read_text(encoding="utf-8")
    call("loadchart --machine wheel_loader --step 1 --hold tilt=10 --out chart.png")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("loadchart --machine crane.toml", "no [chassis]"),
        ("loadchart --out chart.docx", "chart.docx: ends in .html"),
        ("loadchart --hold bucket", "must be NAME=NUMBER, in deg"),
        ("loadchart --hold buckel=3", "'buckel' is not a function"),
        ("loadchart --move boom", "must name two functions"),
        (
            "loadchart --move boom,stick --move stick,bucket",
            "--move 'boom,stick,stick,bucket': must name two functions",
        ),
        ("loadchart --hold bucket=3 --hold bucket=4", "--hold bucket: is given twice, '3' and '4'; give it once"),
        ("loadchart --step -1", "step = -1 m"),
        ("payload none.csv", "none.csv"),
        ("payload none.csv --force --plot a.png", "--plot draws the payload"),
        ("payload none.csv --known 100", "give --force, too"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(call, tmp_path, line, words):
    write_crane(tmp_path)
    code, _, err = call(line)
    assert code == 2
    assert words in err
    assert not list(tmp_path.glob("chart*"))


def test_a_payload_is_weighed_from_a_log(call, tmp_path):
    machine = load_machine("wheel_loader")
    at = np.tile([[0.1, 0.2]], (200, 1))
    held = holding_pressures(machine, at[:1], 600.0)[0]
    columns = {"time": 0.02 * np.arange(200)}
    for k, f in enumerate(machine.names):
        columns |= {f"{f}.angle": at[:, k], f"{f}.p_a": np.full(200, held[k, 0]), f"{f}.p_b": np.full(200, held[k, 1])}
    units = {name: {"time": "s", "angle": "rad"}.get(name.split(".")[-1], "Pa") for name in columns}
    write_table(Table(columns, units), tmp_path / "log.csv")
    code, out, _ = call("payload log.csv --machine wheel_loader --out found.csv --plot found.svg")
    assert code == 0
    assert out.count("payload 600 kg") == 2  # of a window, and the mean
    assert read_table(tmp_path / "found.csv")["payload"][0] == pytest.approx(600.0, abs=0.1)
    assert (tmp_path / "found.svg").exists()
    code, out, _ = call("payload log.csv --machine wheel_loader --force --known 600")
    assert code == 0
    assert "force_z" in out
    assert "force_y" not in out
    light = {name: np.full(200, 2e6) if name.endswith(("p_a", "p_b")) else values for name, values in columns.items()}
    write_table(Table(light, units), tmp_path / "light.csv")
    code, out, _ = call("payload light.csv --machine wheel_loader")
    assert code == 0
    assert "warning: less than nothing hangs there" in out


def test_a_chassis_is_checked_where_the_machine_stands(call):
    code, out, _ = call("machine check wheel_loader")
    assert code == 0
    assert "  tips forward, left, rear, right" in out
    assert "stands, 1000 mm from tipping left at its initial positions" in out
