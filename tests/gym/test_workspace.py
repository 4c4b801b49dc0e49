"""Where a machine can be: poses between its stops, starts at rest, lines along which its joints can follow."""

import numpy as np
import pytest

from polydraulic import InputError, Simulator, load_machine
from polydraulic.gym.workspace import Lines, workspace_of
from polydraulic.machine.reach.tip import tip_at_joints
from polydraulic.simulation.layout.columns import columns_of


def as_they_are(states, span):
    return states


@pytest.fixture(scope="module")
def loader():
    return load_machine("wheel_loader")


def test_tips_lie_where_joints_between_their_stops_bring_them(loader):
    work = workspace_of(loader, as_they_are)
    stops = np.array([f.stops for f in loader.functions])
    assert np.array_equal(np.stack([work.travels.low, work.travels.high], axis=1), stops)
    assert not work.travels.turns.any()
    assert len(work.tips) > 1000
    assert np.all(np.linalg.norm(work.tips - [0.0, 0.0, 2.0], axis=1) < 2.6 + 1.3)
    assert np.ptp(work.tips[:, 2]) > 3.0
    assert work.lines is None  # none were asked for


def test_joints_that_turn_all_round_are_turned_a_part_of_it():
    work = workspace_of(load_machine("cat215b"), as_they_are)
    assert work.travels.turns.tolist() == [True, False, False]
    assert work.travels.high[0] - work.travels.low[0] < np.pi
    assert work.slews == 1.0


def test_starts_stand_still(loader):
    sim = Simulator(loader)

    def settle(states, span):
        found = states.copy()
        for state in found:
            sim.reset(state)
            sim.step(n=round(span / sim.dt))
            state[:] = sim.state
        return found

    work = workspace_of(loader, settle)
    place = columns_of(loader).place
    at = [place[f"{f}.angle"] for f in loader.names]
    assert len(work.starts) > 20
    assert np.abs(settle(work.starts, 2.0)[:, at] - work.starts[:, at]).max() < 5e-3
    assert np.allclose(work.start_tips, tip_at_joints(loader, work.starts[:, at]))


def test_a_machine_that_never_stands_still_is_refused(loader):
    def sink(states, span):
        return states - 0.01

    with pytest.raises(InputError, match="comes to rest in none"):
        workspace_of(loader, sink)


@pytest.mark.parametrize("name", ["wheel_loader", pytest.param("excavator_22t", marks=pytest.mark.slow)])
def test_lines_are_level_and_lead_to_the_machine(name):
    machine = load_machine(name)
    work = workspace_of(machine, as_they_are, lines=True)
    first, last, speed = work.lines
    length = np.linalg.norm(last - first, axis=1)
    assert np.allclose(first[:, 2], last[:, 2])
    assert np.all((length >= 0.5) & (length <= 4.0 + 1e-9))
    assert np.all(np.linalg.norm(last[:, :2], axis=1) < np.linalg.norm(first[:, :2], axis=1))
    assert np.all((speed >= 0.1) & (speed <= 0.3))
    assert np.ptp(first[:, 2]) > 1.0


def test_lines_at_a_given_depth(loader):
    lines: Lines = workspace_of(loader, as_they_are, lines=True, depth=0.5).lines
    assert np.allclose(lines.first[:, 2], 0.5, atol=0.01)
    assert np.allclose(lines.last[:, 2], 0.5, atol=0.01)


def test_a_depth_without_lines_is_refused(loader):
    with pytest.raises(InputError, match=r"at depth = -3 m; its tip reaches heights from -0\.\d+ to 4\.\d+ m"):
        workspace_of(loader, as_they_are, lines=True, depth=-3.0)


def test_full_speeds_are_strokes_in_their_time():
    speeds = workspace_of(load_machine("loader_crane"), as_they_are).travels.full
    assert speeds[0] == 0.6
    assert speeds[3] == pytest.approx(1.7 / 5.0)
