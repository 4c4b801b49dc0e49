import numpy as np
import pytest

from polydraulic import InputError, Simulator
from polydraulic.simulation.stepping.pace import PATIENCE, Pace


class Clock:
    """A clock of which a test says how it runs."""

    def __init__(self, now=50.0, late=0.0):
        self.now, self.late = now, late

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds + self.late


def test_deadlines_are_moments_so_that_delays_do_not_add_up():
    clock = Clock(late=1e-3)
    pace = Pace(clock=clock, sleep=clock.sleep)
    pace.start(0.0)
    for k in range(1, 1001):
        pace.wait(5e-3 * k)
    assert clock.now == pytest.approx(50.0 + 5.0 + 1e-3)
    assert (pace.overruns, pace.lost) == (0, 0.0)
    assert pace.latest == pytest.approx(1e-3)
    assert "kept pace at 1 times real time; late by 1.0 ms at most" in pace.report()


def test_speed_is_simulated_time_by_the_clocks():
    clock = Clock()
    pace = Pace(4.0, clock=clock, sleep=clock.sleep)
    pace.start(10.0)
    pace.wait(12.0)
    assert clock.now == 50.5


def test_small_delays_are_made_up_for_and_large_ones_given_up():
    clock = Clock()
    pace = Pace(clock=clock, sleep=clock.sleep)
    pace.start(0.0)
    clock.now += 0.04  # within the patience
    pace.wait(0.01)
    pace.wait(0.05)
    assert clock.now == pytest.approx(50.05)
    assert pace.overruns == 0
    clock.now += 0.3
    pace.wait(0.06)
    assert pace.overruns == 1
    assert pace.lost == pytest.approx(0.29)
    pace.wait(0.07)  # the schedule goes on from there
    assert clock.now == pytest.approx(50.36)
    assert "1 overruns: 0.290 s given up, late by 290.0 ms at most" in pace.report()
    assert PATIENCE == 0.05


def test_a_schedule_begins_where_it_is_started():
    clock = Clock()
    pace = Pace(clock=clock, sleep=clock.sleep)
    assert not pace.running
    pace.wait(3.0)  # begins one
    assert pace.running
    assert clock.now == 50.0
    pace.stop()
    assert not pace.running


def test_a_clock_that_stands_still_ends_no_wait():
    slept = []
    pace = Pace(clock=lambda: 0.0, sleep=slept.append)
    pace.start(0.0)
    pace.wait(1.0)
    assert len(slept) == 1000


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf"), "fast"])
def test_speeds_that_are_none(speed):
    with pytest.raises(InputError, match="realtime = .*: must be a finite number"):
        Pace(speed)


def test_real_time_is_kept_by_deadlines_and_never_written_into_the_run(loader):
    clock = Clock()
    free, sim = Simulator(loader), Simulator(loader, realtime=2.0, clock=clock, sleep=clock.sleep)
    for k in range(40):
        clock.now += 0.4 if k == 20 else 0.001  # somebody thinks for long, once
        sim.step([0.5, 0.1], n=2)
        free.step([0.5, 0.1], n=2)
    assert np.array_equal(sim.values, free.values)
    assert sim.time == free.time == 0.4
    assert sim.pace.overruns == 1
    assert sim.pace.lost == pytest.approx(0.4 - 0.005)
    assert clock.now == pytest.approx(50.0 + 0.001 + 0.2 + sim.pace.lost)
    sim.reset()
    clock.now += 7.0  # a new run has a new schedule
    sim.run_until(0.1)
    assert sim.pace.overruns == 1
