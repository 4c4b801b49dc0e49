import json
import struct

import pytest

from polydraulic.cockpit.protocol import MOST_BYTES, frame, read_message
from polydraulic.errors import InputError

STICKS = {"type": "sticks", "seq": 3, "axes": [0, 0.5, -1, 0, 0, 0]}


def test_sticks_beyond_their_ends_are_at_their_ends():
    assert read_message(json.dumps(STICKS)) == ("sticks", {"seq": 3, "axes": (0.0, 0.5, -1.0, 0.0, 0.0, 0.0)})
    far = read_message(json.dumps(STICKS | {"axes": [7, -7, 0, 0, 0, 0]}))
    assert far.fields["axes"][:2] == (1.0, -1.0)


def test_a_frame_has_the_places_that_are_written_down():
    packed = frame(7, 9, 1.25, 11, 5, struct.pack("<2f", 0.5, -2.0))
    assert struct.unpack_from("<II", packed, 0) == (7, 9)
    assert struct.unpack_from("<d", packed, 8) == (1.25,)
    assert struct.unpack_from("<II", packed, 16) == (11, 5)
    assert struct.unpack_from("<2f", packed, 24) == (0.5, -2.0)
    assert struct.unpack_from("<I", frame(2**32 + 1, 0, 0.0, 2**40, 0, b""), 0) == (1,)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "no JSON"),
        ("[" * 4000, "no JSON"),
        ("[]", "type None"),
        ('{"type": "fly"}', "'fly'"),
        ('{"type": ["sticks"]}', "must be one of"),
        ('{"type": "sticks", "seq": 1}', "'axes' is missing"),
        ('{"type": "sticks", "seq": 1, "axes": [0, 0, 0, 0, 0]}', "list of 6"),
        ('{"type": "sticks", "seq": 1, "axes": [0, 0, 0, 0, 0, NaN]}', "no JSON"),
        ('{"type": "sticks", "seq": 1, "axes": [0, 0, 0, 0, 0, 1e999]}', "finite"),
        ('{"type": "sticks", "seq": 1, "axes": [0, 0, 0, 0, 0, 1' + 400 * "0" + "]}", "finite"),
        ('{"type": "sticks", "seq": 1, "axes": [0, 0, 0, 0, 0, true]}', "finite"),
        ('{"type": "sticks", "seq": -1, "axes": [0, 0, 0, 0, 0, 0]}', "whole number"),
        ('{"type": "sticks", "seq": 1.5, "axes": [0, 0, 0, 0, 0, 0]}', "whole number"),
        ('{"type": "lock", "on": 1}', "true or false"),
        ('{"type": "lock", "on": true, "more": 1}', "unknown field"),
        ('{"type": "mode", "mode": "joint", "pattern": "cat"}', "iso"),
        ('{"type": "payload", "mass": -1}', "negative"),
        ('{"type": "replay", "name": "' + 65 * "x" + '", "action": "play"}', "64 letters"),
        ('{"type": "replay", "name": "a\\u0000", "action": "play"}', "64 letters"),
        ('{"type": "reset", "x": "' + MOST_BYTES * "x" + '"}', "longer than"),
    ],
)
def test_whatever_is_no_message_is_refused(text, says):
    with pytest.raises(InputError, match=says):
        read_message(text)
