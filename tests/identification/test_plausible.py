import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification.plausible import (
    check_functions,
    check_plausible,
    check_pressures,
    check_units,
    contradictions,
)
from polydraulic.tables import Table

WAVE = np.sin(np.arange(100) / 9.0)
PLAIN = {"boom.voltage": WAVE, "boom.spool": 0.01 * WAVE, "boom.p_a": 1e7 + 1e6 * WAVE, "boom.p_b": 3e6 + 1e6 * WAVE}
PLAIN |= {
    "boom.q_in": 1e-3 * WAVE,
    "boom.q_out": 1e-3 * WAVE,
    "boom.angle": 0.3 * WAVE,
    "series.p_pump": 1.2e7 + 1e6 * WAVE,
}


@pytest.fixture(scope="module")
def excavator():
    return load_machine("cat215b")


def test_a_log_in_si_is_taken_whatever_it_lacks(excavator):
    check_units(Table(PLAIN, {"boom.p_a": "Pa"}))
    for missing in PLAIN:
        check_plausible(excavator, Table({name: values for name, values in PLAIN.items() if name != missing}, {}))


def test_a_log_of_another_machine_is_told_which_functions_this_one_has(excavator):
    check_functions(excavator, Table({"time": WAVE, "boom.angle": WAVE}, {}))
    with pytest.raises(
        InputError,
        match=r"no column of swing, boom, stick, the functions of 'Cat.*: choose the machine .*\(--machine\), or .* swing.voltage",
    ):
        check_functions(excavator, Table({"time": WAVE, "lift.angle": WAVE, "booms.angle": WAVE}, {}))


def test_times_in_milliseconds_are_named(excavator):
    check_plausible(excavator, Table(PLAIN | {"time": 1.0 * np.arange(100)}, {}))
    with pytest.raises(InputError, match="rows come every 20 s, .* column 'time' must be in s"):
        check_plausible(excavator, Table(PLAIN | {"time": 20.0 * np.arange(100)}, {}))


@pytest.mark.parametrize(
    ("name", "factor", "unit"),
    [
        ("boom.spool", 1e3, "m"), ("boom.q_in", 6e4, "m3/s"), ("boom.q_out", 6e4, "m3/s"), ("boom.angle", 180.0 / np.pi, "rad"),
        ("boom.voltage", 100.0, "V"), ("boom.p_a", 1e-5, "Pa"), ("boom.p_b", 1e-6, "Pa"),
        ("series.p_pump", 1e-5, "Pa"),
    ],
)  # fmt: skip
def test_one_column_in_another_unit_is_named(excavator, name, factor, unit):
    with pytest.raises(InputError, match=f"column '{name}' .* must be in {unit}"):
        check_plausible(excavator, Table(PLAIN | {name: factor * PLAIN[name]}, {}))


def test_pressures_that_are_all_in_bar_are_named_and_a_dead_sensor_is_none():
    with pytest.raises(InputError, match="the largest pressure at a port of the log is 110 Pa"):
        check_pressures(Table({name: 1e-5 * PLAIN[name] for name in ("boom.p_a", "boom.p_b")}, {}), ["boom"])
    with pytest.raises(InputError, match=r"column 'boom.p_b' lies between .* no more than 2000 bar can be"):
        check_pressures(Table({"boom.p_a": PLAIN["boom.p_a"], "boom.p_b": 1e5 * PLAIN["boom.p_b"]}, {}), ["boom"])
    check_pressures(Table({"boom.p_a": PLAIN["boom.p_a"], "boom.p_b": np.full(100, 12.0)}, {}), ["boom"])


def test_pressures_of_what_the_machine_does_not_have_are_not_looked_at():
    idle = np.abs(np.random.default_rng(0).normal(size=100))
    table = Table({"boom.p_a": PLAIN["boom.p_a"], "boom.p_b": PLAIN["boom.p_b"], "winch.p_a": idle}, {})
    check_pressures(table, ["boom"])
    with pytest.raises(InputError, match="column 'winch.p_a' comes to"):
        check_pressures(table, ["boom", "winch"])


def test_a_sensor_that_hangs_below_zero_is_no_pressure_in_another_unit(excavator):
    check_pressures(Table({"boom.p_a": of_hundred(1e5, 1), "boom.p_b": of_hundred(0.0, 50, -5.0)}, {}), ["boom"])


def test_positions_of_a_joint_that_slides_lie_between_its_stops_in_metres(tmp_path):
    crane = load_machine(write_crane(tmp_path))
    low, high = crane.function("extend").stops
    check_plausible(crane, Table({"extend.position": of_hundred(high + 0.099, 100)}, {}))
    with pytest.raises(
        InputError, match=rf"its joint's stops at {low:.4g} and {high:.4g} m: it must be in m, with the"
    ):
        check_plausible(crane, Table({"extend.position": of_hundred(high + 0.101, 100)}, {}))


@pytest.mark.parametrize(
    ("name", "unit", "si"),
    [
        ("boom.spool", "mm", "m"), ("boom.p_a", "bar", "Pa"), ("boom.p_b", "bar", "Pa"), ("boom.q_in", "l/min", "m3/s"),
        ("boom.q_out", "l/min", "m3/s"), ("boom.voltage", "mV", "V"), ("boom.angle", "deg", "rad"), ("arm.position", "mm", "m"),
        ("main.p_pump", "bar", "Pa"),
    ],
)  # fmt: skip
def test_columns_that_say_another_unit_are_refused(name, unit, si):
    values = {"time": WAVE, name: WAVE}
    for fine in ({name: si}, {name: ""}, {}, {name: si, "time": "h"}):
        check_units(Table(values, fine))
    with pytest.raises(
        InputError, match=f"column '{name}' is in '{unit}'; a machine is identified in SI, this in '{si}'"
    ):
        check_units(Table(values, {name: unit}))


def test_sensors_contradict_each_other_where_much_of_a_flow_is_left():
    assert contradictions("boom", 0.05 * 2.8e-3, 2.8e-3) == []
    assert contradictions("boom", np.nan, 2.8e-3) == []
    (text,) = contradictions("boom", 2.8e-3, 2.8e-3)
    assert text.startswith("flows of boom are 100 % of the pump's off on rows held out")
    assert "sign of boom.spool" in text


def of_hundred(value, n, rest=0.0):
    """Rows of which so many have another value than the rest."""
    return np.where(np.arange(100) < n, value, rest)


@pytest.mark.parametrize(
    ("what", "unit", "most"), [("spool", "m", 0.07163), ("q_in", "m3/s", 0.281), ("q_out", "m3/s", 0.281)]
)
def test_spools_and_flows_go_as_far_as_five_travels_and_a_hundred_pumps(excavator, what, unit, most):
    boom = excavator.function("boom")
    limit = 5.0 * boom.valve.knots[-1] if what == "spool" else 100.0 * max(c.pump.flow for c in excavator.circuits)
    assert limit == pytest.approx(most, rel=1e-3)
    for factor, n in ((0.999, 100), (-0.999, 100), (1.001, 5)):  # a twentieth of the rows may be outliers
        check_plausible(excavator, Table({f"boom.{what}": of_hundred(factor * limit, n)}, {}))
    for factor in (1.001, -1.001):
        with pytest.raises(InputError, match=f"no more than {most:.4g} {unit} can be: it must be in {unit};"):
            check_plausible(excavator, Table({f"boom.{what}": of_hundred(factor * limit, 6)}, {}))


def test_levers_go_as_far_as_ten_times_full_travel(excavator):
    boom = excavator.function("boom")
    full = boom.valve.knots[-1] / boom.pilot.gain
    for factor, n in ((9.99, 100), (-9.99, 100), (10.01, 5)):
        check_plausible(excavator, Table({"boom.voltage": of_hundred(factor * full, n)}, {}))
    for factor in (10.01, -10.01):
        with pytest.raises(InputError, match=r"'boom.voltage' .* by the file's pilot 0.705 V gives full travel: it"):
            check_plausible(excavator, Table({"boom.voltage": of_hundred(factor * full, 6)}, {}))


def test_half_of_the_rows_may_be_a_tenth_of_a_radian_beyond_the_stops(excavator):
    low, high = excavator.function("boom").stops
    for angle, n in ((high + 0.099, 100), (low - 0.099, 100), (high + 0.101, 50)):
        check_plausible(excavator, Table({"boom.angle": of_hundred(angle, n)}, {}))
    for angle in (high + 0.101, low - 0.101):
        with pytest.raises(InputError, match=r"its joint's stops at -0.6981 and 1.047 rad: it must be in rad, with"):
            check_plausible(excavator, Table({"boom.angle": of_hundred(angle, 51)}, {}))


@pytest.mark.parametrize(
    ("columns", "named"),
    [
        ({"boom.p_a": 1e5, "boom.p_b": 9e4}, None),
        ({"boom.p_a": 9.99e4, "boom.p_b": 9e4}, "the largest pressure at a port of the log is 9.99e\\+04 Pa"),
        ({"boom.p_a": 1e5, "boom.p_b": 1e4}, None),
        ({"boom.p_a": 1e5, "boom.p_b": 9.99e3}, "column 'boom.p_b' comes to 9990 Pa at most, others to 1 bar"),
        ({"boom.p_a": 0.0, "boom.p_b": 0.0}, None),  # dead sensors
        ({"boom.p_a": 0.9, "boom.p_b": 0.0}, "the largest pressure at a port of the log is 0.9 Pa"),
        ({"boom.p_a": 1e5, "boom.p_b": 0.9}, "column 'boom.p_b' comes to 0.9 Pa at most, others to 1 bar"),
        ({"boom.p_pump": 0.9}, "'boom.p_pump' lies between 0 and 0.9, and a pump"),
        ({"boom.p_pump": 1e5}, None),
        ({"boom.p_pump": 9.99e4}, "'boom.p_pump' .* a pump that feeds valves has more than 1 bar: it must be in Pa"),
        ({"boom.p_pump": 0.0}, None),
    ],
)
def test_pressures_come_to_one_bar_and_each_to_a_tenth_of_it(excavator, columns, named):
    table = Table({name: of_hundred(most, 1) for name, most in columns.items()}, {})
    if named is None:
        check_plausible(excavator, table)
    else:
        with pytest.raises(InputError, match=named):
            check_plausible(excavator, table)


@pytest.mark.parametrize(("left", "named"), [(0.2, False), (0.201, True)])
def test_a_fifth_of_the_pumps_flow_is_the_most_that_is_left_of_a_flow(left, named):
    assert bool(contradictions("boom", left * 2.0, 2.0)) == named


def test_an_angle_that_begins_anew_after_a_turn_is_named_with_its_place(excavator):
    time, swing = 0.02 * np.arange(100), np.linspace(5.0, 8.0, 100)
    table = Table({"time": time, "swing.angle": swing}, {})
    check_plausible(excavator, table)
    anew = np.where(swing > 2.0 * np.pi, swing - 2.0 * np.pi, swing)
    words = (
        r"'swing.angle' goes from 6.273 to 0.01984 rad at 0.86 s, .* in 1 row.s.: an angle must go on past a full turn"
    )
    with pytest.raises(InputError, match=words):
        check_plausible(excavator, Table(table.columns | {"swing.angle": anew}, {}))
    later = np.where(swing > 2.0 * np.pi, time + 5.0, time)  # nobody knows what a gap hides
    check_plausible(excavator, Table({"time": later, "swing.angle": anew}, {}))
    silent = np.where(np.abs(swing - 2.0 * np.pi) < 0.1, np.nan, anew)
    check_plausible(excavator, Table({"time": time, "swing.angle": silent}, {}).partial())
    check_plausible(excavator, Table({"swing.angle": anew}, {}))
