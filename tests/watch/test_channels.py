"""Which residuals which sensors allow."""

from polydraulic import load_machine
from polydraulic.parameters.layout.schema import position_column
from polydraulic.watch.channels import channels_of, pump_columns

ALL = ("voltage", "spool", "p_a", "p_b", "q_in", "q_out", "angle")


def names(machine, whats):
    columns = frozenset(f"{f}.{what}" for f in machine.names for what in whats)
    return [c.name for c in channels_of(machine, columns)]


def test_all_sensors_allow_all_and_few_allow_few():
    loader = load_machine("wheel_loader")
    assert len(names(loader, ALL)) == 6 * 2
    assert names(loader, ("voltage", "spool")) == ["lift.spool", "tilt.spool"]
    assert names(loader, ("p_a", "p_b", "angle")) == ["lift.torque", "tilt.torque"]
    assert names(loader, ("q_in",)) == []
    few = names(loader, ("voltage", "p_a", "p_b", "angle"))
    assert few == [f"{f}.{what}" for f in loader.names for what in ("volume_a", "volume_b", "torque")]


def test_flows_of_circuits_that_a_crossover_joins_take_the_sensors_of_both():
    excavator = load_machine("cat215b_crossover")
    assert len(names(excavator, ALL)) == 6 * 4
    columns = {f"{f}.{what}" for f in excavator.names for what in ("spool", "p_a", "p_b", "q_in")}
    known = {c.name for c in channels_of(excavator, frozenset(columns))}
    assert known == {f"{f}.q_in" for f in excavator.names}
    assert channels_of(excavator, frozenset(columns - {"swing.p_a"})) == ()


def test_a_pumps_pressure_is_watched_where_all_that_it_depends_on_is_read():
    machine = load_machine("cat215b")
    assert pump_columns(machine) == ["boom.p_pump", "series.p_pump"]
    read = [f"{f}.{what}" for f in ("boom", "swing", "stick") for what in ("spool", "p_a", "p_b")]
    seen = channels_of(machine, frozenset([*read, *pump_columns(machine)]))
    assert [(c.name, c.unit) for c in seen] == [("boom.p_pump", "Pa"), ("series.p_pump", "Pa")]
    without = [name for name in read if name != "swing.p_b"]
    assert [c.name for c in channels_of(machine, frozenset([*without, *pump_columns(machine)]))] == ["boom.p_pump"]


def test_a_joint_that_slides_has_a_position_and_a_force():
    crane = load_machine("loader_crane")
    slides = next(f for f in crane.functions if crane.link(f.moves).joint == "prismatic")
    assert position_column(crane, slides) == f"{slides.name}.position"
    columns = frozenset(
        [*(position_column(crane, f) for f in crane.functions), *(f"{f}.p_{s}" for f in crane.names for s in "ab")]
    )
    units = {c.name: c.unit for c in channels_of(crane, columns)}
    assert units[f"{slides.name}.torque"] == "N"
