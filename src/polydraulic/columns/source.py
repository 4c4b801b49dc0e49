"""The bytes of a text file, whatever its encoding and compression, as UTF-8; and what a look at all of them tells."""

import codecs
import gzip
import re
import zlib
from collections.abc import Iterator
from io import BufferedIOBase
from pathlib import Path
from typing import BinaryIO, NamedTuple, cast

from polydraulic.errors import InputError

CHUNK = 1 << 20  # bytes
HEAD = 1 << 16  # bytes that the first lines are looked for in
_LONGEST_HEAD = 1 << 22  # the same where lines are long
_LEAST_LINES = 4  # that are looked for
_BLANKS = re.compile(rb"[ \t]+")
_QUOTED = re.compile(rb'"[^"\r\n]*"|[ \t]+')  # what is quoted keeps its blanks
_RUN = re.compile(rb"\0+")
_CONTROL = re.compile(rb"[\x01-\x08\x0e-\x1f\x7f]")
_OTHER_FILES = {  # by how they begin
    b"\x1f\x8b": "it is packed by gzip: call it .csv.gz",
    b"PK\x03\x04": "it is a workbook or an archive: save the sheet as CSV, or unpack it",
    b"\xd0\xcf\x11\xe0": "it is a workbook: save the sheet as CSV",
    b"\x89HDF": "it is HDF5: a MAT file of version 7.3 ends in .mat",
    b"MDF     ": "it is MDF: call it .mf4",
    b"PAR1\x15": "it is Parquet: call it .parquet",
}
DAMAGED = (OSError, EOFError, zlib.error)  # what gzip raises on damaged files, and a disk


class Scan(NamedTuple):
    """What a first pass over all bytes found.

    `comma`, `point` and `quote` say whether these come at all after the first bytes; `head` is these, as UTF-8, and `cut` whether the
    file goes on behind them.
    """

    encoding: str
    head: bytes
    comma: bool
    point: bool
    quote: bool
    cut: bool


def scan_bytes(path: Path) -> Scan:
    """Look at all bytes of a file: its encoding, and which marks it holds.

    A letter of another encoding may come late, so that the lines at the beginning do not settle it.

    Raises
    ------
    InputError
        A file that cannot be read, is damaged, or is no text.
    """
    try:
        return _scan(path)
    except gzip.BadGzipFile as error:
        said = f"damaged, or not packed by gzip: {error}"
        raise InputError(f"{path}: cannot be read ({said}); copy it again, or call it .csv if it is text") from error
    except DAMAGED as error:
        damaged = f"damaged: {error}" if path.suffix == ".gz" else str(error)
        raise InputError(f"{path}: cannot be read ({damaged}); copy it again, or unpack what is left of it") from error


def _scan(path: Path) -> Scan:
    with _binary(path) as file:
        first = file.read(HEAD)
        while first.count(b"\n") + first.count(b"\r") < _LEAST_LINES and len(first) < _LONGEST_HEAD:
            more = file.read(HEAD)
            if not more:
                break
            first += more
        kind = next((kind for begin, kind in _OTHER_FILES.items() if first.startswith(begin)), "")
        if kind:
            raise InputError(f"{path}: is not text; a CSV log must be: {kind}")
        following = file.read(CHUNK)
        wide = _wide(first)
        if wide:
            try:
                head = b"".join(_narrow(iter([first[: len(first) // 4 * 4]]), wide))
            except UnicodeDecodeError as error:
                raise InputError(f"{path}: cannot be read as {wide} ({error.reason})") from error
            return Scan(wide, head, True, True, True, bool(following))
        if b"\0" in first:  # at the end they are what a logger that lost its power leaves
            first = first.rstrip(b"\0\r\n") + b"\n"
        if b"\0" in first and _lost_power(first):
            first = first.replace(b"\0", b" ")  # of the same length: rows begin where they did
        if b"\0" in first:
            raise InputError(f"{path}: is not text; a CSV log must be")
        marks = dict.fromkeys((b",", b".", b'"'), False)
        utf8, pending, windows = codecs.getincrementaldecoder("utf-8")(), False, False
        valid, chunk = True, first
        while chunk:
            if not chunk.isascii() or pending:
                try:
                    if valid:
                        utf8.decode(chunk)
                        pending = bool(utf8.getstate()[0])
                except UnicodeDecodeError:
                    valid = False
                windows = windows or any(byte in chunk for byte in _WINDOWS)
            if chunk is not first:
                for mark, seen in marks.items():
                    marks[mark] = seen or mark in chunk
            chunk = following if chunk is first else file.read(CHUNK)
        valid = valid and not pending
    encoding = "utf-8" if valid else "cp1252" if windows else "latin-1"
    head = first if valid else b"".join(_narrow(iter([first]), encoding))
    return Scan(encoding, head, marks[b","], marks[b"."], marks[b'"'], bool(following))


_WINDOWS = [bytes([n]) for n in (0x80, 0x82, 0x84, 0x85, 0x89, 0x91, 0x92, 0x93, 0x94, 0x96, 0x97)]


def _lost_power(first: bytes) -> bool:
    """Whether zeros stand between rows of a text: one run in a line, none in the first, and no other control characters of binary files."""
    lines = first.strip().splitlines()
    return b"\0" not in lines[0] and not _CONTROL.search(first) and all(len(_RUN.findall(line)) < 2 for line in lines)


def _wide(first: bytes) -> str:
    """UTF-32 by its mark; UTF-16 by its mark, or by the zeros in every other byte of its first line."""
    if first.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        return "utf-32"
    if first.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    start = first[:64]
    half = len(start) // 2
    if half > 3 and start[1::2].count(0) > 0.9 * half and 0 not in start[::2]:
        return "utf-16-le"
    if half > 3 and start[::2].count(0) > 0.9 * half and 0 not in start[1::2]:
        return "utf-16-be"
    return ""


def _binary(path: Path) -> BinaryIO:
    return cast(BinaryIO, gzip.open(path)) if path.suffix == ".gz" else path.open("rb")


def _narrow(chunks: Iterator[bytes], encoding: str) -> Iterator[bytes]:
    decoder = codecs.getincrementaldecoder(encoding)("strict" if encoding.startswith("utf") else "replace")
    for chunk in chunks:
        yield decoder.decode(chunk).encode()
    yield decoder.decode(b"", final=False).encode()


class Source(BufferedIOBase):
    """A text file as UTF-8 from a byte on (of its UTF-8), read piece by piece; runs of blanks are one tab if asked for."""

    def __init__(self, path: Path, encoding: str, begin: int, blanks: bool) -> None:
        self._raw = path.open("rb")
        self._file = cast(BinaryIO, gzip.GzipFile(fileobj=self._raw)) if path.suffix == ".gz" else self._raw
        self._size = max(1, path.stat().st_size)
        chunks = iter(lambda: self._file.read(CHUNK), b"")
        self._chunks = chunks if encoding == "utf-8" else _narrow(chunks, encoding)
        self._held = b""
        while begin > len(self._held):
            begin -= len(self._held)
            self._held = next(self._chunks)
        self._held = self._held[begin:]
        if blanks:
            self._chunks = _tabs(self._held, self._chunks)
            self._held = b""

    @property
    def share(self) -> float:
        """How much of the file has been read, 0 to 1."""
        return min(1.0, self._raw.tell() / self._size)

    def readable(self) -> bool:
        """Return True."""
        return True

    def read(self, size: int | None = -1) -> bytes:
        """Return the next bytes, `size` of them unless the file ends."""
        parts, count = [self._held], len(self._held)
        while (size is None or size < 0 or count < size) and (chunk := next(self._chunks, b"")):
            parts.append(chunk)
            count += len(chunk)
        got = b"".join(parts)
        end = count if size is None or size < 0 else size
        self._held = got[end:]
        return got[:end]

    def lines(self, size: int) -> Iterator[bytes]:
        """Blocks of whole lines, of about `size` bytes each.

        Raises
        ------
        EOFError
            If a line is longer than that.
        """
        rest, block = b"", self.read(size)
        while block:
            following = self.read(size)
            end = max(block.rfind(b"\n"), block.rfind(b"\r")) + 1 if following else len(block)
            if not end:
                raise EOFError(f"a line is longer than {size} bytes")
            yield rest + block[:end]
            rest, block = block[end:], following

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        self._raw.close()
        super().close()


def _tab_or_quoted(found: re.Match[bytes]) -> bytes:
    return found[0] if found[0].startswith(b'"') else b"\t"


def _tabs(held: bytes, chunks: Iterator[bytes]) -> Iterator[bytes]:
    """Lines whose runs of blanks are one tab, and none at their ends."""
    rest = held
    while True:
        chunk = next(chunks, b"")
        block, newline, rest = (rest + chunk).rpartition(b"\n") if chunk else (rest, b"", b"")
        whole = block + newline
        tabbed = _BLANKS.sub(b"\t", whole) if b'"' not in whole else _QUOTED.sub(_tab_or_quoted, whole)
        tabbed = tabbed.replace(b"\n\t", b"\n").replace(b"\t\r\n", b"\r\n").replace(b"\t\n", b"\n")
        if tabbed:
            yield tabbed.removeprefix(b"\t")
        if not chunk:
            return
