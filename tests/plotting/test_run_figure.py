import io

import numpy as np
import pytest

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
        "full: inlet, dashed: pump",
    ]


def test_one_run_alone_shows_where_its_tip_is(boom_runs):
    below = plot_run({"exact": boom_runs["exact"]}).axes[-1]
    assert [line.get_label() for line in below.lines] == ["x", "y", "z"]
    assert below.get_ylabel() == "tip position [mm]"
    assert below.lines[2].get_ydata() == pytest.approx(1e3 * boom_runs["exact"]["effector.z"])


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
    with pytest.raises(InputError, match=r"run 'mine' has no column 'swing.angle'"):
        plot_run({"mine": Table({"time": np.zeros(2)}, {})})
