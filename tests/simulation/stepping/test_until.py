import pytest

from polydraulic import InputError, Simulator


def test_a_run_to_a_time_an_event_or_a_condition(loader):
    sim = Simulator(loader)
    assert sim.run_until(0.1)
    assert sim.steps == 20
    assert sim.run_until("lift high stop met", {"lift": 0.8}, limit=20.0)
    assert sim.events[-1][1:] == ["lift", "high stop met"]
    assert sim.time == sim.events[-1][0]  # no step is made beyond
    met = sim.time
    assert not sim.run_until("low stop met", {"lift": 0.0}, limit=0.2)
    assert sim.time == pytest.approx(met + 0.2)
    low = float(sim["lift.angle"]) - 0.1
    assert sim.run_until(lambda s: s["lift.angle"] < low, {"lift": -0.8})
    assert low - 0.05 < float(sim["lift.angle"]) < low
    for until, words in (
        ("stop met", "until = 'stop met': no such event; there are"),
        (0.05, "until = 0.05 s: has passed"),
        (float("nan"), "until = nan: must be a finite number in s"),
        (1e9, "at most 1e.09 are made"),
    ):
        with pytest.raises(InputError, match=words):
            sim.run_until(until)
