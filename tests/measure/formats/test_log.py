from pathlib import Path

import pytest

from polydraulic.errors import InputError
from polydraulic.measure.formats.log import Log, Signal, once


def log(n, closed=None):
    signals = [Signal(f"s{k}", "bar", 0) for k in range(n)]
    return Log(Path("a.csv"), signals, False, lambda *arguments: iter(()), close=lambda: closed.append(True))


def test_of_a_name_that_comes_twice_the_first_counts():
    first, second, other = Signal("a", "bar", 0), Signal("a", "psi", 1), Signal("b", "", 0)
    assert once([first, other, second, second]) == ([first, other], ["a"])


def test_a_signal_is_found_by_name_or_those_there_are_listed():
    assert log(3).signal("s2") == Signal("s2", "bar", 0)
    with pytest.raises(InputError, match=r"a.csv: no channel 'x'; the log has \['s0', 's1'\]"):
        log(2).signal("x")
    with pytest.raises(InputError, match="'s29'] and 20 more"):
        log(50).signal("x")


def test_a_log_is_closed_at_the_end_of_its_context():
    closed = []
    with pytest.raises(ZeroDivisionError), log(1, closed):
        _ = 1 / 0
    assert closed == [True]
