import errno
import os

import pytest

from polydraulic.cockpit.beat import Beat
from polydraulic.cockpit.exercises.results import read_results
from polydraulic.cockpit.keeper import Keeper
from polydraulic.cockpit.recorded.drives import ENDING, read_drive
from polydraulic.cockpit.wanted import TrialWish, Wanted


@pytest.fixture
def kept(cab, tmp_path):
    said = []
    beat = Beat(cab)
    keeper = Keeper(beat, tmp_path / "made", said.append)
    return beat, keeper, said


def go(kept, n, **wishes):
    """Some steps, and a look of the keeper."""
    beat, keeper, _ = kept
    beat.wanted = beat.wanted._replace(**wishes)
    beat.cab.move(beat.wanted, n)
    keeper.look()


def test_a_drive_is_written_as_it_goes_on(kept):
    _, keeper, _ = kept
    go(kept, 300)
    assert not keeper.folder.exists()
    go(kept, 300, recording=1, locked=False, axes=(0.0, 0.0, 0.0, -0.5, 0.0, 0.0))
    name = keeper.recording
    path = keeper.folder / f"{name}{ENDING}"
    half = read_drive(path)  # as after a crash
    assert (half.whole, keeper.drives) == (False, ())
    go(kept, 300)
    go(kept, 10, recording=0)
    assert keeper.recording is None
    drive = read_drive(path)
    assert (drive.end, drive.whole, keeper.drives) == (600, True, (name,))
    go(kept, 300, recording=2)
    assert keeper.recording not in (None, name)


def test_a_full_disk_ends_the_recording_and_nothing_else(kept, monkeypatch):
    beat, keeper, said = kept
    go(kept, 300, recording=1)
    whole = os.write

    def full(handle, content):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    go(kept, 300, locked=False, axes=(0.0, 0.0, 0.0, -0.5, 0.0, 0.0))
    monkeypatch.setattr(os, "write", whole)
    assert "No space left" in keeper.error[1]
    assert said == [f"warning: {keeper.error[1]}"]
    assert (beat.wanted.recording, keeper.recording) == (0, None)
    go(kept, 300)
    assert beat.cab.simulator.steps == 900
    drive = read_drive(keeper.folder / f"{keeper.drives[0]}{ENDING}")
    assert (drive.end, drive.whole) == (0, False)  # what was written before


def test_a_disk_that_is_too_slow_is_no_gap_in_a_recording(kept):
    beat, keeper, said = kept
    go(kept, 300, recording=1)
    for _ in range(40):
        beat.cab.move(beat.wanted, 200)
    keeper.look()
    assert "too slow" in said[0]
    assert beat.wanted.recording == 0


def test_a_result_is_written_once(kept):
    beat, keeper, _ = kept
    go(kept, 1000, trial=TrialWish(1, "tracking", "S-1"), locked=False)
    go(kept, 1, trial=None)
    go(kept, 1)
    (result,) = read_results(keeper.folder)
    assert (result["subject"], result["exercise"], result["mode"], result["finished"]) == (
        "S-1",
        "tracking",
        "joint",
        False,
    )
    assert keeper.compared_results()["compared"] == []
    assert beat.wanted == Wanted(locked=False)


def test_a_drive_that_is_too_long_ends_where_it_can_still_be_read(kept, monkeypatch):
    beat, keeper, said = kept
    monkeypatch.setattr("polydraulic.cockpit.recorded.drives.MOST", 3000)
    go(kept, 300, recording=1)
    for k in range(100):
        go(kept, 10, locked=False, axes=(0.0, 0.0, 0.0, 0.01 * k, 0.0, 0.0))
    assert "record another one" in said[0]
    assert beat.wanted.recording == 0
    assert read_drive(keeper.folder / f"{keeper.drives[0]}{ENDING}").stamps
