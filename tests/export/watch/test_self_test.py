"""The test that an exported watch brings along: it passes, and finds a number that is another."""

import re
import subprocess

from helpers.watched_logs import known, made_networks
from polydraulic.export.watch.source import export_watch
from polydraulic.watch.watch import FaultWatch

CHECKED = [
    "-std=c99",
    "-O1",
    "-Wall",
    "-Wextra",
    "-pedantic",
    "-Werror",
    "-fsanitize=undefined",
    "-fno-sanitize-recover",
]


def outcome(source, folder):
    """What the test of a source says: 0, or the first block that has other bits."""
    program = folder / "tested"
    subprocess.run(["gcc", *CHECKED, "-DW_SELF_TEST", str(source), "-o", str(program), "-lm"], check=True)
    return subprocess.run([str(program)]).returncode


def test_it_finds_a_number_of_the_machine_and_one_of_the_networks_that_is_another(tmp_path):
    of, expected = known()
    source = export_watch(FaultWatch(of, expected, networks=made_networks(of.directions)), tmp_path, name="w").files[1]
    assert outcome(source, tmp_path) == 0
    text = source.read_text(encoding="utf-8")
    assert not re.search(r"alloc\(|\bwhile\b|\bgoto\b", text)
    for table, first in (("w_numbers_floats", 1), ("w_kinds_link", 2)):  # networks are asked when there is an alarm
        number = re.search(rf"static const double {table}\b.*?(\d\.\d{{9,}})", text, re.DOTALL)
        other = text[: number.start(1)] + repr(float(number[1]) * (1.0 + 1e-12)) + text[number.end(1) :]
        source.write_text(other, encoding="utf-8")
        assert outcome(source, tmp_path) >= first


def test_pressures_of_pumps_have_the_bits_of_the_package(tmp_path):
    of, expected = known("wheel_loader", ("work",))
    assert "work.p_pump" in {channel.name for channel in of.channels}
    files = export_watch(FaultWatch(of, expected), tmp_path, name="w").files
    assert "W_ROW_WORK_P_PUMP" in files[0].read_text(encoding="utf-8")
    assert outcome(files[1], tmp_path) == 0
