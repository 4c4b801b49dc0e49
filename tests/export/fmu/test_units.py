"""Units of FMUs are those of the table."""

from math import pi

import pytest

from polydraulic.export.fmu.units import display_unit, unit_element
from polydraulic.unit_table import KINDS
from polydraulic.units import FACTORS


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
