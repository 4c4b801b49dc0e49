"""What was driven is a scenario that gives the same bits, and a log that the path from logs takes."""

import numpy as np
import pytest

from helpers.random_drive import random_drive
from polydraulic import InputError, load_scenario, read_table, simulate
from polydraulic.cockpit.cab import DT, Cab
from polydraulic.cockpit.recorded.drives import ENDING
from polydraulic.cockpit.recorded.export import export_drive, simulator_of
from polydraulic.cockpit.recorded.player import Player
from polydraulic.measure import load_channels, suggest_channels
from polydraulic.measure.importing import import_log


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A drive with payloads and resets, without faults."""
    return random_drive(Cab("wheel_loader"), tmp_path_factory.mktemp("drive") / f"plain{ENDING}", 3, 60)


def test_a_scenario_gives_the_bits_of_the_drive_since_its_last_reset(driven, tmp_path):
    export_drive(driven, scenario=tmp_path / "drive.toml")
    sim = simulator_of(driven)
    machine = sim.machine
    scenario = load_scenario(tmp_path / "drive.toml", functions=machine.names)
    run = simulate(machine, "exact", scenario, dt=DT)
    player = Player(driven, sim, machine)
    player.advance(driven.end)
    assert scenario.duration == pytest.approx(sim.time)
    for name in ("lift.angle", "lift.p_a", "tilt.rate", "work.p_pump"):
        assert run[name][-1] == float(sim[name]), name
    assert len(run) == sim.steps + 1
    assert scenario.loads.payload is not None
    assert max(scenario.loads.payload.mass) > 0.0


def test_a_log_holds_the_drive_and_can_be_imported(driven, tmp_path):
    log = tmp_path / "drive.csv"
    export_drive(driven, log=log, raster=0.02)
    table = read_table(log)
    sim = simulator_of(driven)
    player = Player(driven, sim, sim.machine)
    assert len(table) == -(-driven.end // 4)
    for row in (0, 1, 50, len(table) - 1):
        player.go_back(4 * row)
        player.advance(4 * row - player.step)
        assert table["time"][row] == pytest.approx(4 * row * DT, abs=1e-12)
        assert table["lift.angle"][row] == float(sim["lift.angle"])
        assert table["work.p_pump"][row] == float(sim["work.p_pump"])
    assert np.ptp(table["lift.voltage"]) > 0.5
    (tmp_path / "map.toml").write_text(suggest_channels([str(log)]), encoding="utf-8")
    found = import_log([str(log)], load_channels(tmp_path / "map.toml"), tmp_path / "table.parquet")
    assert found.n_row > 0.9 * len(table)


def test_a_drive_that_is_no_scenario_says_why(tmp_path):
    cab = Cab("wheel_loader")
    elsewhere = random_drive(cab, tmp_path / f"a{ENDING}", 3, 5, resets=False)
    with pytest.raises(InputError, match="begin to record, then reset"):
        export_drive(elsewhere, scenario=tmp_path / "x.toml")
    ill = random_drive(Cab("wheel_loader"), tmp_path / f"b{ENDING}", 3, 40, faults=("lift.leak_across",))
    with pytest.raises(InputError, match="has faults"):
        export_drive(ill, scenario=tmp_path / "x.toml")
    assert not (tmp_path / "x.toml").exists()
    for options, says in (
        ({}, "nothing to write"),
        ({"scenario": "x.csv"}, "ends in .toml"),
        ({"log": "x.mf4"}, "x.mf4"),
        ({"log": tmp_path / "x.csv", "raster": 0.007}, "whole number of steps"),
    ):
        with pytest.raises(InputError, match=says):
            export_drive(ill, **options)
