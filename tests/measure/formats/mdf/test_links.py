import io
import struct

import numpy as np

from polydraulic.measure.formats.mdf.links import circular


def blocks(*links, first=96):
    """A file of blocks of channel groups at 96, 136, ...: each with its next one and its first channel."""
    made = [struct.pack("<4sI4Q", b"##CG", 0, 40, 2, *pair) for pair in links]
    return io.BytesIO(bytes(88) + struct.pack("<Q", first) + b"".join(made))


def test_lists_that_end_and_lists_that_do_not():
    assert not circular(blocks((136, 0), (176, 0), (0, 0)))
    assert circular(blocks((136, 0), (176, 0), (96, 0)))
    assert circular(blocks((96, 0)))
    assert circular(blocks((136, 176), (176, 0), (0, 0)))  # two lists run into one
    assert not circular(blocks((1 << 63, (1 << 64) - 1)))  # beyond the end
    assert not circular(blocks((0, 0), first=0))
    assert not circular(io.BytesIO(b"MDF"))


def test_links_beyond_the_end_of_a_real_file_are_not_followed(tmp_path):
    (tmp_path / "a.mf4").write_bytes(blocks(((1 << 64) - 1, 1 << 62)).getvalue())
    with (tmp_path / "a.mf4").open("rb") as raw:
        assert not circular(raw)


def test_files_of_asammdf_end(tmp_path):
    from asammdf import MDF, Signal

    time = np.arange(10) * 0.1
    with MDF(version="4.10") as file:
        for _ in range(3):
            file.append([Signal(time, time, "V", name) for name in "ab"], common_timebase=True)
        path = file.save(tmp_path / "a.mf4", compression=2)
    with path.open("rb") as raw:
        assert not circular(raw)
