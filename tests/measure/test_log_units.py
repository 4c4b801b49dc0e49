import sys

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.measure.log_units import conversion, need, quantity, same_kind
from polydraulic.units import FACTORS


@pytest.mark.parametrize("si", FACTORS)
def test_units_of_the_package_convert_as_the_package_does(si):
    for unit, factor in FACTORS[si].items():
        assert conversion(unit) == (factor, 0.0, si, unit)


@pytest.mark.parametrize(
    ("unit", "value", "expected", "si"),
    [
        ("gpm", 1.0, 231 * 0.0254**3 / 60, "m3/s"),  # a gallon is 231 in3
        ("lpm", 60.0, 1e-3, "m3/s"),
        ("barg", 2.0, 2e5, "Pa"),
        ("psig", 1.0, 4.4482216152605 / 0.0254**2, "Pa"),
        ("bara", 1.01325, 0.0, "Pa"),
        ("psia", 14.695948775513, 0.0, "Pa"),
        ("rpm", 60.0, 2 * np.pi, "rad/s"),
        ("rev/min", 60.0, 2 * np.pi, "rad/s"),
        ("PSI", 1.0, 4.4482216152605 / 0.0254**2, "Pa"),
        ("U/min", 60.0, 2 * np.pi, "rad/s"),
        ("°", 180.0, np.pi, "rad"),
        ("degC", 20.0, 293.15, "K"),
        ("°C", 20.0, 293.15, "K"),
        ("kN", 2.0, 2e3, "N"),
        ("MN", 1.0, 1e6, "N"),
        ("Nm", 3.0, 3.0, "N m"),
        ("m/s²", 3.0, 3.0, "m/s2"),
        ("m/s^2", 3.0, 3.0, "m/s2"),
        ("mA", 4.0, 4e-3, "A"),
        ("-", 4.0, 4.0, "1"),
        ("", 4.0, 4.0, "1"),
        ("m2", 4.0, 4.0, "m2"),
        ("cm2", 4.0, 4e-4, "m2"),
    ],
)
def test_units_of_the_field(unit, value, expected, si):
    found = conversion(unit)
    assert found.si == si
    assert found.to_si(value) == pytest.approx(expected, rel=1e-12, abs=1e-6)
    assert found.from_si(found.to_si(value)) == pytest.approx(value, rel=1e-12)
    assert conversion(found.si)[:3] == (1.0, 0.0, si)  # the name can be read again


@pytest.mark.parametrize("unit", ["furlong??", "bar bar(", "liter/", "5", "__import__"])
def test_an_unknown_unit_is_one_error(unit):
    with pytest.raises(InputError, match="unknown unit"):
        conversion(unit)


def test_a_logarithmic_unit_is_refused():
    with pytest.raises(InputError, match="unit 'dB' is not proportional"):
        conversion("dB")


def test_units_of_the_same_kind():
    assert same_kind("bar") == ["Pa", "kPa", "MPa", "psi"]
    assert same_kind("degC") == []


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
