"""Whoever waits is told what for."""

import io
import logging
import time

import pytest

from polydraulic.gym.patience import told_if_long


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize("terminal", [True, False])
def test_what_takes_long_is_said_once(terminal, monkeypatch, caplog):
    shown = Terminal() if terminal else io.StringIO()
    monkeypatch.setattr("sys.stderr", shown)
    with caplog.at_level(logging.INFO, logger="polydraulic"), told_if_long("compiles", patience=0.01):
        end = time.monotonic() + 10.0
        while not caplog.messages and time.monotonic() < end:
            time.sleep(0.01)
        time.sleep(0.05)
    assert caplog.messages == ["compiles"]
    assert shown.getvalue() == ("polydraulic: compiles\n" if terminal else "")


def test_what_is_quick_is_not(monkeypatch, caplog):
    shown = Terminal()
    monkeypatch.setattr("sys.stderr", shown)
    with caplog.at_level(logging.INFO, logger="polydraulic"):
        with pytest.raises(ValueError, match="no"), told_if_long("compiles", patience=0.2):
            raise ValueError("no")
        time.sleep(0.3)
    assert (shown.getvalue(), caplog.messages) == ("", [])
