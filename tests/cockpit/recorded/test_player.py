"""A drive that is replayed has every bit of what was driven, however it is played."""

import json

import numpy as np
import pytest

from helpers.random_drive import random_drive
from polydraulic import InputError, Simulator
from polydraulic.cockpit.cab import DT, Cab
from polydraulic.cockpit.recorded.drives import ENDING, Drive, read_drive
from polydraulic.cockpit.recorded.player import Player
from polydraulic.cockpit.recorded.tape import state_hash
from polydraulic.cockpit.wanted import ReplayWish, Wanted


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A drive with all that there is, and the bits of its end."""
    cab = Cab("wheel_loader")
    path = tmp_path_factory.mktemp("drive") / f"random{ENDING}"
    drive = random_drive(cab, path, 7, 240, faults=("work.pump_worn", "lift.friction_high", "tilt.leak_across"))
    return drive, path


def simulator():
    return Simulator("wheel_loader", dt=DT, load={"payload": 0.0})


def test_a_drive_holds_all_kinds_of_stamps(driven):
    drive, _ = driven
    kinds = {key for stamp in drive.stamps for key in stamp}
    assert kinds == {"step", "levers", "payload", "change", "reset", "hash", "end"}
    assert drive.whole
    assert drive.end > 2200


def test_a_replay_ends_with_the_bits_that_were_driven(driven):
    drive, _ = driven
    for piece in (1, 7, 100_000):
        sim = simulator()
        player = Player(drive, sim, sim.machine)
        while not player.ended:
            assert player.advance(piece) > 0
        assert state_hash(sim) == drive.stamps[-1]["hash"]  # and those on the way, which the player compares


def test_any_place_can_be_gone_to_and_gone_on_from(driven):
    drive, _ = driven
    sim = simulator()
    player = Player(drive, sim, sim.machine)
    seen = {}
    while not player.ended:
        player.advance(500)
        seen[player.step] = (state_hash(sim), player.payload, dict(player.values))
    for step in (1500, 500, 2000, 1000):
        player.go_back(step)
        player.advance(step - player.step)
        assert player.step == step
        assert (state_hash(sim), player.payload, player.values) == seen[step]
    player.advance(10**6)
    assert state_hash(sim) == drive.stamps[-1]["hash"]


def test_another_bit_is_noticed(driven):
    drive, _ = driven
    stamps = [dict(stamp) for stamp in drive.stamps]
    place = max(k for k, stamp in enumerate(stamps) if "levers" in stamp)
    stamps[place]["levers"] = np.nextafter(stamps[place]["levers"], 9.0).tolist()
    sim = simulator()
    with pytest.raises(InputError, match="not the one that was recorded"):
        Player(drive._replace(stamps=tuple(stamps)), sim, sim.machine).advance(10**6)


def test_a_drive_of_another_machine_is_refused(driven):
    drive, _ = driven
    heavy = Simulator(simulator().machine.with_values({"links.bucket.mass": 901.0}), dt=DT, load={"payload": 0.0})
    with pytest.raises(InputError, match="cannot be replayed bit for bit"):
        Player(drive, heavy, heavy.machine)


def test_a_damaged_start_is_refused(driven):
    drive, _ = driven
    sim = simulator()
    for text in ("AAAA", "?"):
        head = drive.head | {"start": drive.head["start"] | {"live": text}}
        with pytest.raises(InputError, match="damaged"):
            Player(drive._replace(head=head), sim, sim.machine)


def test_a_cab_replays_stops_seeks_and_goes_on_by_hand(driven, cab):
    drive, _ = driven
    wish = ReplayWish(1, drive)
    wanted = Wanted(replay=wish)
    cab.move(wanted, 10)
    assert (cab.shown.replay.time, cab.shown.replay.playing) == (pytest.approx(10 * DT), True)
    wanted = wanted._replace(replay=wish._replace(playing=False, seeks=1, step=2100))
    for _ in range(4):
        cab.move(wanted, 10)
    assert cab.shown.replay.time == pytest.approx(2100 * DT)
    sim = simulator()
    player = Player(drive, sim, sim.machine)
    player.advance(2100)
    assert state_hash(sim) == state_hash(cab.simulator)
    cab.move(wanted._replace(replay=wish._replace(playing=True, seeks=1, step=2100)), 10)
    wanted = Wanted(taken_over=1, payload=player.payload)
    before = cab.simulator.steps
    cab.move(wanted, 1)
    assert cab.simulator.steps == before + 1
    assert cab.shown.replay is None
    assert cab.simulator.machine == cab.machine  # faults of the drive are not there any more
    cab.move(Wanted(replay=ReplayWish(2, drive), taken_over=1), 10**6)
    assert cab.shown.replay.time == pytest.approx(drive.end * DT)
    assert state_hash(cab.simulator) == drive.stamps[-1]["hash"]
    cab.move(Wanted(taken_over=1), 3)
    assert cab.simulator.steps == 3  # stopped: it begins anew


def test_a_replay_that_fails_says_so_and_the_machine_begins_anew(driven, cab):
    drive, _ = driven
    stamps = (drive.stamps[0], {"step": 5, "hash": "0" * 32}, *drive.stamps[1:])
    stamps = tuple(sorted(stamps, key=lambda stamp: stamp["step"]))
    cab.move(Wanted(replay=ReplayWish(1, drive._replace(stamps=stamps))), 50)
    assert "cannot be replayed" in cab.shown.error[1]
    assert cab.shown.replay is None
    assert cab.simulator.steps == 0


def test_a_file_that_ends_within_a_line_is_read_up_to_it(driven, tmp_path):
    drive, path = driven
    content = path.read_text(encoding="utf-8")
    cut = tmp_path / f"cut{ENDING}"
    cut.write_text(content[: len(content) // 2], encoding="utf-8")
    half = read_drive(cut)
    assert isinstance(half, Drive)
    assert not half.whole
    assert half.stamps == drive.stamps[: len(half.stamps)]
    sim = simulator()
    player = Player(half, sim, sim.machine)
    player.advance(10**6)
    assert player.step == half.end


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('{"step": 5, "levers": [0.0]}', "damaged"),
        ('{"step": 5, "levers": [0.0, NaN]}', "damaged"),
        ('{"step": 5, "levers": [0.0, 1' + "0" * 400 + "]}", "damaged"),
        ('{"step": 5, "payload": true}', "damaged"),
        ('{"step": 5, "levers": "up"}', "damaged"),
        ('{"step": -5}', "damaged"),
        ('{"levers": [0.0, 0.0]}', "damaged"),
        ('{"step": 5, "change": {"gravity": "x"}}', "damaged"),
        ("[]", "damaged"),
        ("{", "damaged"),
    ],
)
def test_damage_within_a_file_is_named(driven, tmp_path, line, says):
    _, path = driven
    lines = path.read_text(encoding="utf-8").split("\n")
    bad = tmp_path / f"bad{ENDING}"
    bad.write_text("\n".join([lines[0], line, *lines[1:]]), encoding="utf-8")
    with pytest.raises(InputError, match=f"line 2.*{says}"):
        read_drive(bad)


def test_what_is_no_drive_is_refused(tmp_path):
    for content in (b"", b"{}\n", b'{"form": "other"}\n', b"\xff\xfe\n"):
        (tmp_path / "x").write_bytes(content)
        with pytest.raises(InputError, match=str(tmp_path / "x")):
            read_drive(tmp_path / "x")
    with pytest.raises(InputError, match="No such file"):
        read_drive(tmp_path / "none")
    (tmp_path / "y").write_text(json.dumps({"form": "polydraulic drive 1"}) + "\n")
    with pytest.raises(InputError, match="line 1: machine"):
        read_drive(tmp_path / "y")
