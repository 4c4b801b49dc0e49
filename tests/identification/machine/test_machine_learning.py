"""Networks of a machine from what circuits see."""

import numpy as np
import pytest

from helpers.machine_log import machine_log
from polydraulic.identification.machine.machine_learning import learn, tasks_of, visited
from polydraulic.identification.machine.machine_log import Known, by_port, judging_rows
from polydraulic.tables import Table


def test_rows_at_the_relief_setting_are_not_learnt_from(machine):
    known = Known.of(machine)
    log = by_port(known, machine_log())
    rows = judging_rows("boom.q_in", log, known)
    stopped = (log["boom.travel"] > known.deadband["boom"]) & ~rows
    assert stopped.sum() > 0
    other = Table(log.columns | {"boom.q_in": np.where(stopped, 0.5, 1.0) * log["boom.q_in"]}, log.units)
    here, there = (
        learn([(tasks_of(machine, known, table, max_regions=1, max_rows=500)[0],)]) for table in (log, other)
    )
    assert here == there


def test_valves_behind_others_read_what_reaches_them_only_where_that_is_known(machine):
    known = Known.of(machine)
    log = by_port(known, machine_log())
    names = {task.output.name: [v.name for v in task.inputs] for task in tasks_of(machine, known, log)}
    assert names["stick.q_in"] == ["series.q_passed", "stick.travel", "stick.p_in"]
    limited = [c._replace(pump=c.pump._replace(torque_limit_enabled=True)) for c in machine.circuits]
    found = tasks_of(machine._replace(circuits=tuple(limited)), known, log)
    names = {task.output.name: [v.name for v in task.inputs] for task in found}
    assert names["stick.q_in"] == ["swing.travel", "stick.travel", "swing.p_in", "stick.p_in"]


def test_borders_keep_enough_values_on_either_side():
    values = np.concatenate([np.full(100, -2.0), np.full(30, -0.5), np.full(100, 0.5), np.full(10, 3.0)])
    assert visited([-1.0, 0.0, 1.0], values) == [-1.0]  # 30 values do not carry a part, nor do 10
    assert visited([-1.0, 0.0, 1.0], np.repeat([-2.0, -0.5, 0.5, 3.0], 100)) == [-1.0, 0.0, 1.0]
    assert visited([1.0], np.zeros(10)) == []


@pytest.mark.parametrize(("below", "above", "kept"), [(60, 60, [0.0]), (59, 60, []), (60, 59, [])])
def test_a_part_of_a_curve_takes_sixty_values(below, above, kept):
    assert visited([0.0], np.repeat([0.0, 1.0], [below, above])) == kept


@pytest.mark.parametrize("most", [100, 1200, 10**6])
def test_few_rows_find_few_regions_and_a_fifth_more_are_of_a_shut_valve(machine, most):
    known = Known.of(machine, ["boom"])
    log = by_port(known, machine_log())
    below = log["boom.p_in"] < 0.98 * machine.circuit("boom").pump.relief
    open_ = log["boom.travel"] > known.deadband["boom"]
    rows = [min(int(np.sum(below & open_)), most), min(int(np.sum(below & ~open_)), most // 5)]
    task = tasks_of(machine, known, log, max_rows=most)[0]
    travel = task.X[:, [v.name for v in task.inputs].index("boom.travel")]
    assert [np.sum(travel > known.deadband["boom"]), np.sum(travel <= known.deadband["boom"])] == rows
    assert task.learner.min_rows == min(150, max(20, sum(rows) // 40))


def test_errors_of_an_outlet_count_by_its_opening_and_alike_where_it_is_small(machine):
    known = Known.of(machine, ["boom"])
    task = tasks_of(machine, known, by_port(known, machine_log()))[-1]
    opens, end = known.deadband["boom"], machine.function("boom").valve.knots[-1]
    opening = np.maximum(np.abs(task.X[:, 0]) - opens, 0.0) / (end - opens)
    assert task.weight.max() == pytest.approx(1.0 / 0.03**2)
    assert task.weight == pytest.approx((0.03 + opening) ** -2)
