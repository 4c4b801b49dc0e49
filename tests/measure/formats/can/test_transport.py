"""Messages of J1939 that need several frames."""

import numpy as np
import pytest

from helpers.can_made import LONG, LONG_GROUP, in_parts, long_message, write_bus
from polydraulic.errors import InputError
from polydraulic.measure import open_log
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.can.frames import LONGEST, BusFrames
from polydraulic.measure.formats.can.transport import Transport


def sent(n=30, **changes):
    return [in_parts(0.1 * k, LONG_GROUP, long_message(k), **changes) for k in range(n)]


def flat(messages):
    return [frame for frames in messages for frame in frames]


def read(folder, frames, ending="blf"):
    """Times and values of the two signals, and what was left out."""
    (folder / "long.dbc").write_text(LONG)
    path = write_bus(folder / f"bus.{ending}", sorted(frames, key=lambda frame: frame[0]))
    with open_log(path, dbc=[folder / "long.dbc"]) as log:
        (block,) = log.read(log.signal("first").group, ["first", "last"], None, Findings())
        return block.time, block.values, log.left_out


@pytest.mark.parametrize("ending", ["blf", "asc", "mf4"])
@pytest.mark.parametrize("changes", [{}, {"kind": 16, "destination": 7}])
def test_messages_are_put_together(tmp_path, ending, changes):
    answers = [(0.1 * k + 0.0005, 0x1CEC0307, True, bytes([17, 3, 1, 255, 255, 0x0F, 0xFF, 0])) for k in range(30)]
    time, values, left_out = read(tmp_path, flat(sent(**changes)) + answers * ("kind" in changes), ending)
    assert values["first"] == pytest.approx(0.1 * np.arange(30))
    assert values["last"].tolist() == list(range(30))
    assert np.diff(time) == pytest.approx(np.full(29, 0.1), abs=2e-6)  # of the last frame of each
    assert left_out == {}


def test_messages_of_several_senders_may_overlap(tmp_path):
    two = [(t, i + 1, e, d) for t, i, e, d in flat(sent())]  # the next address
    (tmp_path / "long.dbc").write_text(LONG)
    path = write_bus(tmp_path / "bus.blf", sorted([*flat(sent()), *two[:60]], key=lambda frame: frame[0]))
    with open_log(path, dbc=[tmp_path / "long.dbc"]) as log:
        for name, n in (("Long@0x03/last", 30), ("Long@0x04/last", 15)):
            (block,) = log.read(log.signal(name).group, [name], None, Findings())
            assert block.values[name].tolist() == list(range(n))


def test_frames_that_are_lost_end_their_message_alone(tmp_path):
    messages = sent(6)
    del messages[1][2]  # one of its data
    del messages[2][0]  # its announcement
    messages[3] = messages[3][:2]  # broken off
    messages[4] = [
        (t + (2.0 if n == 3 else 0.0), *rest) for n, (t, *rest) in enumerate(messages[4])
    ]  # a pause too long
    messages[5] = [(t + 3.0, *rest) for t, *rest in messages[5]]
    _, values, left_out = read(tmp_path, flat(messages))
    assert values["last"].tolist() == [0, 5]
    assert left_out == {
        "PGN 0xff0f (65295): 3 message(s)": "messages of several frames, not all of which are in the log",
        "3 frame(s) of messages of several frames": "their announcement is not in the log",
    }


@pytest.mark.parametrize(("late", "kept"), [(1.24, [0, 1]), (1.26, [1])])
def test_frames_of_a_message_are_at_most_a_second_and_a_quarter_apart(tmp_path, late, kept):
    first, second = sent(2)
    pause = late - (first[2][0] - first[1][0])
    first[2:] = [(t + pause, *rest) for t, *rest in first[2:]]
    second = [(t + 5.0, *rest) for t, *rest in second]
    assert read(tmp_path, flat([first, second]))[1]["last"].tolist() == kept


def test_groups_that_no_database_knows_are_named_and_their_frames_are_none_of_their_own(tmp_path):
    others = in_parts(0.55, 0xFEEC, b"VIN of a machine*")
    _, values, left_out = read(tmp_path, flat(sent(3)) + others)
    assert values["last"].tolist() == [0, 1, 2]
    assert left_out == {"PGN 0xfeec (65260)": "messages of several frames that no database knows"}
    (tmp_path / "bus.dbc").write_text(LONG)
    path = write_bus(tmp_path / "vin.blf", others)
    with pytest.raises(InputError, match=r"no frame that bus.dbc knows; identifiers of the log: PGN 0xfeec \(65260\)"):
        open_log(path, dbc=[tmp_path / "bus.dbc"])


def test_a_message_to_one_keeps_its_destination_and_may_be_broken_off():
    def split(frames):
        n = len(frames)
        data = np.zeros((n, LONGEST), dtype=np.uint8)
        for row, frame in enumerate(frames):
            data[row, :8] = np.frombuffer(frame[3], dtype=np.uint8)
        columns = np.array([f[0] for f in frames]), np.zeros(n, dtype=int), np.array([f[1] for f in frames])
        return Transport().split(BusFrames(*columns, np.ones(n, dtype=bool), np.full(n, 8), data, 0.0))

    request = in_parts(0.0, 0xEF00, bytes(range(30)), source=3, destination=7, kind=16)
    alone, (whole,) = split([*request, (1.0, 0x18FEF103, True, bytes(8))])
    assert alone.tolist() == [False] * len(request) + [True]
    assert (whole.frame, whole.data, whole.time) == (0x18EF0703, bytes(range(30)), 0.005)
    again = [*request[:3], request[2], *request[3:]]  # sent once more, as the receiver asked
    assert split(again)[1][0].data == bytes(range(30))
    abort = (0.0025, 0x1CEC0307, True, bytes([255, 1, 255, 255, 255, 0, 0xEF, 0]))
    assert split([*request[:3], abort, *request[3:]])[1] == []
