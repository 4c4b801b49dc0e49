"""The blocks of an MDF 4 file, followed once before asammdf follows them: of a damaged file it may never come to an end."""

import struct
from io import SEEK_END
from typing import BinaryIO

_FIRST = 64 + 24  # place of the link to the first group of data
# which links of a block lead to blocks that belong to it alone: the next of its list, and what it is made of
_OWN = {b"##DG": (0, 1, 2), b"##CG": (0, 1), b"##CN": (0, 1), b"##CA": (0,), b"##DL": (0,), b"##HL": (0,)}


def circular(file: BinaryIO) -> bool:
    """Whether some list of blocks comes back to itself, or two lists run into one.

    Parameters
    ----------
    file : binary file
        Of MDF 4; read from wherever it is.
    """
    size = file.seek(0, SEEK_END)
    file.seek(_FIRST)
    waiting, seen = list(_numbers(file.read(8))), set()
    while waiting:
        at = waiting.pop()
        if not 0 < at < size:  # the end of a list, or damage of another kind
            continue
        if at in seen:
            return True
        seen.add(at)
        file.seek(at)
        head = file.read(24)
        own = _OWN.get(head[:4])
        if own is None or len(head) < 24:
            continue
        count = min(_numbers(head[16:])[0], 1 + max(own))
        links = _numbers(file.read(8 * count))
        waiting += [links[place] for place in own if place < len(links)]
    return False


def _numbers(content: bytes) -> tuple[int, ...]:
    whole = len(content) // 8
    return struct.unpack(f"<{whole}Q", content[: 8 * whole])
