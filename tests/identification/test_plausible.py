import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification.plausible import (
    check_plausible,
    check_pressures,
    check_units,
    contradictions,
    position_column,
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
    check_pressures(Table({"boom.p_a": PLAIN["boom.p_a"], "boom.p_b": np.full(100, 12.0)}, {}), ["boom"])


def test_pressures_of_what_the_machine_does_not_have_are_not_looked_at():
    idle = np.abs(np.random.default_rng(0).normal(size=100))
    table = Table({"boom.p_a": PLAIN["boom.p_a"], "boom.p_b": PLAIN["boom.p_b"], "winch.p_a": idle}, {})
    check_pressures(table, ["boom"])
    with pytest.raises(InputError, match="column 'winch.p_a' comes to"):
        check_pressures(table, ["boom", "winch"])


def test_the_column_of_a_joint_goes_by_its_kind(excavator):
    assert [position_column(excavator, f) for f in excavator.functions] == ["swing.angle", "boom.angle", "stick.angle"]


def test_sensors_contradict_each_other_where_much_of_a_flow_is_left():
    assert contradictions("boom", 0.05 * 2.8e-3, 2.8e-3) == []
    assert contradictions("boom", np.nan, 2.8e-3) == []
    (text,) = contradictions("boom", 1.5e-3, 2.8e-3)
    assert text.startswith("flows of boom are 54 % of the pump's off on rows held out")
    assert "sign of boom.spool" in text
