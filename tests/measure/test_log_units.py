import contextlib
import re
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.errors import InputError
from polydraulic.measure.log_units import conversion, need, quantity, same_kind, says_pressure
from polydraulic.unit_grammar import MOST_NAMES
from polydraulic.units import FACTORS, read_unit


@pytest.mark.parametrize("si", FACTORS)
def test_units_of_the_package_convert_as_the_package_does(si):
    for unit, factor in FACTORS[si].items():
        assert conversion(unit) == (factor, 0.0, si, unit)


@pytest.mark.parametrize("unit", ["bar(a)", "deg C", "cm³/U", "kNm", "PS", "Hz", ""])
def test_the_table_comes_first(unit, monkeypatch):
    monkeypatch.setitem(sys.modules, "pint", None)
    assert conversion(unit) == read_unit(unit)


@pytest.mark.parametrize(
    ("unit", "expected", "si"),
    [
        ("furlong", 201.168, "m"),
        ("slug", 14.593903, "kg"),
        ("knot", 1852.0 / 3600.0, "m/s"),
        ("arcminute", np.pi / 10800.0, "rad"),
        ("BTU", 1055.056, "J"),
        ("foot_pound", 1.3558179483314, "J"),
        ("furlong/min", 201.168 / 60.0, "m/s"),
        ("dyne", 1e-5, "N"),
    ],
)
def test_names_that_the_table_does_not_have_are_those_of_the_library(unit, expected, si):
    found = conversion(unit)
    assert (found.si, found.offset) == (si, 0.0)
    assert found.factor == pytest.approx(expected, rel=3e-6)
    assert conversion(found.si)[:3] == (1.0, 0.0, si)  # the name can be read again


@pytest.mark.parametrize(
    "unit",
    ["lumen", "candela", "mole", "petasiemens", "siemens", "farad", "tesla", "weber", "byte", "kilofurlong", "slpm", "gauss", "point", "cup",
     "degree_Reaumur", "decade", "electron_mass", "zeta", "mm per s", "furlong^3/day^4"],
)  # fmt: skip
def test_what_no_log_of_a_machine_has_is_refused(unit):
    with pytest.raises(InputError, match="^unknown unit .*nearest known units: '.+', '.+', '.+'"):
        conversion(unit)


@pytest.mark.parametrize(
    "unit", ["furlong??", "bar bar(", "liter/", "5", "__import__", "m^^9", "m**9**9**9", "(" * 50, "PS" * 20]
)
def test_an_unknown_unit_is_one_error(unit):
    with pytest.raises(InputError, match="unknown unit"):
        conversion(unit)


@given(st.text(max_size=70))
def test_the_library_sees_single_words_only(text):
    asked = []

    def library(name):
        asked.append(name)

    with contextlib.suppress(InputError):
        read_unit(text, library=library)
    assert len(asked) <= 2 * MOST_NAMES
    assert all(re.fullmatch("[A-Za-z_]{3,24}", name) for name in asked)


@pytest.mark.parametrize(
    "unit", ["furlong^4*slug^4", "a_word^-4 another^4/(yet_another^4)", "x" * 24, "exec(open)", "1e9", "furlong**999"]
)
def test_what_the_library_sees_of_hostile_texts(unit):
    asked = []
    with contextlib.suppress(InputError):
        read_unit(unit, library=lambda name: asked.append(name))
    assert all(name.isidentifier() and len(name) <= 24 for name in asked)


def test_a_logarithmic_unit_is_refused():
    with pytest.raises(InputError, match="unit 'dB' is not proportional"):
        conversion("dB")


def test_units_of_the_same_kind():
    assert same_kind("bar") == ["Pa", "kPa", "MPa", "psi"]
    assert same_kind("degC") == ["K"]


@pytest.mark.parametrize(
    "name", ["p_head", "boom.p_a", "PumpPressure", "pressure A", "Druck_A", "Pilotdruck", "Main p_pump", "x/p_1"]
)
def test_names_that_say_pressure(name):
    assert says_pressure(name)


@pytest.mark.parametrize("name", ["p", "speed", "lamp_p", "pump_p1", "temp_oil", "P1", "xp_a"])
def test_names_that_do_not_say_pressure(name):
    assert not says_pressure(name)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ten ms", "must be a number with its unit in quotes"),
        (10, "must be a number with its unit in quotes"),
        ("1e999 s", "must be a number with its unit in quotes"),
        ("10 bar", "must be in s or a unit of that kind, not in 'bar'"),
        ("10 wurst", "unknown unit 'wurst'"),
    ],
)
def test_a_bad_quantity_is_named(text, message):
    with pytest.raises(InputError, match=message):
        quantity(text, "s", "raster")


def test_a_quantity_is_read_in_si():
    assert quantity("10 ms", "s", "raster") == pytest.approx(0.01)
    assert quantity("2e-3 l/bar", "m3/Pa", "compliance") == pytest.approx(2e-11)


def test_a_missing_library_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "asammdf", None)
    with pytest.raises(InputError, match=r"asammdf is not installed.*pip install 'polydraulic\[measure\]'"):
        need("asammdf")


@pytest.mark.parametrize(
    ("text", "allowed"),
    [
        ("1e20 s", True),
        ("-1e20 s", True),
        ("1.01e20 s", False),
        ("1e-30 s", True),
        ("0.99e-30 s", False),
        ("0 s", True),
    ],
)
def test_a_quantity_is_zero_or_of_a_size_whose_squares_are_numbers(text, allowed):
    if allowed:
        assert quantity(text, "s", "lag") == float(text.split()[0])
    else:
        with pytest.raises(
            InputError, match=f"lag = '{text}': must be 0 or between 1e-30 and 1e20 in size, in SI units"
        ):
            quantity(text, "s", "lag")
