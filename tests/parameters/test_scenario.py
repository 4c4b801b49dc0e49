import re
from pathlib import Path

import numpy as np
import pytest

from polydraulic import ScheduledFault, load_machine, load_scenario, parameters
from polydraulic.errors import InputError
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.parameters.load import machine_text
from polydraulic.parameters.scenario import scenario_files, scenario_machine, scenario_names
from polydraulic.parameters.signals import Piecewise
from polydraulic.tables import read_table, write_table
from polydraulic.thesis.excavator import LINKS

SHIPPED = Path(parameters.__file__).parent / "scenarios"
BASIC = """
title = "mine"
source = "test"
duration = { value = 2.0, unit = "s", source = "test" }
locked = ["swing", "stick"]
[voltage.boom]
kind = "sine"
amplitude = { value = 0.5, unit = "V", source = "test" }
omega = { value = 2.0, unit = "rad/s", source = "test" }
"""


@pytest.fixture
def written(tmp_path):
    def load(text):
        path = tmp_path / "mine.toml"
        path.write_text(text)
        return load_scenario(path)

    return load


@pytest.mark.parametrize("name", scenario_names("cat215b"))
def test_shipped_scenarios_load(name, machine):
    scenario = load_scenario(name)
    voltages = scenario.voltages(np.linspace(0.0, scenario.duration, 50))
    assert voltages.shape == (50, 3)
    assert np.abs(voltages).max() > 0.2
    assert adapted(machine, scenario).circuits == machine.circuits


@pytest.mark.parametrize("name", scenario_names())
def test_a_scenario_names_its_machine_and_moves_all_of_it(name):
    plant = load_machine(scenario_machine(name))
    scenario = load_scenario(name)
    assert set(scenario.voltage) | set(scenario.locked) <= set(plant.names)
    volts = scenario.voltages(np.linspace(0.0, scenario.duration, 200), plant.names)
    moved = {f for f, v in zip(plant.names, volts.T, strict=True) if np.abs(v).max() > 0.2}
    assert moved == set(plant.names) - set(scenario.locked)


def test_a_scenario_may_name_a_machine_file_beside_it(tmp_path):
    (tmp_path / "crane.toml").write_text(machine_text("loader_crane"))
    path = tmp_path / "lift.toml"
    path.write_text(
        'machine = "crane.toml"\n' + BASIC.replace("boom", "inner").replace("swing", "slew").replace("stick", "tilt")
    )
    assert scenario_machine(path) == str(tmp_path / "crane.toml")
    assert list(load_scenario(path).voltage) == ["inner"]


@pytest.mark.parametrize("source", ["random:3", "random:3:10", "work.csv", "task"])
def test_what_names_no_machine_is_for_cat215b(source):
    assert scenario_machine(source) == "cat215b"


def test_a_scenario_for_another_machine_says_so():
    with pytest.raises(
        InputError, match="is for the machine 'wheel_loader', which is moved by lift, tilt; this one is moved by swing"
    ):
        load_scenario("wheel_loader_cycle", functions=("swing", "boom", "stick"))


@pytest.mark.parametrize(
    ("line", "message"),
    [("machine = 3", "must be the name of a machine"), ('machine = "nobody"', "unknown parameter set")],
)
def test_a_machine_that_is_none(line, message, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(line + "\n" + BASIC)
    with pytest.raises(InputError, match=message):
        load_scenario(path)


def test_changes_reach_the_machine(machine):
    found = adapted(machine, load_scenario("single_08"))
    assert found.function("boom").pilot.gain == pytest.approx(0.43 * 0.0254)
    assert found.function("boom").pilot.time_constant == machine.function("boom").pilot.time_constant
    assert found.function("swing") == machine.function("swing")


def test_kinds_of_signal(written, tmp_path):
    (tmp_path / "stick.csv").write_text("t [s],v [V]\n0,0\n1,0.5\n3,-0.5\n")
    scenario = written(
        BASIC
        + """
[voltage.swing]
kind = "piecewise"
time = { value = [0.0, 500.0], unit = "ms", source = "test" }
voltage = { value = [0.0, 1.0], unit = "V", source = "test" }
[voltage.stick]
kind = "table"
file = "stick.csv"
time_column = "t"
voltage_column = "v"
"""
    )
    t = np.array([0.0, 0.25, 2.0])
    swing, boom, stick = scenario.voltages(t).T
    assert LINKS == ("swing", "boom", "stick")
    assert swing == pytest.approx([0.0, 0.5, 1.0])
    assert boom == pytest.approx(0.5 * np.sin(2.0 * t))
    assert stick == pytest.approx([0.0, 0.125, 0.0])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"sine"', "{}", "voltage.boom.kind = {}: must be one of"),
        ("sine", "square", r"voltage.boom.kind = 'square': must be one of \['constant'"),
        ("amplitude", "amplitud", "unknown key 'amplitud' in voltage.boom"),
        ("voltage.boom", "voltage.bucket", "unknown key 'bucket' in voltage"),
        ('"stick"', '"bucket"', "locked = .*must be a list of"),
        ("value = 2.0, unit = \"s\"", "value = 0.0, unit = \"s\"", "duration = 0.0 s: must be above 0"),
        ('unit = "V"', 'unit = "psi"', "voltage.boom.amplitude has unit 'psi'"),
        ('title = "mine"', "", "missing key 'title'"),
        ('title = "mine"', 'title = "mine"\ncolour = 1', "unknown key 'colour'"),
    ],
)  # fmt: skip
def test_bad_scenarios_are_one_clear_error(written, old, new, message):
    assert old in BASIC
    with pytest.raises(InputError, match=f"mine.toml: {message}"):
        written(BASIC.replace(old, new, 1))


def test_only_pilot_and_start_may_change(written):
    with pytest.raises(InputError, match=r"unknown key 'valve' in change.boom; allowed here: \['initial', 'pilot'\]"):
        written(BASIC + "[change.boom.valve]\n")


def test_times_must_rise():
    with pytest.raises(InputError, match="time 2 is 1.0 after 1.0"):
        Piecewise(np.array([0.0, 1.0, 1.0]), np.zeros(3))


def test_a_recording_with_gaps_is_refused(written, tmp_path):
    (tmp_path / "r.csv").write_text("t,v\n0,0\n1,nan\n")
    table = '[voltage.boom]\nkind = "table"\nfile = "r.csv"\ntime_column = "t"\nvoltage_column = "v"\n'
    with pytest.raises(InputError, match=r"mine.toml: voltage.boom: .*r.csv: column 'v' holds nan in row 2"):
        written(BASIC[: BASIC.index("[voltage.boom]")] + table)


RECORDED = (
    "time [s],swing [V],boom [V],stick [V],engine [rpm]\n2.0,0,0.1,0,1800\n2.5,0,0.2,-0.5,1800\n4.0,0.3,0.2,0,1790\n"
)


def test_a_recording_is_a_scenario_from_its_first_row_on(tmp_path):
    (tmp_path / "morning.csv").write_text(RECORDED)
    scenario = load_scenario(tmp_path / "morning.csv")
    assert (scenario.name, scenario.duration, scenario.locked) == ("morning", 2.0, ())
    assert scenario.voltages(np.array([0.0, 0.25, 2.0])) == pytest.approx(
        np.array([[0.0, 0.1, 0.0], [0.0, 0.15, -0.25], [0.3, 0.2, 0.0]])
    )


def test_a_recording_may_come_without_units_in_others_or_as_parquet(tmp_path):
    (tmp_path / "bare.csv").write_text("time,swing,boom,stick\n0,0,0.1,0\n1,0,0.2,0\n")
    (tmp_path / "small.csv").write_text("time [ms],swing [mV],boom [mV],stick\n0,0,100,0\n1000,0,200,0\n")
    write_table(read_table(tmp_path / "small.csv"), tmp_path / "small.parquet")
    t = np.linspace(0.0, 1.0, 5)
    for name in ("small.csv", "small.parquet"):
        found, bare = load_scenario(tmp_path / name), load_scenario(tmp_path / "bare.csv")
        assert found.voltages(t) == pytest.approx(bare.voltages(t), abs=1e-15)


def test_a_recording_may_be_written_as_any_log(tmp_path):
    (tmp_path / "bare.csv").write_text("time,swing,boom,stick\n0,0,0.1,0\n1,0,0.2,0\n")
    (tmp_path / "german.csv").write_text("sep=;\nZeit [s];swing;boom;stick\n0,0;0;0,1;0\n1,0;0;0,2;0\n", "utf-16")
    (tmp_path / "dated.txt").write_text(
        "# joysticks\ntime\tswing\tboom\tstick\n2024-03-31T01:00:00Z\t0\t0.1\t0\n2024-03-31T01:00:01Z\t0\t0.2\t0\n"
    )
    t = np.linspace(0.0, 1.0, 5)
    for name in ("german.csv", "dated.txt"):
        found, bare = load_scenario(tmp_path / name), load_scenario(tmp_path / "bare.csv")
        assert found.voltages(t) == pytest.approx(bare.voltages(t), abs=1e-6)


def test_a_recording_of_one_link_leaves_the_others_at_rest(tmp_path):
    (tmp_path / "boom.csv").write_text("time,boom\n0,0.1\n1,0.2\n")
    scenario = load_scenario(tmp_path / "boom.csv")
    assert scenario.voltages(np.array([0.5])) == pytest.approx(np.array([[0.0, 0.15, 0.0]]))
    assert scenario.title == "Recording of 1 s; of boom alone"


def test_columns_that_are_no_link_are_named(tmp_path):
    (tmp_path / "r.csv").write_text(RECORDED)
    assert load_scenario(tmp_path / "r.csv").title == "Recording of 2 s; not used: engine"
    (tmp_path / "r.csv").write_text("time,boom,stik\n0,0.1,0\n1,0.2,0\n")
    with pytest.raises(
        InputError, match=r"no column 'swing'; .* moved by swing, boom, stick; name columns .*leave out stik"
    ):
        load_scenario(tmp_path / "r.csv")


def test_columns_named_by_links_are_told_what_moves_them(tmp_path):
    """The links of a crane go by other names than its functions."""
    (tmp_path / "r.csv").write_text("time,column,arm\n0,0.1,0\n1,0.2,0\n")
    with pytest.raises(InputError, match="the machine is moved by slew, lift, extend; name columns by these") as error:
        load_scenario(tmp_path / "r.csv", functions=("slew", "lift", "extend"))
    assert "leave out" not in str(error.value)


@pytest.mark.parametrize("name", ["cat215b", "loader_crane"])
def test_a_machine_is_no_scenario(tmp_path, name):
    (tmp_path / "m.toml").write_text(machine_text(name))
    with pytest.raises(
        InputError, match=r"m.toml: is a machine, not a scenario; try it by `polydraulic machine check .*m.toml`"
    ):
        load_scenario(tmp_path / "m.toml")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2.5,0,", "2.5,on,", "r.csv: column 'swing' has no number in row 2"),
        ("2.5,0,0.2,-0.5,1800", "2.5,0", "r.csv: missing line: row 2"),
        ("2.5,", "1.5,", "r.csv: signal times must rise; time 1 is 1.5 after 2.0"),
        ("2.5,", "2.0,", "r.csv: signal times must rise; time 1 is 2.0 after 2.0"),
        ("boom [V]", "boom [bar]", r"r.csv: column 'boom' has unit 'bar'; it must be one of \['V', 'mV'\]"),
        ("time [s]", "time [bar]", r"r.csv: column 'time' has unit 'bar'; it must be one of \['s', 'ms'\]"),
        ("stick [V]", "arm [V]", "r.csv: no column 'stick'; the table has"),
        ("time [s]", "t [s]", "r.csv: no column 'time'"),
        ("-0.5", "", "r.csv: column 'stick' holds nan in row 2"),
        ("2.5,0,0.2,-0.5,1800\n4.0,0.3,0.2,0,1790\n", "", "r.csv: a recording needs at least two rows"),
        ("2.0,0,0.1,0,1800\n2.5,0,0.2,-0.5,1800\n4.0,0.3,0.2,0,1790\n", "", "r.csv: the log has no rows"),
    ],
)
def test_bad_recordings_are_one_clear_error(tmp_path, old, new, message):
    assert old in RECORDED
    (tmp_path / "r.csv").write_text(RECORDED.replace(old, new))
    with pytest.raises(InputError, match=message):
        load_scenario(tmp_path / "r.csv")


def test_a_recording_in_a_scenario_file_is_converted_too(written, tmp_path):
    (tmp_path / "r.csv").write_text("t [ms],v [bar]\n0,0\n1,1\n")
    table = '[voltage.boom]\nkind = "table"\nfile = "r.csv"\ntime_column = "t"\nvoltage_column = "v"\n'
    with pytest.raises(InputError, match=r"mine.toml: voltage.boom: .*r.csv: column 'v' has unit 'bar'"):
        written(BASIC[: BASIC.index("[voltage.boom]")] + table)
    (tmp_path / "r.csv").write_text("t [ms],v [mV]\n0,0\n1000,500\n")
    scenario = written(BASIC[: BASIC.index("[voltage.boom]")] + table)
    assert scenario.voltages(np.array([0.5]))[0, 1] == pytest.approx(0.25)


def test_the_files_that_a_scenario_is_read_from(tmp_path):
    table = '[voltage.stick]\nkind = "table"\nfile = "r.csv"\ntime_column = "t"\nvoltage_column = "v"\n'
    (tmp_path / "mine.toml").write_text(BASIC + table)
    assert scenario_files(tmp_path / "mine.toml") == [tmp_path / "mine.toml", tmp_path / "r.csv"]
    assert scenario_files(tmp_path / "r.csv") == [tmp_path / "r.csv"]
    assert scenario_files("single_08") == [SHIPPED / "single_08.toml"]
    assert scenario_files("random:1:2") == []


def test_other_names_say_what_may_be_given():
    with pytest.raises(InputError, match=r"unknown scenario 'x'; .*\.csv or \.parquet recording, or random:SEED"):
        load_scenario("x")


@pytest.mark.parametrize("value", ["9" * 400, "1e308", "-1e308", "[[]]", "{}", "nan", "1979-05-27"])
@pytest.mark.parametrize("scenario", ["sine", "pulse", "task"])
def test_strange_values_anywhere_in_a_scenario_are_one_error(scenario, value, tmp_path):
    lines = (SHIPPED / f"{scenario}.toml").read_text().splitlines()
    places = [k for k, line in enumerate(lines) if re.match(r"[\w.]+ = ", line)]
    assert len(places) > 5
    for k in places:
        path = tmp_path / "mine.toml"
        path.write_text("\n".join([*lines[:k], f"{lines[k].split(' = ')[0]} = {value}", *lines[k + 1 :]]))
        with pytest.raises(InputError, match="mine.toml"):
            load_scenario(path)


FAULT = """
[[faults]]
name = "boom.pump_worn"
size = { value = 10, unit = "%", source = "test" }
begin = { value = 1, unit = "min", source = "test" }
growth = { value = 5, unit = "min", source = "test" }

[[faults]]
name = "tip.payload_unknown"
size = { value = 0.3, unit = "t", source = "test" }
end = { value = 9, unit = "s", source = "test" }

[[faults]]
name = "boom.angle.freeze"
"""


def test_a_file_says_what_breaks_and_when(written):
    assert written(BASIC).faults == ()
    assert written(BASIC + FAULT).faults == (
        ScheduledFault("boom.pump_worn", 0.1, begin=60.0, growth=300.0),
        ScheduledFault("tip.payload_unknown", 300.0, end=9.0),
        ScheduledFault("boom.angle.freeze"),
    )


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("[[faults]]", "[faults]", "[Cc]annot|must be a list of tables"),
        ('name = "boom.angle.freeze"', "name = 3", r"faults 3.name = 3: must be a string"),
        ('name = "boom.angle.freeze"', "", r"faults 3.*name"),
        ("growth", "growing", "unknown key 'growing' in faults 1"),
        ('10, unit = "%"', '10, unit = "bar"', r"faults 1.size has unit 'bar'"),
        ('0.3, unit = "t"', '30, unit = "%"', r"faults 2.size has unit '%'"),
        ("value = 9", "value = 0", r"faults 2: fault 'tip.payload_unknown': end = 0"),
    ],
)
def test_what_is_no_fault_is_refused_with_its_place(written, before, after, says):
    with pytest.raises(InputError, match=says):
        written(BASIC + FAULT.replace(before, after))
