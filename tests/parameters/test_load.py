from math import pi
from pathlib import Path

import pytest

from polydraulic import load_machine
from polydraulic.errors import InputError, briefly
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.load import machine_entries, machine_text
from polydraulic.thesis.excavator import pump_of, spool_of

OLDER = Path(__file__).parent / "layout" / "data" / "cat215b_older.toml"
TEXT = OLDER.read_text()  # a file of the older form


@pytest.fixture
def changed(tmp_path):
    """Load the set with a piece of its text replaced."""

    def load(old, new):
        assert TEXT.count(old) >= 1
        path = tmp_path / "mine.toml"
        path.write_text(TEXT.replace(old, new, 1))
        return load_machine(path)

    return load


def test_values_are_si(machine):
    assert pump_of(machine, "boom").flow == pytest.approx(171.5 * 0.0254**3)
    assert spool_of(machine).deadband == pytest.approx(0.188 * 0.0254)
    assert machine.function("stick").stops.high == pytest.approx(-28.0 * pi / 180.0)
    assert machine.function("swing").drive.displacement == pytest.approx(8.0 * 0.0254**3 / (2 * pi))
    assert machine.function("boom").valve.outlet_positive[-1] * (3950 * 6894.757) ** 0.5 == pytest.approx(
        5581 * 0.0254**3, rel=1e-4
    )


def test_every_number_has_unit_and_source():
    entries = machine_entries("cat215b")
    assert len(entries) == sum(1 for line in machine_text("cat215b").splitlines() if " = { value = " in line)
    assert all(entry.source and (entry.unit or isinstance(entry.value, bool)) for entry in entries)


def test_a_path_is_a_set_too(changed):
    machine = changed("value = 4500.0", "value = 4600.0")
    assert (
        pump_of(machine, "series").relief == pump_of(machine, "boom").relief == pytest.approx(4600 * 6894.757293168361)
    )


GAIN = 'gain = { value = 0.80, unit = "in/V", source = "derived, 5.3.2'


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[boom.pilot]\ngain", "[boom.pilot]\ngian", r"mine.toml: unknown key 'gian' in boom.pilot; allowed here: \['dead_time'"),
        ("[tank]", "[tnak]", "unknown key 'tnak'"),
        ("[geometry]\na1 = { value = 0.81, unit = \"m\", source = \"thesis 5.3.1\" }", "[geometry]", "missing key 'a1' in geometry"),
        ('value = 4500.0, unit = "psi"', 'value = 4500.0, unit = "in"', "pumps.relief has unit 'in'; allowed: .*'psi'"),
        ("value = 4500.0", "value = -1.0", "pumps.relief = -1.0 psi: must be above 0 psi"),
        ("value = 4500.0", "value = nan", "pumps.relief = nan psi: must be finite"),
        ("value = 4500.0", "value = inf", "pumps.relief = inf psi: must be finite"),
        ("value = 4500.0", 'value = "high"', "pumps.relief = 'high': must be a number"),
        ("value = 4500.0", "value = true", "pumps.relief = True: must be a number"),
        ("value = 4500.0", "value = 40.0", "pumps.relief = .*must be above tank.return_pressure"),
        ("value = false", "value = 0", "torque_limit_enabled = 0: must be true or false"),
        ("0.0, 0.188, 0.282, 0.365, 0.376, 0.564", "0.0, 0.188, 0.282, 0.365, 0.376", "swing.valve.inlet: 6 numbers for 5 knots; must be as many"),
        ("0.0, 0.188, 0.282, 0.365, 0.376, 0.564", "0.0, 0.188, 0.188, 0.365, 0.376, 0.564", "spool.knots .*rising"),
        ("deadband = { value = 0.188", "deadband = { value = 0.187", "spool.deadband .*one of the knots"),
        ("0.0, 0.0, 2.299", "0.0, 0.1, 2.299", "boom.valve.inlet .*0 up to spool.deadband"),
        ("16.0, 3.914, 1.957, 0.229, 0.0, 0.0", "16.0, 3.914, 1.957, 0.229, 0.1, 0.0", "boom.valve.bypass .*0 from"),
        ('static = { value = 4500.0', 'static = { value = 2500.0', "boom.friction.static .*at least coulomb"),
        ("rod = { value = 3.25", "rod = { value = 5.25", "boom.cylinder.rod.*below the bore"),
        ("angle_offset = { value = 62.0", "angle_offset = { value = 20.0", "boom: the linkage turns over between the stops"),
        ("angle = { value = 30.0", "angle = { value = 90.0", "boom.initial.angle .*within the stops"),
        ("p_a = { value = 900.0", "p_a = { value = 9000.0", "boom.initial.p_a .*must be in"),
        (', source = "thesis 4.1" }', " }", "missing key .source. in spool.deadband"),
        ('"thesis 4.1"', '" "', "spool.deadband.source = ' ': must be a string"),
        ("relief = { value = 4500.0", "relief = [ value = 4500.0", "not a TOML file"),
        ('deadband = { value = 0.188, unit = "in", source = "thesis 4.1" }', "deadband = 0.188",
         r'deadband = 0.188: must be a table such as { value = 0.188, unit = "m", source = "..." }'),
        ('deadband = { value = 0.188, unit = "in", source = "thesis 4.1" }', 'deadband = "4.8 mm"',
         r"deadband = '4.8 mm': must be a table such as { value = ..., unit"),
    ],
)  # fmt: skip
def test_bad_sets_are_one_clear_error(changed, old, new, message):
    with pytest.raises(InputError, match=message):
        changed(old, new)


# entry of the file -> the same in other units of the field, and where it is in the machine
SAME = {
    'relief = { value = 4500.0, unit = "psi", source = "estimate: above the 4000': (
        4500.0 * 6894.757293168361, lambda m: pump_of(m, "boom").relief,
        {"bar": 1e5, "bar(g)": 1e5, "MPa": 1e6, "kgf/cm2": 98066.5, "kg/cm²": 98066.5, "N/mm2": 1e6, "psig": 6894.757293168361},
    ),
    'boom_flow = { value = 171.5, unit = "in3/s"': (
        171.5 * 0.0254**3, lambda m: pump_of(m, "boom").flow,
        {"L/min": 1e-3 / 60, "gpm": 3.785411784e-3 / 60, "UK gpm": 4.54609e-3 / 60, "m3/h": 1 / 3600, "cc/s": 1e-6, "lpm": 1e-3 / 60},
    ),
    'displacement = { value = 8.0, unit = "in3/rev"': (
        8.0 * 0.0254**3 / (2 * pi), lambda m: m.function("swing").drive.displacement, {"cc/rev": 1e-6 / (2 * pi), "cm³/U": 1e-6 / (2 * pi), "l/rad": 1e-3},
    ),
    'mass = { value = 1500.0, unit = "kg"': (1500.0, lambda m: m.link("boom").mass, {"t": 1e3, "lb": 0.45359237, "short_ton": 907.18474}),
    'a1 = { value = 0.81, unit = "m"': (0.81, lambda m: m.link("boom").at["x"], {"cm": 0.01, "ft": 0.3048, "MM": 1e-3}),
    'static = { value = 4500.0, unit = "N m"': (
        4500.0, lambda m: m.function("boom").friction.static, {"kNm": 1e3, "kN·m": 1e3, "lbf.ft": 1.3558179483314004, "ft-lb": 1.3558179483314004},
    ),
}  # fmt: skip


@pytest.mark.parametrize(("entry", "unit"), [(entry, unit) for entry, (_, _, same) in SAME.items() for unit in same])
def test_units_of_the_field_are_read(changed, entry, unit):
    si, place, same = SAME[entry]
    key = entry.partition(" = ")[0]
    machine = changed(entry.partition(", source")[0], f'{key} = {{ value = {si / same[unit]!r}, unit = "{unit}"')
    assert place(machine) == pytest.approx(si, rel=1e-13)


@pytest.mark.parametrize(
    ("unit", "message"),
    [
        ("C", "pumps.relief: unit 'C' can be read in several ways; write degC"),
        ("barr", "pumps.relief: unknown unit 'barr'; nearest known units: 'bar'"),
        (
            "l/min",
            r"pumps.relief has unit 'l/min'; allowed: \['Pa', 'kPa', 'MPa', 'bar', 'psi', .*\], or another unit of pressure",
        ),
    ],
)
def test_units_that_are_refused_are_named(changed, unit, message):
    with pytest.raises(InputError, match=message):
        changed('relief = { value = 4500.0, unit = "psi"', f'relief = {{ value = 4500.0, unit = "{unit}"')


def test_an_absolute_pressure_loses_the_standard_atmosphere(changed):
    machine = changed('relief = { value = 4500.0, unit = "psi"', 'relief = { value = 301.01325, unit = "bar(a)"')
    assert pump_of(machine, "boom").relief == pytest.approx(300e5, rel=1e-14)


def test_limits_are_in_the_unit_of_the_file(changed):
    with pytest.raises(InputError, match=r"pumps.relief = -2.0 bar: must be above 0 bar$"):
        changed('value = 4500.0, unit = "psi"', 'value = -2.0, unit = "bar"')


def test_files_as_editors_of_windows_save_them(tmp_path):
    text, file = machine_text("cat215b_bucket"), tmp_path / "mine.toml"
    file.write_bytes(text.replace("\n", "\r\n").encode("utf-8-sig"))
    assert load_machine(file) == load_machine("cat215b_bucket")
    assert not machine_text(file).startswith("\ufeff")
    for encoding in ("utf-16", "latin-1"):
        file.write_bytes(("# Öl\n" + text).encode(encoding, "replace"))
        with pytest.raises(InputError, match=r"mine\.toml: not a text in UTF-8, .*: save it with that encoding"):
            load_machine(file)


def test_unknown_names_list_the_choices(tmp_path):
    with pytest.raises(InputError, match=r"unknown parameter set 'cat320'; choose one of \['cat215b', "):
        load_machine("cat320")
    with pytest.raises(InputError, match="no such file"):
        load_machine(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("9" * 400, "a whole number has 64 bits"),
        ("-" + "9" * 400, "a whole number has 64 bits"),
        ("9" * 5000, "not a TOML file"),
        ("1e308", "must be finite|size from 1e-30 to 1e\\+20"),
        ("-1e308", "must be finite|size from 1e-30 to 1e\\+20"),
        ("1e-308", "size from 1e-30 to 1e\\+20"),
        ("1e999", "must be finite"),
        ("[[[]]]", r"= \[\[\[\]\]\]: must be a number"),
    ],
)
@pytest.mark.parametrize("place", ["value = 4500.0", "value = 171.5", "value = 18000.0"])
def test_numbers_that_nobody_measures_are_one_error(place, value, message, changed):
    with pytest.raises(InputError, match=message) as error:
        changed(place, f"value = {value}")
    assert len(str(error.value)) < 500


DEEP = 50_000


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * DEEP + "]" * DEEP,
        "x = " + "[" * DEEP,
        "x = " + "{a=" * DEEP + "1" + "}" * DEEP,
        "x = " + "[" * 30 + "]" * 30,
        ".".join("a" * DEEP) + " = 1",
        " . ".join(["'a b'"] * DEEP) + " = 1",
        "[" + ".".join("a" * DEEP) + "]",
        ".".join("a" * 60) + " = 1",
    ],
    ids=["lists", "open lists", "tables", "thirty", "keys", "quoted keys", "heads", "sixty"],
)
def test_files_that_are_nested_deep_are_one_error_at_once(text, tmp_path):
    (tmp_path / "deep.toml").write_text(text)
    with pytest.raises(InputError, match="deep.toml: .*nested too deep") as error:
        read_toml(tmp_path / "deep.toml")
    assert len(str(error.value)) < 500


def test_long_texts_and_comments_are_no_depth(tmp_path):
    text = f"# {'.' * 500}\nx = '{'see a. b. ' * 200}'\ny = [{', '.join(['0.5'] * 500)}]\n'a.b'.c = 1\n"
    (tmp_path / "long.toml").write_text(text)
    assert read_toml(tmp_path / "long.toml")["y"] == [0.5] * 500


def test_values_in_messages_are_cut():
    assert briefly([1, 2]) == "[1, 2]"
    assert briefly("x" * 100) == "'" + "x" * 59 + "..."
    assert briefly(10**5000) == "int of more digits or levels than can be shown"


def test_a_folder_in_the_place_of_a_file_is_one_error(tmp_path):
    with pytest.raises(InputError, match="cannot be read .Is a directory"):
        read_toml(tmp_path)


@pytest.mark.parametrize("text", ["", 'title = "nothing else"\n'])
def test_a_file_without_any_table_of_a_machine_says_how_to_begin_one(tmp_path, text):
    (tmp_path / "empty.toml").write_text(text)
    with pytest.raises(
        InputError, match=r"empty\.toml: is no machine, for it has no \[links\].*polydraulic machine new"
    ):
        load_machine(tmp_path / "empty.toml")


@pytest.mark.parametrize("line", ["gain = { value = 12,5, unit = 'mm/V' }", "gain = 12,5"])
def test_a_decimal_comma_is_named(tmp_path, line):
    (tmp_path / "m.toml").write_text(f"title = 'a'\n{line}\n")
    with pytest.raises(InputError, match=r"not a TOML file .*; decimals have a point: 12\.5, not 12,5$"):
        read_toml(tmp_path / "m.toml")
