"""What a further sensor promises is what it gives once it is there."""

import numpy as np
import pytest

from helpers.operator_log import operator_log
from polydraulic import InputError, load_machine
from polydraulic.identification import plan_identification
from polydraulic.identification.equations.plan import Candidate, IdentificationPlan, candidate_rows, unsure_rows
from polydraulic.tables import Table

NAME = "wheel_loader"
FREE = ["functions.lift.pilot.gain", "circuits.work.pump.relief"]


def read_by(*ends):
    log = operator_log(NAME, seconds=13.0)
    names = [n for n in log.names if n == "time" or n.endswith((".voltage", ".angle", *ends))]
    return Table({n: log[n] for n in names}, {n: log.unit(n) for n in names})


@pytest.fixture(scope="module")
def plan():
    told = []
    found = plan_identification(read_by(), NAME, free=FREE, progress=lambda *step: told.append(step))
    assert told[-1] == ("planned", 4, 4)
    return found


def test_a_sensor_gives_what_was_promised(plan):
    promised = next(c for c in plan.candidates if c.name == "work.p_pump").unsure
    there = plan_identification(read_by("work.p_pump"), NAME, free=FREE)
    assert "work.p_pump" not in [c.name for c in there.candidates]
    # the log's own noise is that of differences, here nearly none, and a pump's pressure of 1 bar was promised
    assert (there.unsure <= promised * 1.001).all()
    assert (promised < plan.unsure).all()


def test_a_log_of_all_sensors_is_planned_for_with_motions_of_one_function(plan):
    all_read = plan_identification(read_by(".spool", ".p_a", ".p_b", ".q_in", ".q_out"), NAME, free=FREE)
    motions = [c.name for c in plan.candidates if c.is_motion]
    assert "lift alone, full stroke" in motions
    assert [c.name for c in all_read.candidates if c.is_motion] == motions
    assert [c.name for c in all_read.candidates if not c.is_motion] == ["work.p_pump"]
    assert (all_read.unsure < plan.unsure).all()


def test_more_of_anything_never_leaves_more_unsure(plan):
    assert plan.paths == tuple(FREE)
    assert ((plan.unsure > 0.0) & (plan.unsure <= 1.0)).all()
    for candidate in plan.candidates:
        assert (candidate.unsure <= plan.unsure * (1.0 + 1e-9)).all()
    motions = [c.name for c in plan.candidates if c.is_motion]
    assert motions[:2] == ["the same again", "all functions, full stroke"]
    again = next(c for c in plan.candidates if c.name == "the same again").unsure
    assert np.all(again >= plan.unsure / np.sqrt(2.0) - 1e-12)


def test_the_tables_begin_with_what_is_least_known(plan):
    text = str(plan).splitlines()
    least = plan.paths[int(np.argmax(plan.unsure))]
    assert text[3].split()[0] == least
    assert any(line.split()[:4] == ["nothing", f"{np.count_nonzero(plan.unsure < 0.5)}", "of", "2"] for line in text)


def test_what_cannot_be_planned_says_why():
    with pytest.raises(InputError, match="no number is free that runs could show; functions.lift.stops.low: kept"):
        plan_identification(read_by(), NAME, free=["functions.lift.stops.low"])
    log = read_by()
    without = Table({n: v for n, v in log.columns.items() if n != "tilt.angle"}, log.units)
    with pytest.raises(InputError, match="no column 'tilt.angle'"):
        plan_identification(without, load_machine(NAME), free=FREE)


@pytest.mark.parametrize(("left", "helps"), [(0.559, True), (0.561, False)])
def test_what_leaves_less_than_seven_tenths_narrows_a_number(left, helps):
    """Of 0.8; a number of which less than half is unsure is determined."""
    candidates = (
        Candidate("p_pump", False, np.array([left, 0.5])),
        Candidate("q_in", False, np.array([0.79, 0.499])),
        Candidate("the same again", True, np.array([0.8, 0.4])),
    )
    made = IdentificationPlan(("a", "b"), np.array([0.8, 0.51]), candidates, "log.csv")
    best = ["p_pump", "0.56"] if helps else ["-", "-"]
    assert unsure_rows(made) == [["a", "0.8", *best, "-", "-"], ["b", "0.51", "-", "-", "-", "-"]]
    assert candidate_rows(made) == [
        ["nothing", "0 of 2", "-"],
        ["the same again", "1 of 2", "-"],
        ["q_in", "1 of 2", "-"],
        ["p_pump", "0 of 2", "a, 0.8 to 0.56" if helps else "-"],
    ]
