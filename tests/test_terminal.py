import sys
import time

import pytest

from polydraulic import terminal
from polydraulic.simulation.trajectory import Difference


@pytest.fixture
def terminals(monkeypatch):
    """A terminal, and the time since the command began."""

    def use(is_terminal, seconds):
        monkeypatch.setattr(sys.stderr, "isatty", lambda: is_terminal, raising=False)
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.delenv("FORCE_COLOR", raising=False)
        monkeypatch.setattr(terminal, "_BEGAN", time.monotonic() - seconds)

    return use


def work():
    with terminal.progress_bar("work") as progress:
        progress("first", 0, 2)
        time.sleep(0.2)  # the timer's thread needs a moment
        progress("second", 2, 2)


@pytest.mark.parametrize(
    ("is_terminal", "seconds", "shown"), [(True, -600.0, False), (True, 3.0, True), (False, 3.0, False)]
)
def test_progress_appears_when_a_command_takes_long_and_someone_looks(terminals, capsys, is_terminal, seconds, shown):
    terminals(is_terminal, seconds)
    work()
    printed = capsys.readouterr()
    assert ("2/2" in printed.err) is shown
    assert ("work: first" in printed.err) is shown
    assert printed.out == ""
    if not shown:
        assert printed.err == ""


def test_loading_is_shown_until_the_work_begins(terminals, capsys):
    terminals(True, 3.0)
    with terminal.loading():
        time.sleep(0.2)
        assert "loading" in capsys.readouterr().err
        work()
        printed = capsys.readouterr().err
        assert "2/2" in printed
        assert "loading" not in printed.split("work: first")[-1]
    terminals(True, -600.0)
    with terminal.loading():
        pass
    assert capsys.readouterr().err == ""


def test_output_goes_past_the_bar(terminals, capsys):
    terminals(True, 3.0)
    with terminal.progress_bar("work"):
        time.sleep(0.2)
        print("a result")
    assert capsys.readouterr().out == "a result\n"


def test_an_error_ends_the_progress(terminals):
    terminals(True, 3.0)
    with pytest.raises(ValueError, match="mine"), terminal.progress_bar("work"):
        raise ValueError("mine")


def test_differences_go_by_the_functions_and_circuits_of_the_machine(capsys):
    units = {
        "slew.angle": "rad",
        "slew.spool": "m",
        "reach.position": "m",
        "reach.p_in": "Pa",
        "arm.p_pump": "Pa",
        "effector.distance": "m",
    }
    terminal.print_differences({name: Difference(unit, 1.0, 0.5, 0.1, 0.2) for name, unit in units.items()}, "metric")
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[2:]]
    named = [(row[0], row[-1]) for row in rows if len(row) > 2]
    assert named == [
        ("slew.angle", "deg"),
        ("reach.position", "mm"),
        ("reach.p_in", "bar"),
        ("arm.p_pump", "bar"),
        ("tip", "mm"),
    ]
