from polydraulic import load_machine
from polydraulic.simulation.layout.columns import columns_of, fed_functions, gap_name


def test_columns_are_named_by_functions_and_circuits_with_the_joints_units(crane):
    found = columns_of(crane)
    units = dict(found.columns)
    assert found.n_state == 15
    assert len(found.columns) == len(units) == 5 * 3 + 2 * 3 + 2 * 4 + 1
    assert units["slew.angle"] == "rad"
    assert units["extend.position"] == "m"
    assert units["extend.speed"] == "m/s"
    assert "extend.angle" not in units
    assert found.columns[found.place["extend.angle"]].name == "extend.position"
    assert units["main.p_between"] == "Pa"


def test_the_columns_of_cat215b_are_said_here_once_more():
    of_functions = ("spool", "p_a", "p_b", "angle", "rate", "q_in", "q_out")
    expected = [f"{f}.{quantity}" for quantity in of_functions for f in ("swing", "boom", "stick")]
    expected += [
        f"{c}.{quantity}" for c in ("boom", "series") for quantity in ("q_pump", "q_bypass", "q_relief", "p_pump")
    ]
    assert [column.name for column in columns_of(load_machine("cat215b")).columns] == [*expected, "series.p_between"]


def test_pressures_between_more_than_two_valves_are_numbered():
    assert gap_name("upper", 1, 2) == "upper.p_between"
    assert [gap_name("upper", k, 4) for k in (1, 2, 3)] == [
        "upper.p_between_1",
        "upper.p_between_2",
        "upper.p_between_3",
    ]


def test_both_pumps_of_a_crossover_have_columns_and_so_has_what_passes_it(joined_crane):
    units = dict(columns_of(joined_crane).columns)
    for circuit in ("main_giving", "main_taking"):
        assert {f"{circuit}.{what}" for what in ("q_pump", "q_bypass", "q_relief", "p_pump")} <= set(units)
    assert units["main_giving.q_cross"] == "m3/s"
    assert units["main_taking.p_between"] == "Pa"
    assert "main_giving.p_between" not in units


def test_a_pump_feeds_its_own_functions_and_the_one_behind_its_crossover(joined_crane):
    giving, taking = joined_crane.circuits
    assert fed_functions(joined_crane, giving.name) == {*giving.functions, taking.functions[-1]}
    assert fed_functions(joined_crane, taking.name) == set(taking.functions)
