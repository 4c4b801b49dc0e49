"""Lift charts: each cell is the capacity of its pose, the worse direction and the better pose."""

import numpy as np
import pytest

from polydraulic import InputError, load_chart, load_machine
from polydraulic.machine.frames import link_frames, placed
from polydraulic.machine.stability.lifting import lift_limits


@pytest.fixture(scope="module")
def chart():
    return load_chart("excavator_22t")


def test_each_cell_is_the_capacity_of_its_pose(chart):
    machine = load_machine("excavator_22t")
    over, row, column = np.nonzero(np.isfinite(chart.capacity))
    poses = chart.positions[over, row, column]
    tips = placed(link_frames(machine, poses), *machine.tip)
    np.testing.assert_allclose(np.hypot(tips[:, 0], tips[:, 1]), chart.reach[column], rtol=0, atol=1e-9)
    np.testing.assert_allclose(tips[:, 2], chart.height[row], rtol=0, atol=1e-9)  # its ground is at z = 0
    found = lift_limits(machine, poses, "boom")
    np.testing.assert_array_equal(found.capacity, chart.capacity[over, row, column])
    tips_first = chart.limit[over, row, column] < chart.tipping
    np.testing.assert_array_equal(found.by_tipping, tips_first)
    assert len(over) > 60


def test_over_the_side_less_is_lifted_and_tipping_limits_first(chart):
    front, side = chart.capacity
    known = np.isfinite(front)
    np.testing.assert_array_equal(known, np.isfinite(side))
    assert (side[known] <= front[known] + 1e-9).all()
    tips = [(chart.limit[k][known] < chart.tipping).sum() for k in (0, 1)]
    assert 0 < tips[0] < tips[1]


def test_of_both_sides_the_worse_counts():
    machine = load_machine("excavator_22t")
    leaning = machine._replace(chassis=machine.chassis._replace(cg={"y": -0.4, "z": 0.5}))
    limits = load_chart(leaning, step=2.0)
    of_side = limits.limit[1][np.isfinite(limits.capacity[1])]
    assert {limits.limits[k] for k in of_side if k < limits.tipping} == {"tipping right"}


def test_a_table_has_a_row_for_each_cell(chart):
    table = chart.table
    assert len(table) == np.isfinite(chart.capacity).sum()
    assert list(table.names) == ["reach", "height", "side", "capacity", "limit"]
    assert np.isfinite(table["capacity"]).all()


def test_held_functions_and_those_that_move_are_chosen():
    curled = load_chart("excavator_22t", step=2.0, held={"bucket": -1.9})
    assert np.nanmax(np.abs(curled.positions[np.isfinite(curled.capacity)][:, 3] + 1.9)) == 0.0
    other = load_chart("loader_crane", step=1.0, moved=("inner", "tilt"), lifting="inner")
    assert other.moved == ("inner", "tilt")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"step": 0.0}, "step = 0 m"),
        ({"step": 1e-4}, "at most 250000 places"),
        ({"step": 100.0}, "give a smaller step than 100 m"),
        ({"lifting": "arm"}, "'arm' is not a function"),
        ({"lifting": "swing"}, "swing: turns the machine and lifts nothing"),
        ({"held": {"boom": 0.0}}, "boom: moves the tip"),
        ({"moved": ("boom", "swing")}, "swing: does not turn"),
    ],
)
def test_what_cannot_be_charted_is_refused(options, words):
    with pytest.raises(InputError, match=words):
        load_chart("excavator_22t", **options)


def test_a_machine_without_chassis_is_refused():
    with pytest.raises(InputError, match=r"no \[chassis\]"):
        load_chart(load_machine("cat215b")._replace(chassis=None))
