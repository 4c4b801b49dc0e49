from polydraulic.parameters.load import load_machine
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.lane_rows import lane_rows


def test_every_value_has_a_row_of_its_own_behind_those_of_a_record():
    machine = load_machine("cat215b_bucket")
    columns = columns_of(machine)
    rows = lane_rows(machine, 10, {2: ["q_pump", "w_1", "b_1", "b_2"]})
    scratch = [
        row
        for name, of in rows.groups.items()
        if name not in {c.name.split(".")[1] for c in columns.columns}
        for row in of
    ]
    others = [
        *scratch,
        *rows.mass,
        *(row for of in rows.passed.values() for row in of.values()),
        *rows.limited,
        rows.still,
        *rows.status.values(),
        rows.steps,
        rows.unsettled,
        rows.met,
        rows.outside,
        rows.beyond,
        rows.beyond_log,
    ]
    assert sorted(others) == list(range(len(columns.columns), rows.n_row))
    assert rows.groups["p_a"] == [columns.place[f"{f}.p_a"] for f in machine.names]
    assert set(rows.passed) == {"boom", "series"}
    assert list(rows.passed["boom"]) == [
        "q_pump", "w_1", "b_1", "b_2", "r_0", "rest_0", "r_1", "rest_1", "r_2", "rest_2",
    ]  # fmt: skip
