"""What texts of units mean. Values are of other sources than the table: written out, or made of definitions by other ways."""

from fractions import Fraction
from math import pi

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.unit_table import BASE, DOUBTFUL_ALONE
from polydraulic.units import FACTORS, near, read_unit, unit_kind

PAIRS = [(si, unit) for si, same in FACTORS.items() for unit in same]
PSI = 6894.757293168361
HP, PS = 745.6998715822702, 735.49875
FT_LBF, IN_LBF = 1.3558179483314004, 0.1129848290276167
RPM, DEG, REV = 0.10471975511965977, 0.017453292519943295, 6.283185307179586
US_GPM, UK_GPM, LPM = 6.30901964e-05, 7.576816666666667e-05, 1.6666666666666667e-05

# SI unit -> value of one -> spellings
SPELLINGS = {
    "Pa": {
        1e5: ["bar", "Bar", "BAR", "bars", "[bar]", "(bar)", "bar(g)", "bar (g)", "bar g", "barg", "BARG", "barG", "bar[g]",
              "[bar(g)]", "bar_g", "bar rel", "bar(rel.)", "bar gauge", "barü", "bar Ü", "bar(diff)", "bard"],
        100.0: ["mbar", "mBar", "MBAR", "hPa", "mbar(g)", "mbarg"],
        1e3: ["kPa", "KPA", "kpa", "KPa", "Kpa", "kPa g", "kPa(g)", "kPag"],
        1e6: ["MPa", "MPA", "Mpa", "MPa(g)", "N/mm2", "N/mm²", "N mm^-2", "MN/m²"],
        PSI: ["psi", "PSI", "Psi", "psig", "PSIG", "psi(g)", "psi g", "psid", "lbf/in2", "lbf/in²", "lbf/sq in"],
        98066.5: ["kgf/cm2", "kgf/cm²", "kgf/cm^2", "kp/cm²", "kg/cm2(g)", "kg/cm²g", "at", "atü"],
        101325.0: ["atm"], 101325.0 / 760.0: ["Torr", "torr"], 133.3224: ["mmHg"], 249.0889: ["inH2O", "in H2O"],
    },
    "Pa/s": {1e5: ["bar/s", "bar s-1"]},
    "m3/s": {
        LPM: ["l/min", "L/min", "L/MIN", "l/Min", "lpm", "LPM", "Lpm", "l min-1", "L·min⁻¹", "liter/min", "Liter/minute", "dm3/min"],
        US_GPM: ["gpm", "GPM", "US gpm", "USgpm", "gpm (US)", "gal/min", "US gal/min", "gallons/minute"],
        UK_GPM: ["UK gpm", "imp gpm", "imp. gpm", "igpm", "gpm (UK)", "gpm(imp)", "imperial gpm", "UK gal/min"],
        1.0 / 3600.0: ["m3/h", "m³/h", "m^3/h", "m**3/h", "M3/H", "m3/hr"],
        1.6387064e-05: ["in3/s", "in³/s", "cu in/s", "cu.in/s", "cubic inch/s"],
        1e-6: ["cm3/s", "cc/s", "ml/s", "mL/s"], 0.02831684659 / 60.0: ["cfm", "ft3/min"],
    },
    "m3/rad": {
        1.5915494309189535e-07: ["cc/rev", "cm3/rev", "cm³/rev", "cm³/U", "cm3/r", "cc/U", "ccm/U", "ml/rev", "CC/REV"],
        2.608082238363247e-06: ["in3/rev", "in³/rev", "cu in/rev"], 1.5915494309189535e-04: ["l/rev", "L/U"], 1.0: ["m3/rad"],
    },
    "rad/s": {
        RPM: ["rpm", "RPM", "Rpm", "1/min", "min-1", "min^-1", "min⁻¹", "/min", "U/min", "u/min", "U/Min", "r/min", "rev/min", "Upm", "tr/min",
              "Umdr/min", "1/MIN"],
        REV: ["rev/s", "U/s", "rps"], DEG: ["deg/s", "°/s", "° /s", "º/s", "degrees/s", "DEG/S", "dps"], 1.0: ["rad/s", "rad s^-1", "RAD/S"],
    },
    "rad": {DEG: ["deg", "°", "º", "Deg", "degree", "degrees"], 1e-3: ["mrad"], REV: ["rev", "turn"]},
    "m": {0.01: ["cm", "CM"], 1e-3: ["mm", "MM"], 1e-6: ["um", "µm", "μm"], 0.0254: ["in", "inch", "IN"], 0.3048: ["ft", "feet"],
          2.54e-05: ["thou"]},
    "m/s": {1e-3: ["mm/s", "MM/S", "mm·s⁻¹", "mm/sec"], 0.0254: ["in/s", "in/sec", "inch/s"], 1.0 / 3.6: ["km/h", "kph", "KM/H"],
            0.44704: ["mph"]},
    "N s/m": {1e3: ["kN s/m", "kN·s/m", "N s/mm"], 1.0: ["N s/m"]}, "kg/s": {1.0: ["kg/s"], 1.0 / 3600.0: ["kg/h"], 1.0 / 3.6: ["t/h"], 1e-3: ["g/s"]},
    "m/s2": {1.0: ["m/s2", "m/s²", "m/s^2", "m/s**2", "m s-2", "m·s⁻²", "m/s/s", "m/sec2", "M/S2"], 9.80665: ["g0", "gn", "g_n"]},
    "m2": {1e-4: ["cm2", "cm²", "sq cm"], 6.4516e-4: ["in2", "sq in", "sq. in", "square inch"]},
    "m3": {1e-3: ["l", "L", "liter", "Litre"], 1e-6: ["cm3", "cc", "ml"], 3.785411784e-3: ["gal", "US gal"], 4.54609e-3: ["UK gal", "imp gal"]},
    "kg": {1e3: ["t", "tonne", "metric ton"], 907.18474: ["short ton", "short_ton", "US ton"], 1016.0469088: ["long ton", "UK ton"],
           0.45359237: ["lb", "lbs", "LB"], 1e-3: ["gram"], 1.0: ["kg", "KG", "Kg"]},
    "kg/m3": {1e3: ["g/cm3", "g/cm³", "kg/l", "t/m3"]},
    "N": {1e3: ["kN", "KN", "kilonewton"], 9.80665: ["kgf", "kp"], 4.4482216152605: ["lbf"], 10.0: ["daN"], 1.0: ["N", "newton"]},
    "N m": {
        1e3: ["kNm", "kN m", "kN·m", "kN*m", "kN.m", "kN-m", "KNm", "kN⋅m"], 1.0: ["Nm", "N m", "N·m", "N-m", "(N m)"],
        FT_LBF: ["lbf.ft", "lbf ft", "ft-lb", "ft lbf", "lb-ft", "ft·lbf", "ftlb"], IN_LBF: ["in-lb", "in lbf", "lbf·in"],
        9.80665: ["kgf m", "kp m", "kgf·m"],
    },
    "W": {1e3: ["kW", "KW", "kw"], HP: ["hp", "HP", "bhp", "hp(I)"], PS: ["PS", "hp(M)", "metric hp", "hp (metric)"], 1.0: ["N m/s", "V A"]},
    "J": {3.6e6: ["kWh", "kW h", "kW·h"], 1e3: ["kJ"]},
    "1": {1.0: ["", "-", "1", "[-]", "(-)", "m/m", "count"], 0.01: ["%", "[%]", "pct", "percent"], 1e-3: ["‰", "mm/m", "mV/V"], 1e-6: ["ppm"]},
    "K": {1.0: ["K", "Kelvin", "delta_degC", "Δ°C", "delta degC", "ΔK"], 5.0 / 9.0: ["delta_degF", "Δ°F"]},
    "K/s": {1.0: ["K/s", "°C/s", "degC/s", "deg C/s"], 1.0 / 108.0: ["°F/min"]},
    "1/s": {1.0: ["Hz", "HZ", "1/s", "s-1"], 1e3: ["kHz"], 0.01: ["%/s"]},
    "s": {1e-3: ["ms", "msec"], 1e-6: ["us", "µs"], 60.0: ["min", "Min", "MIN", "minute"], 3600.0: ["h", "hr"]},
    "V": {1.0: ["V", "volt"], 1e-3: ["mV"]}, "A": {1e-3: ["mA"]}, "Ohm": {1.0: ["Ohm", "Ω", "Ω"], 1e3: ["kOhm", "kΩ"]},
    "A s": {3600.0: ["Ah", "A h"], 1.0: ["coulomb"]},
    "Pa s": {1e-3: ["mPa s", "mPa·s", "mPas", "cP"]}, "m2/s": {1e-6: ["cSt", "mm2/s", "mm²/s"]},
    "N m/rad": {180.0 / pi: ["N m/deg", "Nm/°"]}, "N m s": {1.0: ["N m s", "N m s/rad", "Nm/(rad/s)"]},
    "m3/s/Pa": {LPM / 1e5: ["l/min/bar", "l/(min bar)", "l/(min·bar)", "l min-1 bar-1"]},
    "Pa^0.5": {1e5**0.5: ["bar^0.5"]}, "kg m2": {1.0: ["kg m2", "kg·m²"]},
}  # fmt: skip
ALL = [(text, si, value) for si, of in SPELLINGS.items() for value, texts in of.items() for text in texts]


@pytest.mark.parametrize(("text", "si", "value"), ALL, ids=[repr(text) for text, _, _ in ALL])
def test_spellings_of_the_field(text, si, value):
    found = read_unit(text)
    assert (found.si, found.offset, found.unit) == (si, 0.0, text)
    assert found.factor == pytest.approx(value, rel=1e-9 if "cfm" in text or "ft3" in text else 4e-16)


def test_there_are_many_spellings():
    assert len({text for text, _, _ in ALL}) > 250


# text -> pressure in Pa of one of it, above an atmosphere of 101325 Pa
ABSOLUTE = {
    "bar(a)": 1e5, "bar (a)": 1e5, "bar a": 1e5, "bara": 1e5, "barA": 1e5, "BARA": 1e5, "bar abs": 1e5, "bar(abs)": 1e5, "bar[a]": 1e5,
    "[bar(a)]": 1e5, "bar abs.": 1e5, "bar absolute": 1e5, "bar_a": 1e5, "psi(a)": PSI, "psia": PSI, "PSIA": PSI, "psi abs": PSI, "kPa(a)": 1e3,
    "kPa a": 1e3, "kPa abs": 1e3, "kPaa": 1e3, "mbar(a)": 100.0, "mbara": 100.0, "MPa(abs)": 1e6, "MPa(a)": 1e6, "Pa(a)": 1.0,
    "hPa abs": 100.0, "kgf/cm2(a)": 98066.5, "kg/cm2 abs": 98066.5, "ata": 98066.5, "inHg abs": 3386.389, "N/mm2(abs)": 1e6,
}  # fmt: skip


@pytest.mark.parametrize("text", ABSOLUTE)
def test_absolute_pressures_lose_the_atmosphere(text):
    found = read_unit(text)
    assert found.absolute
    assert (found.si, found.factor, found.offset) == ("Pa", pytest.approx(ABSOLUTE[text], rel=4e-16), -101325.0)
    assert read_unit(text, atmosphere=95e3).to_si(3.0) == pytest.approx(3.0 * ABSOLUTE[text] - 95e3, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "value", "kelvin"),
    [
        *((text, 20.0, 293.15) for text in ("degC", "deg C", "deg. C", "deg_C", "°C", "° C", "º C", "oC", "℃", "C°", "DEGC", "Celsius")),
        *((text, 20.0, 293.15) for text in ("grad C", "degrees C", "degree Celsius", "[°C]", "(deg C)")),
        *((text, 212.0, 373.15) for text in ("degF", "deg F", "°F", "℉", "Fahrenheit", "deg. F")),
        *((text, 300.0, 300.0) for text in ("K", "degK", "deg K")),
        ("degR", 540.0, 300.0),
    ],
)  # fmt: skip
def test_temperatures_have_their_zero(text, value, kelvin):
    found = read_unit(text)
    assert found.si == "K"
    assert found.to_si(value) == pytest.approx(kelvin, rel=1e-14)
    assert found.from_si(kelvin) == pytest.approx(value, rel=1e-13)


# what must not be guessed -> what its message must offer
CHOICES = {
    "C": ["degC", "coulomb"], "F": ["degF"], "g": ["gn", "g0", "gram"], "G": ["gn", "gram"], "mg": ["gn", "milligram"],
    "ton": ["t (1000 kg)", "short_ton", "long_ton"], "tons": ["short_ton"], "TON": ["long_ton"], "T": ["t (1000 kg)"],
    "kg/cm2": ["kgf/cm2"], "kg/cm²": ["kgf/cm2"], "lb/in2": ["lbf/in2"], "kg m": ["kgf m"], "KG/CM2": ["kgf/cm2"], "t/m2": ["tf/m2"], "S": ["s (time)"], "M": ["m (length)"],
    "nm": ["N m"], "NM": ["N m"], "ps": ["PS"], "grad": ["deg", "gon"], "mil": ["thou", "mrad"], "mPa": ["MPa"], "U": ["rev", "V"],
    "kn": ["kN"], "r": ["rev"], "fps": ["ft/s"], "H": ["h (time)"], "C/s": ["degC"], "ton/h": ["t (1000 kg)"],
}  # fmt: skip


@pytest.mark.parametrize("text", CHOICES)
def test_what_can_be_read_in_several_ways_is_refused_with_the_choices(text):
    with pytest.raises(InputError) as caught:
        read_unit(text)
    said = str(caught.value)
    assert repr(text) in said
    assert any(choice in said for choice in CHOICES[text][1:] or CHOICES[text])
    assert CHOICES[text][0] in said


def test_a_mass_on_an_area_is_the_technical_atmosphere_where_pressure_is_known():
    assert read_unit("kg/cm2", kind="Pa")[:3] == (98066.5, 0.0, "Pa")
    assert read_unit("lb/in2", kind="Pa").factor == pytest.approx(PSI, rel=1e-15)
    assert read_unit("kg/s", kind="Pa").si == "kg/s"


UNKNOWN = [
    "furlong??", "bar bar(", "liter/", "5", "10 bar", "__import__", "//", ")(", "((((((m))))))", "m(s", "m9", "m33", "m^99999999", "m^-9", "m**m",
    "l/min bar", "l/100km", "NL/min", "Nm3/h", "Mbar", "MV", "GN", "MA", "mS", "pA", "W/m2", "degC bar", "bar(g)(a)", "barga", "bar*g", "kg2/m/s2",
    "mm/rev", "m/rad", "psi^psi", "m" * 10_000, "(" * 59, "m m m m m m m m m", "bar\n\n/", "\x00", "½ m", "m4 m4 m4", "l/min/", "^2", "-5",
]  # fmt: skip


@pytest.mark.parametrize("text", UNKNOWN, ids=[repr(text[:20]) for text in UNKNOWN])
def test_anything_else_is_refused_with_the_three_nearest(text):
    with pytest.raises(InputError, match=r"^unknown unit .*; nearest known units: '.+', '.+', '.+'$") as caught:
        read_unit(text)
    assert len(str(caught.value)) < 250
    assert all(read_unit(unit) for unit in near(text) if unit not in DOUBTFUL_ALONE)


def test_the_nearest_units_are_near():
    assert "l/min" in near("l/mim")
    assert "bar" in near("barq")
    assert "psi" in near("psj")
    assert "kgf/cm2" in near("kgcm2")


@given(st.text(max_size=80))
@example("m" * 61)
@example("bar(")
@example("²")
@example("°")
@example("ﷺ" * 60)
def test_any_text_is_a_unit_or_one_error(text):
    try:
        found, said = read_unit(text), ""
    except InputError as error:
        found, said = None, str(error)
    if found is None:
        assert any(
            words in said for words in ("nearest known units", "several ways", "of a mass", "not proportional")
        ), said
    else:
        assert found.si in FACTORS
        assert 0.0 < found.factor < float("inf")


WORDS = st.sampled_from(["m", "mm", "bar", "s", "min", "kg", "N", "l", "in", "psi", "rev", "V", "g", "lb", "C"])
POWERS = st.sampled_from(["", "2", "3", "^2", "-1", "^0.5", "²", "^-2", "4"])


@given(
    st.lists(st.tuples(WORDS, POWERS, st.sampled_from(["/", " ", "·", "*", ".", "/(", ")"])), min_size=1, max_size=6)
)
def test_products_are_read_by_their_parts_or_refused(parts):
    text = "".join(word + power + sign for word, power, sign in parts)
    try:
        found = read_unit(text)
    except InputError:
        return
    by_base = {si: unit_kind(si).base for si in FACTORS}
    assert len(by_base[found.si]) == len(BASE)
    assert np.isfinite(found.factor)


@given(st.sampled_from(PAIRS), st.floats(-1e9, 1e9))
def test_there_and_back(pair, value):
    _, unit = pair
    assert units.from_si(units.to_si(value, unit), unit) == pytest.approx(value, rel=1e-15, abs=1e-300)


@given(st.sampled_from([text for text, _, _ in ALL] + [*ABSOLUTE, "degC", "degF"]), st.floats(-1e6, 1e6))
def test_there_and_back_in_every_spelling(text, value):
    found = read_unit(text)
    assert found.from_si(found.to_si(value)) == pytest.approx(
        value, rel=1e-12, abs=1e-9 + abs(found.offset / found.factor) * 1e-14
    )


def test_signs_of_zero_and_arrays_go_through():
    assert np.signbit(units.to_si(-0.0, "psi"))
    assert units.to_si(np.array([1.0, 2.0]), "bar").tolist() == [1e5, 2e5]
    assert units.from_si(np.array([293.15]), "degC") == pytest.approx([20.0])


# Runs, models and exports stand on these very numbers.
BITS = {
    "in": 0.0254, "in3/s": 0.0254**3, "psi": 4.4482216152605 / 0.0254**2, "in3/psi": 0.0254**3 / (4.4482216152605 / 0.0254**2), "deg": pi / 180.0,
    "deg/s": pi / 180.0, "rpm": 2 * pi / 60, "in/V": 0.0254, "kN m": 1e3, "bar^0.5": 1e5**0.5, "l/min": 1e-3 / 60, "l/bar": 1e-8,
    "in3/s/psi": 0.0254**3 / (4.4482216152605 / 0.0254**2), "l/min/bar": 1e-8 / 60, "l/min/bar^0.5": 1e-3 / 60 / 1e5**0.5,
    "psi^0.5": (4.4482216152605 / 0.0254**2) ** 0.5, "in3/s/psi^0.5": 0.0254**3 / (4.4482216152605 / 0.0254**2) ** 0.5,
    "cm3/rev": 1e-6 / (2 * pi), "in3/rev": 0.0254**3 / (2 * pi), "%": 0.01, "mV": 1e-3, "ms": 1e-3, "mm": 1e-3, "mm/V": 1e-3,
}  # fmt: skip


@pytest.mark.parametrize("unit", BITS)
def test_factors_keep_their_bits(unit):
    assert FACTORS[units.si_unit(unit)][unit] == BITS[unit]


@pytest.mark.parametrize(
    ("unit", "exact"),
    [
        ("kgf/cm2", Fraction("98066.5")), ("g/cm3", Fraction(1000)), ("l/min", Fraction(1, 60_000)), ("gpm", Fraction(231) * Fraction("0.0254") ** 3 / 60),
        ("kWh", Fraction(3_600_000)), ("PS", 75 * Fraction("9.80665")), ("hp", 550 * Fraction("0.3048") * Fraction("4.4482216152605")),
        ("imp_gpm", Fraction("0.00454609") / 60), ("km/h", Fraction(1000, 3600)), ("lb", Fraction("0.45359237")), ("cm2", Fraction(1, 10_000)),
    ],
)  # fmt: skip
def test_factors_are_those_of_the_definitions(unit, exact):
    assert read_unit(unit).factor == float(exact)


def test_unknown_unit_names_the_choices():
    with pytest.raises(InputError, match="unknown unit 'furlong'; nearest known units"):
        units.to_si(1.0, "furlong")
