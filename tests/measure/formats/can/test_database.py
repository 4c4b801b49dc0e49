"""Databases that are damaged, or say what no number can be."""

from types import SimpleNamespace

import numpy as np
import pytest

from helpers.can_made import DBC, bus, write_bus
from polydraulic.errors import InputError
from polydraulic.measure import open_log
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.can.database import Messages, _no_number, j1939_codes, parameter_group


def database(tmp_path, old, new):
    assert old in DBC
    (tmp_path / "a.dbc").write_text(DBC.replace(old, new))
    return tmp_path / "a.dbc"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("Valve: 8", "Valve: 4096", "message 'Valve' has 4096 bytes; at most 4095"),
        ("spool : 12|", "spool : 32761|", "signal 'spool' begins at bit 32761; at most 32760"),
        ("spool : 12|13@", f"spool : 12|{'9' * 400}@", "signal 'spool' has 9{20} bits; at most 32760"),
        ("2-3, 5-5", "2-65538, 5-5", "signal 'b' is there for multiplexer values from 2 to 65538; a range holds at most"),
        ("2-3, 5-5", f"2-{'9' * 400}", "signal 'b' is there for multiplexer values from 2 to 9{20}; a range"),
    ],
)  # fmt: skip
def test_sizes_that_would_fill_the_memory_are_refused_before_they_do(tmp_path, old, new, said):
    with pytest.raises(InputError, match=said):
        Messages([database(tmp_path, old, new)])


@pytest.mark.parametrize(
    ("old", "new"), [("Valve: 8", "Valve: 4095"), ("late : 56|8", "late : 80|64"), ("2-3, 5-5", "2-65537")]
)
def test_the_largest_sizes_are_taken(tmp_path, old, new):
    assert Messages([database(tmp_path, old, new)]).exact


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("temp : 40|8@", "temp : 40|65@", "has 65 bits, as a text has; a number has at most 64"),
        ("VAL_ 256 mode", "SIG_VALTYPE_ 256 temp : 1;\nVAL_ 256 mode", "is a real number of 8 bits"),
        ("(0.4,-40)", "(1e400,-40)", "its factor inf or offset -40 is no finite number"),
        ("(0.4,-40)", "(0.4,-1e400)", "its factor 0.4 or offset -inf is no finite number"),
    ],
)
def test_signals_that_are_no_numbers_are_left_out_by_name(tmp_path, old, new, reason):
    with open_log(write_bus(tmp_path / "a.blf", bus(5)), dbc=[database(tmp_path, old, new)]) as log:
        assert reason in log.left_out["temp"]
        assert "temp" not in [signal.name for signal in log.signals]
        (block,) = log.read(log.signal("spool").group, ["spool"], None, Findings())
        assert np.isfinite(block.values["spool"]).all()


def test_signals_below_a_multiplexer_that_is_no_number_are_left_out_too(tmp_path):
    path = database(tmp_path, "inner m1M : 4|4@", "inner m1M : 4|65@")
    with open_log(write_bus(tmp_path / "a.blf", bus(5)), dbc=[path]) as log:
        assert log.left_out["b"] == "its multiplexer 'inner' has 65 bits, as a text has; a number has at most 64"
        assert {"page", "a"} <= {signal.name for signal in log.signals}


@pytest.mark.parametrize(
    ("length", "codes"),
    [
        (2, [(2, 2, "error"), (3, 3, "not available")]),
        (4, [(14, 14, "error"), (15, 15, "not available")]),
        (10, [(1022, 1022, "error"), (1023, 1023, "not available")]),
        (8, [(251, 251, "parameter specific"), (252, 253, "reserved"), (254, 254, "error"), (255, 255, "not available")]),
        (12, [(0xFB0, 0xFBF, "parameter specific"), (0xFC0, 0xFDF, "reserved"), (0xFE0, 0xFEF, "error"), (0xFF0, 0xFFF, "not available")]),
        (16, [(0xFB00, 0xFBFF, "parameter specific"), (0xFC00, 0xFDFF, "reserved"), (0xFE00, 0xFEFF, "error"),
              (0xFF00, 0xFFFF, "not available")]),
        (32, [(251 << 24, (252 << 24) - 1, "parameter specific"), (252 << 24, (254 << 24) - 1, "reserved"),
              (254 << 24, (255 << 24) - 1, "error"), (255 << 24, (1 << 32) - 1, "not available")]),
        (1, []), (3, []), (7, []), (9, []), (11, []), (33, []), (64, []),
    ],
)  # fmt: skip
def test_raw_values_that_are_none_by_the_standard(length, codes):
    """SAE J1939-71, ranges of transmitted signals, and states of discrete parameters."""
    assert [tuple(code) for code in j1939_codes(length)] == codes


def test_a_group_has_a_destination_below_format_240():
    assert parameter_group(0x18EF0703) == 0xEF00
    assert parameter_group(0x18F00703) == 0xF007


@pytest.mark.parametrize("length", [8, 12, 16, 20, 24, 32, 40, 48, 64])
def test_real_numbers_have_16_32_or_64_bits(length):
    signal = SimpleNamespace(length=length, is_float=True, scale=1.0, offset=0.0, multiplexer_signal=None)
    told = f"is a real number of {length} bits; there are those of 16, 32 and 64"
    assert _no_number(signal, {}) == ("" if length in (16, 32, 64) else told)
    signal.is_float = False
    assert _no_number(signal, {}) == ""
