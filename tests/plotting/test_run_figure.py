import io

import numpy as np
import pytest

from helpers.made_runs import made_run, small_crane
from polydraulic.errors import InputError
from polydraulic.plotting.run_figure import plot_run
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import Table
from polydraulic.unit_table import PSI

QUANTITIES = ["joystick [V]", "spool [mm]", "flow [l/min]", "pressure [bar]", "angle [deg]"]


def test_the_whole_machine_has_a_column_a_link_and_the_tip_below(whole):
    figure = plot_run(whole)
    *panels, below = figure.axes
    assert [axis.get_title() for axis in panels[::5]] == ["swing", "boom", "stick"]
    assert [axis.get_ylabel() for axis in panels] == [*QUANTITIES, *10 * [""]]
    assert all(panels[row].get_ylim() == panels[row + 5].get_ylim() == panels[row + 10].get_ylim() for row in range(4))
    assert panels[4].get_ylim() != panels[9].get_ylim()  # angles
    assert below.get_ylabel() == "tip from\nexact [mm]"
    (line,) = below.lines
    assert line.get_ydata() == pytest.approx(1e3 * effector_distance(whole["exact"], whole["iterative"]))
    angle = panels[9].lines[1].get_ydata()
    assert angle == pytest.approx(np.degrees(whole["iterative"]["boom.angle"]))
    figure.savefig(io.BytesIO(), format="svg")


def test_flows_and_pressures_have_dashed_lines_where_there_is_something_to_show(boom_runs):
    panels = plot_run(boom_runs).axes
    assert [len(axis.lines) for axis in panels] == [2, 2, 4, 3, 2, 1]  # networks give no pump pressure
    assert [axis.get_title(loc="right") for axis in panels[2:4]] == [
        "full: into the actuator, dashed: out of it",
        "full: inlet (A, or B at a negative spool), dashed: pump (exact alone)",
    ]


def test_one_run_alone_shows_where_its_tip_is(boom_runs):
    below = plot_run({"exact": boom_runs["exact"]}).axes[-1]
    assert [line.get_label() for line in below.lines] == ["x", "y", "z"]
    assert below.get_ylabel() == "tip position [mm]"
    assert below.lines[2].get_ydata() == pytest.approx(1e3 * boom_runs["exact"]["effector.z"])


def test_a_run_is_broad_below_others_and_thin_alone(boom_runs):
    broad = plot_run(boom_runs).axes[0].lines[0]
    alone = plot_run({"exact": boom_runs["exact"]}).axes[0].lines[0]
    assert (broad.get_linewidth(), alone.get_linewidth()) == (3.5, 1.3)
    assert broad.get_color() != alone.get_color()


def test_numbers_are_in_the_units_asked_for(boom_runs):
    for units, label, scale in (("field", "pressure [psi]", PSI), ("si", "pressure [Pa]", 1.0)):
        panel = plot_run(boom_runs, units=units).axes[3]
        assert panel.get_ylabel() == label
        assert panel.lines[0].get_ydata() == pytest.approx(boom_runs["exact"]["boom.p_in"] / scale)
    with pytest.raises(InputError, match="units = 'imperial'"):
        plot_run(boom_runs, units="imperial")


def test_what_is_no_run_is_named(boom_runs):
    with pytest.raises(InputError, match="there is no run to show"):
        plot_run({})
    with pytest.raises(InputError, match=r"run 'mine' has no column 'effector.x'"):
        plot_run({"mine": Table({"time": np.zeros(2)}, {})})


def test_a_joint_that_slides_has_its_own_label_and_pump():
    run = made_run(small_crane())
    figure = plot_run({"made": run})
    *panels, _ = figure.axes
    assert [axis.get_title() for axis in panels[::5]] == ["slew", "lift", "reach"]
    assert [axis.get_ylabel() for axis in panels[4::5]] == ["angle [deg]", "", "position [mm]"]
    assert panels[14].lines[0].get_ydata() == pytest.approx(1e3 * run["reach.position"])
    assert panels[13].lines[1].get_ydata() == pytest.approx(1e-5 * run["work.p_pump"])
    figure.savefig(io.BytesIO(), format="svg")


def test_texts_of_many_functions_do_not_cover_each_other():
    crane = made_run(small_crane())
    names = [f"a_function_with_a_name_of_forty_letters_{k}" for k in range(8)]
    columns = {name: values for name, values in crane.columns.items() if name.partition(".")[0] in ("time", "effector")}
    for place, name in enumerate(names):
        own = "reach" if place == 3 else "lift"
        columns |= {
            name + old[len(own) :]: values for old, values in crane.columns.items() if old.startswith(f"{own}.")
        }
    units = {name: crane.units.get(name, "") for name in columns}
    units |= {
        name: {"voltage": "V", "spool": "m", "angle": "rad", "position": "m"}.get(name.rpartition(".")[2], "Pa")
        for name in columns
        if "function" in name
    }
    units |= {name: "m3/s" for name in columns if name.rpartition(".")[2] in ("q_in", "q_out")}
    figure = plot_run({"made": Table(columns, units, {"circuits": {"work": names}})})
    figure.draw_without_rendering()
    texts = [t for axis in figure.axes for t in (axis.title, axis._right_title, axis.yaxis.label) if t.get_text()]
    boxes = [text.get_window_extent() for text in texts]
    assert len(boxes) == 8 + 9 + 5 + 1 + 1  # names, what lines are, labels at the left, one joint that slides, the tip
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
