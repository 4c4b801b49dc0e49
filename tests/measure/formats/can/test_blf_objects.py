"""Damage that ended in a reader that never comes to an end, or that leaves frames out without a word."""

import struct
import zlib

import can
import pytest

from helpers.can_made import bus, write_bus
from polydraulic.errors import InputError
from polydraulic.measure.formats.can.blf_objects import left_unread

HEAD = 144  # bytes of the file's head


def an_object(size=48, version=1, mark=b"LOBJ"):
    """Of a CAN frame of 8 bytes."""
    return struct.pack("<4sHHLL", mark, 32, version, size, 86) + bytes(32)


def container(content, packing=0, size=None):
    size = 32 + len(content) if size is None else size
    head = struct.pack("<4sHHLLH6xL4x", b"LOBJ", 16, 1, size, 10, packing, len(content))
    return head + content + bytes(size % 4)


def blf(tmp_path, *containers):
    path = tmp_path / "a.blf"
    content = b"".join(containers)
    head = struct.pack("<4sL8xQ", b"LOGG", HEAD, HEAD + len(content))
    path.write_bytes(head.ljust(HEAD, b"\0") + content)
    return path


@pytest.mark.parametrize("largest", [200, 128 * 1024])
@pytest.mark.parametrize("level", [-1, 0])
def test_files_of_python_can_are_whole(tmp_path, largest, level):
    frames = bus(50)
    with can.BLFWriter(tmp_path / "a.blf", compression_level=level, max_container_size=largest) as writer:
        for time, frame, extended, data in frames:
            writer.on_message_received(can.Message(1.7e9 + time, frame, extended, channel=0, data=data, dlc=len(data)))
    assert left_unread(tmp_path / "a.blf") == {}
    assert left_unread(write_bus(tmp_path / "b.blf", frames)) == {}


def test_objects_go_on_in_the_next_container(tmp_path):
    both = an_object() + an_object()
    assert left_unread(blf(tmp_path, container(both[:70]), container(both[70:]))) == {}
    assert left_unread(blf(tmp_path, container(zlib.compress(both), 2))) == {}
    assert left_unread(blf(tmp_path, container(both[:50]), container(both[50:90]))) == {
        "the end of the log": "its last object is not whole: the file is cut off or damaged"
    }


@pytest.mark.parametrize("size", [0, 15])
def test_objects_without_a_size_are_refused_before_they_are_read_for_ever(tmp_path, size):
    for content, packing in ((an_object(size), 0), (zlib.compress(an_object() + an_object(size)), 2)):
        with pytest.raises(
            InputError, match=r"cannot be read as a bus log \(an object has no size: the file is damaged"
        ):
            left_unread(blf(tmp_path, container(content, packing)))
    with pytest.raises(InputError, match="an object has no head"):
        left_unread(blf(tmp_path, container(an_object(), size=size)))


def test_objects_too_large_to_be_any_are_refused(tmp_path):
    """One would take all that follows for a part of itself; what unpacks to so much would fill the memory."""
    with pytest.raises(InputError, match="an object of more than 64 MB: the file is damaged"):
        left_unread(blf(tmp_path, container(an_object((1 << 26) + 1) + an_object())))
    with pytest.raises(InputError, match="an object of more than 64 MB"):
        left_unread(blf(tmp_path, container(b"", size=(1 << 26) + 1)))
    with pytest.raises(InputError, match="an object of more than 64 MB"):
        left_unread(blf(tmp_path, container(zlib.compress(bytes((1 << 26) + 1)), 2)))


def test_other_damage_is_one_error(tmp_path):
    with pytest.raises(InputError, match="does not begin like a BLF file"):
        left_unread(write_bus(tmp_path / "a.asc", bus(2)))
    with pytest.raises(InputError, match="an object has no head"):
        left_unread(blf(tmp_path, container(an_object() + an_object(mark=b"LOBI"))))
    with pytest.raises(InputError, match="cannot be read as a bus log .*decompress"):
        left_unread(blf(tmp_path, container(b"not packed", 2)))


def test_what_is_left_out_is_named(tmp_path):
    path = blf(tmp_path, container(an_object(version=3) + an_object()), container(an_object(), 7))
    assert left_unread(path) == {
        "1 object(s)": "with a head that is not known (version 3)",
        "1 container(s)": "packed in a way that is not known (7)",
    }
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[:-60])
    assert left_unread(path)["the end of the log"] == f"the file is cut off after {size - 60} of {size} bytes"
