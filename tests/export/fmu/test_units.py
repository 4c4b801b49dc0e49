"""Units of FMUs are those of the table."""

from math import pi

import pytest

from polydraulic.export.fmu.units import display_unit, unit_element
from polydraulic.unit_table import KINDS
from polydraulic.units import FACTORS, to_si


def parts(unit):
    found = unit_element(unit)
    base = found.find("BaseUnit")
    return None if base is None else dict(base.attrib), {
        d.get("name"): float(d.get("factor")) for d in found.findall("DisplayUnit")
    }


@pytest.mark.parametrize(
    ("unit", "base"),
    [
        ("Pa", {"kg": "1", "m": "-1", "s": "-2"}),
        ("bar(g)", {"kg": "1", "m": "-1", "s": "-2", "factor": "100000.0"}),
        ("V", {"kg": "1", "m": "2", "s": "-3", "A": "-1"}),
        ("m/V", {"kg": "-1", "m": "-1", "s": "3", "A": "1"}),
        ("m3/Pa", {"kg": "-1", "m": "4", "s": "2"}),
        ("kNm", {"kg": "1", "m": "2", "s": "-2", "factor": "1000.0"}),
        ("rpm", {"rad": "1", "s": "-1", "factor": repr(2 * pi / 60)}),
        ("1", {}),
    ],
)
def test_base_units(unit, base):
    assert parts(unit)[0] == base


@pytest.mark.parametrize("unit", ["weird/unit", "bar(a)", "degC", "C"])
def test_units_that_fmi_cannot_say_have_a_name_only(unit):
    assert parts(unit) == (None, {})


def test_roots_have_no_base_units_but_can_be_displayed():
    base, shown = parts("Pa^0.5")
    assert base is None
    assert shown["bar^0.5"] == pytest.approx(1e5**-0.5)


def test_what_is_displayed_is_of_the_same_kind():
    for kind in KINDS:
        assert set(parts(kind.si)[1]) == {*kind.offered}
        assert display_unit(kind.si) in (None, *FACTORS[kind.si])


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
