"""Networks of a machine from what circuits see."""

import numpy as np

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
