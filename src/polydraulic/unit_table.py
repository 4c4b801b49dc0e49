"""The units of this field, once: what is measured, in which SI unit, and what else it is written in.

Logs, parameter sets, FMUs and the command line all read this table. Factors are SI units in one unit. They are exact where the unit is
defined by a number (NIST Special Publication 811, 2008 edition, appendix B): inch, pound, standard gravity, US gallon (231 cubic
inches), imperial gallon, litre, atmosphere, technical atmosphere, horsepower (550 ft lbf/s), metric horsepower (75 kgf m/s), torr.
Conventional columns of mercury and water are those of its section B.8.
"""

from math import pi
from typing import NamedTuple

GRAVITY = 9.80665  # m/s2, standard acceleration of free fall
INCH, FOOT, YARD, MILE = 0.0254, 0.3048, 0.9144, 1609.344
CUBIC_INCH = INCH**3
POUND = 0.45359237
POUND_FORCE = 4.4482216152605
PSI = POUND_FORCE / INCH**2  # one pound-force on a square inch
US_GALLON, IMPERIAL_GALLON = 3.785411784e-3, 4.54609e-3  # m3; the first is 231 cubic inches
DEGREE = pi / 180.0
REVOLUTION = 2.0 * pi
ATMOSPHERE = 101325.0  # Pa, the standard atmosphere

BASE = ("kg", "m", "s", "A", "K", "rad")
Exponents = tuple[float, ...]  # of the units in `BASE`


class UnitKind(NamedTuple):
    """One thing that is measured.

    Attributes
    ----------
    name : str
        In words.
    si : str
        Its SI unit, as the package writes it.
    base : tuple of float
        Exponents of the base units in that SI unit.
    offered : tuple of str
        Other units in which people are shown it; they may be products.
    symbols : dict from float to str
        Factor -> names of single units, apart by blanks, the usual one first.
    products : tuple of str
        Examples of products that are read, too.
    """

    name: str
    si: str
    base: Exponents
    offered: tuple[str, ...]
    symbols: dict[float, str]
    products: tuple[str, ...] = ()


def _kind(
    name: str, si: str, base: str, offered: str = "", symbols: dict[float, str] | None = None, products: str = ""
) -> UnitKind:
    """A row of the table; `base` as in ``"kg m-1 s-2"``, `offered` and `products` apart by commas."""
    powers = dict.fromkeys(BASE, 0.0)
    for part in base.split():
        letters = part.rstrip("-0123456789.")
        powers[letters] = float(part[len(letters) :] or 1.0)
    lists = [tuple(text.split(", ")) if text else () for text in (offered, products)]
    return UnitKind(name, si, tuple(powers.values()), lists[0], symbols or {}, lists[1])


# Where two kinds have the same base units, products are of the first.
KINDS: tuple[UnitKind, ...] = (
    _kind("number", "1", "", "%", {
        1.0: "count counts", 0.01: "% pct percent Prozent", 1e-3: "‰ permille Promille", 1e-6: "ppm",
    }),
    _kind("voltage", "V", "kg m2 s-3 A-1", "mV", {1.0: "V volt volts", 1e-3: "mV millivolt", 1e-6: "uV", 1e3: "kV"}),
    _kind("current", "A", "A", "mA", {1.0: "A amp amps ampere amperes", 1e-3: "mA milliamp", 1e-6: "uA", 1e3: "kA"}),
    _kind("resistance", "Ohm", "kg m2 s-3 A-2", "kOhm", {1.0: "Ohm ohms", 1e3: "kOhm", 1e6: "MOhm", 1e-3: "mOhm"}),
    _kind("charge", "A s", "A s", "Ah", {1.0: "coulomb coulombs", 3600.0: "Ah", 3.6: "mAh"}),
    _kind("time", "s", "s", "ms", {
        1.0: "s sec secs second seconds Sek Sekunde Sekunden", 1e-3: "ms msec millisecond milliseconds", 1e-6: "us usec microsecond",
        1e-9: "ns nsec nanosecond", 60.0: "min Min mins minute minutes", 3600.0: "h hr hrs hour hours Std", 86400.0: "d day days",
    }),
    _kind("frequency", "1/s", "s-1", "Hz, kHz", {1.0: "Hz hertz", 1e3: "kHz", 1e6: "MHz"}),
    _kind("length", "m", "m", "mm, in", {
        1.0: "m meter meters metre metres", 0.1: "dm", 0.01: "cm centimeter centimetre", 1e-3: "mm millimeter millimeters millimetre",
        1e-6: "um micrometer micrometre micron", 1e3: "km kilometer kilometre", INCH: "in inch inches zoll", FOOT: "ft foot feet",
        INCH / 1e3: "thou", YARD: "yd yard yards", MILE: "mi mile miles",
    }),
    _kind("area", "m2", "m2", "cm2, mm2, in2", None, "ft2"),
    _kind("volume", "m3", "m3", "l, cm3, in3, gal", {
        1e-3: "l L liter liters litre litres ltr lit", 1e-6: "cc ccm ml mL milliliter millilitre", 1e-5: "cl", 1e-4: "dl",
        US_GALLON: "gal gallon gallons", IMPERIAL_GALLON: "imp_gal",
    }, "mm3, dm3, ft3"),
    _kind("curvature", "1/m", "m-1"),
    _kind("angle", "rad", "rad", "deg", {
        1.0: "rad radian radians", 1e-3: "mrad", DEGREE: "deg degs degree degrees", DEGREE / 1e3: "mdeg", pi / 200.0: "gon",
        REVOLUTION: "rev revs revolution revolutions turn turns r U u tr Umdr Umdrehung",
    }),
    _kind("angular speed", "rad/s", "rad s-1", "deg/s, rpm", {
        REVOLUTION / 60.0: "rpm Upm", REVOLUTION: "rps", DEGREE: "dps",
    }, "1/min, U/min, r/min, rev/s"),
    _kind("angular acceleration", "rad/s2", "rad s-2", "deg/s2"),
    _kind("angular jerk", "rad/s3", "rad s-3"),
    _kind("speed", "m/s", "m s-1", "mm/s, in/s, km/h", {1.0: "mps", 1.0 / 3.6: "kmh kph", MILE / 3600.0: "mph"}, "cm/s, ft/s, m/min"),
    _kind("acceleration", "m/s2", "m s-2", "", {GRAVITY: "gn"}),
    _kind("jerk", "m/s3", "m s-3"),
    _kind("mass", "kg", "kg", "", {
        1.0: "kg kilogram kilograms", 1e-3: "g gram grams", 1e-6: "mg milligram", 1e3: "t tonne tonnes metric_ton",
        POUND: "lb lbs lbm pound pounds", 2000.0 * POUND: "short_ton US_ton", 2240.0 * POUND: "long_ton UK_ton",
    }),
    _kind("mass flow", "kg/s", "kg s-1", "kg/h"),
    _kind("moment of inertia", "kg m2", "kg m2"),
    _kind("density", "kg/m3", "kg m-3", "g/cm3"),
    _kind("force", "N", "kg m s-2", "kN, kgf, lbf", {
        1.0: "N newton newtons", 1e-3: "mN", 10.0: "daN", 1e3: "kN kilonewton", 1e6: "MN", GRAVITY: "kgf kp", 1e3 * GRAVITY: "tf",
        POUND_FORCE: "lbf", 1e3 * POUND_FORCE: "klbf kip",
    }),
    _kind("force rate", "N/s", "kg m s-3", "kN/s"),
    _kind("stiffness", "N/m", "kg s-2", "N/mm"),
    _kind("torque", "N m", "kg m2 s-2", "kN m", {
        1.0: "Nm", 1e3: "kNm", 1e6: "MNm", 1e-3: "mNm Nmm", 10.0: "daNm", 0.01: "Ncm",
        FOOT * POUND_FORCE: "ftlbf ftlb lbfft lbft", INCH * POUND_FORCE: "inlbf inlb lbfin lbin",
    }, "lbf ft, ft lb, in lbf, kgf m"),
    _kind("energy", "J", "kg m2 s-2", "kJ, kWh", {
        1.0: "J joule joules", 1e3: "kJ", 1e6: "MJ", 3600.0: "Wh", 3.6e6: "kWh",
    }),
    _kind("angular damping", "N m s", "kg m2 s-1"),
    _kind("linear damping", "N s/m", "kg s-1", "kN s/m", None, "N s/mm"),
    _kind("angular stiffness", "N m/rad", "kg m2 s-2 rad-1"),
    _kind("power", "W", "kg m2 s-3", "kW, hp, PS", {
        1.0: "W watt watts VA", 1e-3: "mW", 1e3: "kW kilowatt kilowatts kVA", 1e6: "MW",
        550.0 * FOOT * POUND_FORCE: "hp bhp horsepower", 75.0 * GRAVITY: "PS metric_hp",
    }),
    _kind("spool gain", "m/V", "kg-1 m-1 s3 A", "mm/V, in/V"),
    _kind("voltage rate", "V/s", "kg m2 s-4 A-1"),
    _kind("current rate", "A/s", "A s-1"),
    _kind("pressure", "Pa", "kg m-1 s-2", "kPa, MPa, bar, psi", {
        1.0: "Pa pascal", 1e-3: "mPa", 100.0: "mbar mBar millibar hPa", 1e3: "kPa kPA", 1e6: "MPa Mpa MPA", 1e9: "GPa", 1e5: "bar bars",
        PSI: "psi", 1e3 * PSI: "ksi", 1e4 * GRAVITY: "at", ATMOSPHERE: "atm", ATMOSPHERE / 760.0: "Torr", 133.3224: "mmHg",
        3386.389: "inHg", GRAVITY: "mmWC mmWS", 10.0 * GRAVITY: "cmWC", 1e3 * GRAVITY: "mWC mWS", 249.0889: "inWC",
    }, "kgf/cm2, lbf/in2, N/mm2"),
    _kind("pressure rate", "Pa/s", "kg m-1 s-3", "bar/s"),
    _kind("root of pressure", "Pa^0.5", "kg0.5 m-0.5 s-1", "bar^0.5, psi^0.5"),
    _kind("flow", "m3/s", "m3 s-1", "l/min, in3/s", {
        1e-3 / 60.0: "lpm", US_GALLON / 60.0: "gpm", IMPERIAL_GALLON / 60.0: "imp_gpm", FOOT**3 / 60.0: "cfm",
    }, "L/min, m3/h, cm3/s, gal/min"),
    _kind("flow rate of change", "m3/s2", "m3 s-2"),
    _kind("compliance", "m3/Pa", "kg-1 m4 s2", "l/bar, in3/psi"),
    _kind("leakage", "m3/s/Pa", "kg-1 m4 s", "l/min/bar, in3/s/psi"),
    _kind("conductance of an orifice", "m3/s/Pa^0.5", "kg-0.5 m3.5", "l/min/bar^0.5, in3/s/psi^0.5"),
    _kind("displacement", "m3/rad", "m3 rad-1", "cm3/rev, in3/rev", None, "cc/rev, ml/rev, cm3/U, l/rev"),
    _kind("dynamic viscosity", "Pa s", "kg m-1 s-1", "mPa s", {1.0: "Pas", 1e-3: "mPas cP", 0.1: "poise"}),
    _kind("kinematic viscosity", "m2/s", "m2 s-1", "mm2/s", {1e-6: "cSt centistokes", 1e-4: "stokes"}),
    _kind("temperature", "K", "K", "", {
        1.0: "K kelvin degK degC celsius delta_degC delta_degK delta_K", 5.0 / 9.0: "degF fahrenheit delta_degF degR rankine",
    }),
    _kind("temperature rate", "K/s", "K s-1"),
    _kind("specific consumption", "kg/J", "m-2 s2", "g/kWh"),
)  # fmt: skip

# Temperatures whose zero is not the absolute one, K: alone they are temperatures, in products and after "delta_" differences.
ZEROS = {"degC": 273.15, "celsius": 273.15, "degF": 459.67 * 5.0 / 9.0, "fahrenheit": 459.67 * 5.0 / 9.0}

# Texts that mean different things to different people, with what to write instead. The first are doubtful wherever they stand,
# the others only alone.
DOUBTFUL = {
    "C": "degC (temperature) or coulomb (charge)",
    "F": "degF (temperature); farad is not a unit of a machine's log",
    "S": "s (time); siemens is not a unit of a machine's log",
    "T": "t (1000 kg); tesla is not a unit of a machine's log",
    "M": "m (length) or min (time)",
    "G": "gn (acceleration, 9.80665 m/s2) or gram (mass)",
    "H": "h (time); henry is not a unit of a machine's log",
    "ton": "t (1000 kg), short_ton (2000 lb) or long_ton (2240 lb)",
    "tons": "t (1000 kg), short_ton (2000 lb) or long_ton (2240 lb)",
    "nm": "N m (torque), mm or um (length)",
    "ps": "PS (metric horsepower), ms or us (time)",
    "grad": "deg (360 to a turn) or gon (400 to a turn)",
    "mil": "thou (0.001 in) or mrad",
    "kn": "kN (force) or km/h (speed)",
    "NS": "ns (time); N s is not a unit of a machine's log",
    "Ns": "ns (time); N s is not a unit of a machine's log",
    "US": "us (time)",
    "Us": "us (time)",
    "fps": "ft/s (speed) or Hz (frames)",
}
DOUBTFUL_ALONE = {
    "g": "gn or g0 (acceleration, 9.80665 m/s2) or gram (mass)",
    "mg": "gn (acceleration, 9.80665 m/s2; divide by 1000 first) or milligram (mass)",
    "mPa": "MPa or Pa (pressure); mPa s is a viscosity",
    "r": "rev or rad (angle)",
    "U": "rev (angle) or V (voltage)",
    "u": "rev (angle) or um (length)",
}
LOGARITHMIC = ("db", "dba", "decibel", "np", "neper")  # no factor leads to what they measure
