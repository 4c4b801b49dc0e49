"""Machines of any layout run against logs of themselves: a small crane that slews, lifts and extends."""

import numpy as np
import pytest

from helpers.machine_log import machine_log
from helpers.small_crane import with_effects, write_crane
from polydraulic import build_flow, load_machine, random_operator, simulate
from polydraulic.errors import InputError
from polydraulic.identification import plot_replay, replay
from polydraulic.identification.log_replay import driven, joints_of
from polydraulic.parameters.layout.parts import FlowForce
from polydraulic.tables import Table


@pytest.fixture(scope="module")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))


def noiseless(crane, seconds=7.0):
    """Every step of a run from when the boom, which begins out of balance, has stopped to shake: a parabola knows no shaking."""
    run = simulate(crane, "exact", random_operator(3, seconds, functions=crane.names), dt=5e-3)
    later = run["time"] >= 1.0
    return Table({name: run[name][later] for name in ("time", *driven(crane))}, run.units)


@pytest.fixture(scope="module")
def crane_log(crane):
    return noiseless(crane)


@pytest.fixture(scope="module")
def of_crane(crane, crane_log):
    return replay(crane_log, crane, "exact", seconds=2.0)


def test_columns_go_by_the_functions_of_the_machine(crane):
    assert [joint[:3] for joint in joints_of(crane)] == [
        ("slew", "slew.angle", "rad"),
        ("lift", "lift.angle", "rad"),
        ("extend", "extend.position", "m"),
    ]
    assert driven(crane)[4:8] == ["extend.voltage", "extend.position", "slew.spool", "slew.p_a"]


def test_a_machine_of_another_layout_follows_its_own_log(of_crane):
    assert [(d.name, d.unit) for d in of_crane.drifts] == [
        ("slew", "rad"), ("lift", "rad"), ("extend", "m"), ("tip", "m"),
    ]  # fmt: skip
    assert len(of_crane.windows) == 3
    for drift in of_crane.drifts:  # what is left is the parabola's
        assert drift.median <= drift.largest < 0.01 * drift.moved
    assert [row.split()[0] for row in str(of_crane).splitlines()[2:]] == ["slew", "lift", "extend", "tip"]
    assert str(of_crane).splitlines()[4].endswith(" mm")
    assert str(of_crane).splitlines()[3].endswith(" deg")


@pytest.mark.parametrize(("circuit", "told"), [("main", [0, 1]), ("second", [2])])
def test_a_machine_with_another_pump_is_told_apart_by_the_functions_of_that_pump(
    crane, crane_log, of_crane, circuit, told
):
    pumps = tuple(
        c._replace(pump=c.pump._replace(flow=0.8 * c.pump.flow)) if c.name == circuit else c for c in crane.circuits
    )
    found = replay(crane_log, crane._replace(circuits=pumps), "exact", seconds=2.0).drifts
    for place in told:
        assert found[place].largest > 10.0 * of_crane.drifts[place].largest
        assert found[place].largest > 0.05 * found[place].moved


@pytest.mark.slow
def test_effects_begin_as_pressures_and_spools_suggest(crane):
    still = FlowForce(1e20, 870.0, 0.5 * np.pi)  # nothing, but a layout that other tests compile as well
    loose = with_effects(crane, sticks=True, backlash=0.005, hysteresis=3e-4, flow_force=still)
    log = noiseless(loose, 5.0)
    own, other = (replay(log, m, "exact", seconds=2.0).drifts for m in (loose, crane))
    for drift, without in zip(own, other, strict=True):
        assert drift.largest < 0.05 * drift.moved
        assert drift.largest < 0.5 * without.largest


def test_what_a_log_of_another_machine_lacks_is_named(crane, crane_log):
    without = {name: values for name, values in crane_log.columns.items() if name != "extend.position"}
    with pytest.raises(
        InputError,
        match=r"^table: no column 'extend.position'; a replay needs time and, of each of slew, lift, extend, voltage",
    ):
        replay(Table(without, crane_log.units), crane, "iterative")
    with pytest.raises(
        InputError, match="^the log has no column of slew, lift, extend, the functions of .* choose the machine"
    ):
        replay(machine_log(1.0), crane, "iterative")
    with pytest.raises(InputError, match="column 'extend.position' is in 'mm'; a machine runs in SI, this in 'm'"):
        replay(Table(crane_log.columns, {**crane_log.units, "extend.position": "mm"}), crane, "iterative")


def test_a_flow_model_serves_all_functions(crane, crane_log):
    some_of_it = build_flow("iterative", crane)._replace(served=("slew", "lift"))
    with pytest.raises(InputError, match="flow 'iterative' has no networks for extend; train networks of their"):
        replay(crane_log, crane, some_of_it)
    with pytest.raises(InputError, match="no networks come with the package for 'Small crane'"):
        replay(crane_log, crane)


def test_the_picture_has_an_axis_of_drift_for_each_unit(of_crane):
    figure = plot_replay(of_crane)
    assert [axis.get_ylabel() for axis in figure.axes] == [
        "slew\nangle [deg]",
        "lift\nangle [deg]",
        "extend\nposition [mm]",
        "run - measured\n[deg]",
        "run - measured\n[mm]",
    ]
    assert [len(axis.lines) for axis in figure.axes[3:]] == [6, 3]
    window = of_crane.windows[0]
    apart = 1e3 * (window.run - window.measured)[:, 2]
    assert figure.axes[4].lines[0].get_ydata() == pytest.approx(apart, abs=1e-9)
    assert figure.axes[-1].get_xlabel() == "time [s]"
