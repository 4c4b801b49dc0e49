import numpy as np
import pytest

from helpers.made_runs import made_run, small_crane
from polydraulic.errors import InputError
from polydraulic.plotting.frames import frames_of
from polydraulic.thesis.excavator import LINKS
from polydraulic.unit_table import PSI


def test_frames_lie_on_their_raster_and_between_rows(whole):
    frames = frames_of(whole, LINKS, 30.0)
    assert frames.time == pytest.approx(np.arange(19) / 30.0)
    exact = whole["exact"]
    assert frames.positions[0][:, 1] == pytest.approx(np.interp(frames.time, exact["time"], exact["boom.angle"]))
    assert np.array_equal(frames.positions[0][0], [exact[f"{link}.angle"][0] for link in LINKS])
    assert frames.effector[1][:, 2] == pytest.approx(
        np.interp(frames.time, exact["time"], whole["iterative"]["effector.z"])
    )


def test_channels_are_those_that_every_run_has(whole, boom_runs):
    def names(runs):
        return [f"{c.group}: {c.title} [{c.unit}]" for c in frames_of(runs, LINKS, 20.0).channels]

    found = names(whole)
    assert found[:4] == [
        "swing: angle [deg]",
        "swing: flow in [l/min]",
        "swing: inlet pressure [bar]",
        "swing: joystick [V]",
    ]
    assert found[-4:] == [
        "pumps and tip: boom pump pressure [bar]", "pumps and tip: series pump pressure [bar]",
        "pumps and tip: tip height [mm]",
        "pumps and tip: tip from first [mm]",
    ]  # fmt: skip
    # networks give no pump pressure
    assert names(boom_runs)[4:] == ["tip: tip height [mm]", "tip: tip from first [mm]"]
    assert names({"exact": boom_runs["exact"]})[-1] == "pumps and tip: tip height [mm]"


def test_channels_have_the_units_asked_for(boom_runs):
    channel = frames_of(boom_runs, LINKS, 20.0, "field").channels[2]
    assert (channel.title, channel.unit) == ("inlet pressure", "psi")
    assert channel.values[0][0] == pytest.approx(boom_runs["exact"]["boom.p_in"][0] / PSI)


def test_the_shortest_run_sets_the_end(whole, boom_runs):
    assert frames_of({"long": whole["exact"], "short": boom_runs["exact"]}, LINKS, 10.0).time[-1] == pytest.approx(0.2)


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf"), 1e6])
def test_rates_that_make_no_animation_are_named(whole, rate):
    with pytest.raises(InputError, match="frames/s over 0.6 s: must give 1 to 20000 frames"):
        frames_of(whole, LINKS, rate)


def test_a_machine_of_any_layout_has_its_own_joints_and_pumps():
    crane = small_crane()
    run = made_run(crane)
    frames = frames_of({"made": run}, crane.names, 10.0)
    assert frames.positions[0][-1] == pytest.approx(
        [run["slew.angle"][-1], run["lift.angle"][-1], run["reach.position"][-1]]
    )
    found = [f"{c.group}: {c.title} [{c.unit}]" for c in frames.channels]
    assert found[8] == "reach: position [mm]"
    assert found[-2:] == ["pumps and tip: work pump pressure [bar]", "pumps and tip: tip height [mm]"]


def test_a_run_of_another_machine_is_named(whole):
    with pytest.raises(
        InputError, match="run 'exact' has no column 'slew.angle' or 'slew.position'; give runs of the same machine"
    ):
        frames_of(whole, small_crane().names, 10.0)
