"""Names and units that headers of text files hold."""

import pytest

from polydraulic.columns.header import example, names_and_units
from polydraulic.measure import open_log

READ = {
    "p [bar]": ("p", "bar"), "p[bar]": ("p", "bar"), "p (bar)": ("p", "bar"), "p(bar)": ("p", "bar"), "p/bar": ("p", "bar"),
    "p / bar": ("p", "bar"), "p_A/bar": ("p_A", "bar"), "Druck in bar": ("Druck", "bar"), "n in rpm": ("n", "rpm"), "p, bar": ("p", "bar"),
    "p,bar": ("p", "bar"), "Q/(l/min)": ("Q", "l/min"), "Q/l/min": ("Q", "l/min"), "v/(m/s)": ("v", "m/s"), "x/mm": ("x", "mm"),
    "T/°C": ("T", "°C"), "T in degC": ("T", "degC"), "M/(N m)": ("M", "N m"), "M/Nm": ("M", "Nm"), "I/A": ("I", "A"), "i_1/mA": ("i_1", "mA"),
    "t/s": ("t", "s"), "t in ms": ("t", "ms"), "Zeit/s": ("Zeit", "s"), "time, s": ("time", "s"), "p/bar(a)": ("p", "bar(a)"),
    "P (Bar)": ("P", "Bar"), "x (MM)": ("x", "MM"), "n (RPM)": ("n", "RPM"), "boom (Deg)": ("boom", "Deg"), "Q (L/Min)": ("Q", "L/Min"),
    "m/kg": ("m", "kg"), "Boom stroke in mm": ("Boom stroke", "mm"), "p/kg/cm2": ("p", "kg/cm2"), "U/V": ("U", "V"),
}  # fmt: skip
NAMES = [
    "p_bar", "p bar", "km/h", "m/s", "l/min", "rev/min", "U/min", "N/mm2", "bar/s", "pulses/s", "count/min", "strokes in h", "fuel, h", "valve/A",
    "flow in A", "port, A", "p/A", "p/V", "pressure in mA", "on/off", "A/C", "a/g", "T/C", "in/out", "/bar", "bar/", "x in tank", "time/mm", "a, b", "p/1",
    "P (IN)", "Flow (In)", "T (Min)", "Speed (MIN)", "Pressure (HP)", "Pump (HP)", "Gear (Rev)", "P (A)",
    "Cylinder (Rod)", "Mode (Auto)", "load (LS)", "rate/1", "time/frame", "s/n", "/", "in bar", ", bar",
]  # fmt: skip


@pytest.mark.parametrize("head", READ)
def test_names_with_units(head):
    assert names_and_units([head], 1) == ([READ[head][0]], [READ[head][1]])


@pytest.mark.parametrize("head", NAMES)
def test_what_could_be_something_else_is_a_name(head):
    assert names_and_units([head], 1) == ([head], [""])


def test_units_that_tell_columns_apart_stay_in_their_names():
    assert names_and_units(["p/bar", "p/psi", "x/mm"], 3) == (["p/bar", "p/psi", "x"], ["", "", "mm"])


def test_a_log_goes_by_names_and_whole_heads(tmp_path):
    (tmp_path / "a.csv").write_text(
        't/s;p/bar;n in rpm;"Q, l/min"\n' + "".join(f"0,{k};1,5;900;2\n" for k in range(10, 20))
    )
    with open_log(tmp_path / "a.csv") as log:
        assert [(s.name, s.unit) for s in log.signals] == [("t", "s"), ("p", "bar"), ("n", "rpm"), ("Q", "l/min")]
        assert log.signal("p/bar").name == "p"


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("105 bar", "such as '105 bar': numbers with their unit; leave 'bar' out of the cells"),
        ("-1,5mm", "such as '-1,5mm': numbers with their unit; leave 'mm' out of the cells"),
        ("0x69", "such as '0x69': hexadecimal numbers, or some with a unit; write plain decimal ones"),
        ("0A", "such as '0A': hexadecimal numbers, or some with a unit; write plain decimal ones"),
        ("BAD", "such as 'BAD'"),
        ("OVERLOAD", "such as 'OVERLOAD'"),
    ],
)
def test_a_cell_that_is_no_number_is_shown_and_its_unit_named(cell, said):
    assert example(cell) == said
