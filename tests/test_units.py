import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic import units
from polydraulic.errors import InputError

PAIRS = [(si, unit) for si, same in units.FACTORS.items() for unit in same]


@given(st.sampled_from(PAIRS), st.floats(-1e9, 1e9))
def test_there_and_back(pair, value):
    _, unit = pair
    assert units.from_si(units.to_si(value, unit), unit) == pytest.approx(value, rel=1e-15, abs=1e-300)


@pytest.mark.parametrize(
    ("value", "unit", "si"),
    [
        (1.0, "in", 0.0254),
        (1.0, "psi", 6894.757293168361),
        (1.0, "in3/s", 1.6387064e-5),
        (180.0, "deg", 3.141592653589793),
        (60000.0, "l/min", 1.0),
        (1.0, "in3/s/psi^0.5", 1.6387064e-5 / 6894.757293168361**0.5),
        (6.283185307179586, "cm3/rev", 1e-6),
    ],
)
def test_known_values(value, unit, si):
    assert units.to_si(value, unit) == pytest.approx(si, rel=1e-12)


def test_unknown_unit_names_the_choices():
    with pytest.raises(InputError, match="unknown unit 'furlong'.*'in'"):
        units.to_si(1.0, "furlong")


def test_si_units_have_factor_one():
    assert all(same[si] == 1.0 for si, same in units.FACTORS.items())
