from polydraulic.parameters.load import load_layout
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.lane_rows import lane_rows


def test_every_value_has_a_row_of_its_own_behind_those_of_a_record():
    machine = load_layout("cat215b_bucket")
    columns = columns_of(machine)
    rows = lane_rows(machine, 10, {2: 7})
    scratch = [
        row
        for name, of in rows.groups.items()
        if name not in {c.name.split(".")[1] for c in columns.columns}
        for row in of
    ]
    others = [
        *scratch,
        *rows.mass,
        *(row for of in rows.passed.values() for row in of),
        *rows.status.values(),
        rows.steps,
        rows.unsettled,
        rows.met,
    ]
    assert sorted(others) == list(range(len(columns.columns), rows.n_row))
    assert rows.groups["p_a"] == [columns.place[f"{f}.p_a"] for f in machine.names]
    assert set(rows.passed) == {"boom", "series"}
    assert len(rows.passed["boom"]) == 7
