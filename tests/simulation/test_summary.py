"""What is said of a run, from made runs whose events are known, and from a real one."""

import numpy as np
import pytest

from polydraulic.simulation.summary import run_summary, warnings
from polydraulic.tables import Table


def run(events=(), **info):
    time = np.linspace(0.0, 10.0, 11)
    columns = {"time": time, "boom.p_a": 1e5 * time, "boom.p_b": 2e6 - 1e5 * time, "boom.p_pump": np.full(11, 3e6)}
    columns |= {f"{link}.angle": np.full(11, 0.5) for link in ("swing", "boom", "stick")}
    columns |= {f"effector.{axis}": np.full(11, 2.0) for axis in "xyz"}
    units = {"time": "s"} | {name: "Pa" for name in columns if ".p_" in name}
    units |= {name: "rad" for name in columns if name.endswith(".angle")}
    return Table(columns, units, {"events": [list(event) for event in events], **info})


def test_a_quiet_run_says_little():
    assert run_summary(run(steps=2000, steps_not_converged=0, steps_out_of_domain=0)) == [
        "largest pressures: boom B 20 bar at 0.00 s, boom pump 30 bar at 0.00 s",
        "at the end: swing 28.65 deg, boom 28.65 deg, stick 28.65 deg; tip at x 2000 mm, y 2000 mm, z 2000 mm",
    ]


def test_numbers_have_the_units_asked_for():
    field, si = (run_summary(run(), units)[0] for units in ("field", "si"))
    assert "boom B 290.1 psi" in field
    assert "boom B 2000000 Pa" in si
    assert "z 78.74 in" in run_summary(run(), "field")[-1]


def test_events_are_counted_with_their_first_times():
    events = [(1.0, "boom", "valve opens"), (2.0, "boom", "valve closes"), (3.0, "boom", "valve opens")]
    lines = run_summary(run([*events, (4.0, "swing", "valve opens")]))
    assert lines[1:3] == ["events:", "  valve opens          boom 2x from 1.00 s, swing 1x from 4.00 s"]


@pytest.mark.parametrize(
    ("events", "expected"),
    [
        ([(2.0, "pump relief opens"), (3.5, "pump relief closes")], "for 1.5 s in all, first at 2.00 s"),
        ([(8.0, "pump relief opens")], "for 2 s in all, first at 8.00 s"),  # to the end
        ([(4.0, "pump relief closes")], "for 4 s in all, first at 0.00 s"),  # from the start
        (
            [(1.0, "pump relief closes"), (5.0, "pump relief opens"), (6.0, "pump relief closes")],
            "for 2 s in all, first at 0.00 s",
        ),
    ],
)
def test_how_long_a_relief_valve_is_open(events, expected):
    found = warnings(run([(time, "boom", what) for time, what in events]))
    assert found == [f"boom: pump relief valve open {expected}"]


def test_what_the_steps_met():
    found = warnings(run(steps=2000, steps_not_converged=10, steps_out_of_domain=500, events_dropped=3))
    assert found[0].startswith("10 of 2000 steps (0.5%) did not converge")
    assert found[1].startswith("500 of 2000 steps (25.0%) left the domain of the flow model")
    assert found[2].startswith("3 more events than are listed")


def test_the_largest_pressures_of_a_real_run(whole):
    exact = whole["exact"]
    line = run_summary(exact)[0]
    name = max(("boom.p_a", "boom.p_b"), key=lambda column: exact[column].max())
    assert f"boom {name[-1].upper()} {exact[name].max() / 1e5:.4g} bar at" in line
    assert "series pump" in line


def test_events_of_rows_that_are_far_apart_say_so():
    table = run(events=[(0.2, "boom", "valve opens")], dt=0.005)
    assert any(line == "events seen in rows that are 1 s apart; others are missed:" for line in run_summary(table))


def test_events_that_a_method_locates_are_not_said_to_be_missed():
    table = run(events=[(0.2, "boom", "valve opens")], dt=0.005, rtol=1e-4, rows_not_converged=2)
    assert "events:" in run_summary(table)
    assert warnings(table) == ["2 of 11 rows (18.2%) hold flows that did not converge"]
