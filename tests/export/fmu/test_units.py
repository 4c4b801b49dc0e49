import pytest

from polydraulic.export.fmu.units import display_unit, unit_element
from polydraulic.units import to_si


@pytest.mark.parametrize("unit", ["Pa", "bar", "m3/s", "l/min", "deg"])
def test_a_unit_is_its_base_units_times_a_factor(unit):
    base = unit_element(unit).find("BaseUnit")
    assert float(base.get("factor", "1")) == pytest.approx(to_si(1.0, unit))


def test_pressures_are_masses_over_length_and_time_squared():
    base = unit_element("psi").find("BaseUnit").attrib
    assert {name: base[name] for name in ("kg", "m", "s")} == {"kg": "1", "m": "-1", "s": "-2"}


@pytest.mark.parametrize("unit", ["Pa", "m", "rad/s", "in3/s"])
def test_displayed_units_convert_from_it(unit):
    shown = unit_element(unit).findall("DisplayUnit")
    assert shown
    for other in shown:
        assert float(other.get("factor")) == pytest.approx(to_si(1.0, unit) / to_si(1.0, other.get("name")))
        assert other.get("name") != unit


def test_what_is_read_in_another_unit_offers_it():
    for unit in ("Pa", "m3/s", "m", "rad", "rad/s"):
        assert display_unit(unit) in [other.get("name") for other in unit_element(unit).findall("DisplayUnit")]
    assert display_unit("V") is None


def test_a_unit_that_is_not_known_has_a_name_only():
    found = unit_element("furlong")
    assert (found.get("name"), list(found)) == ("furlong", [])
