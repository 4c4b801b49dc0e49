"""CAN databases (DBC): which message an identifier stands for, and which signals are in it."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.formats.can.bits import Field, as_number, unsigned
from polydraulic.measure.formats.status_text import StatusText, states
from polydraulic.measure.log_units import need

_PDU2 = 240  # from this format on a J1939 group has no destination in its identifier
_LONGEST = 4095  # bytes of a message that a transport protocol carries (ISO 15765-2; of J1939 1785)
_MOST_VALUES = 1 << 16  # of a multiplexer, in one range
_REALS = (16, 32, 64)  # bits of numbers of IEEE 754
_SIZES = (  # numbers that cantools makes lists of so many parts of, and the most that are any
    (re.compile(r"^\s*BO_\s+\d+\s+(\w+)\s*:\s*(\d+)", re.MULTILINE), "message {} has {} bytes", _LONGEST),
    (re.compile(r"^\s*SG_\s+(\w+)[^:\n]*:\s*(\d+)\|", re.MULTILINE), "signal {} begins at bit {}", 8 * _LONGEST),
    (re.compile(r"^\s*SG_\s+(\w+)[^:\n]*:\s*\d+\|(\d+)", re.MULTILINE), "signal {} has {} bits", 8 * _LONGEST),
)
_RANGES = re.compile(r"^\s*SG_MUL_VAL_\s+\d+\s+(\w+)\s+\w+\s+([^;]*);", re.MULTILINE)
_RANGE = re.compile(r"(\d+)\s*-\s*(\d+)")
ERROR, NOT_AVAILABLE, RESERVED, SPECIFIC = "error", "not available", "reserved", "parameter specific"


class Selection(NamedTuple):
    """A multiplexer, and those of its values with which a signal is there."""

    field: Field
    values: tuple[int, ...]


@dataclass(frozen=True)
class CanSignal:
    """A signal of a message.

    Attributes
    ----------
    name, unit : str
    field : Field
    signed, real : bool
    scale, offset : float
    selections : tuple of Selection
        All must hold for the signal to be in a frame; empty where it always is.
    codes : tuple of StatusText
        Raw values that are none, with what they say.
    """

    name: str
    unit: str
    field: Field
    signed: bool
    real: bool
    scale: float
    offset: float
    selections: tuple[Selection, ...]
    codes: tuple[StatusText, ...]

    def values(self, data: np.ndarray, length: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]:
        """Physical values of frames.

        Parameters
        ----------
        data : (n, n_byte) array of uint8
        length : (n,) array of int
            Bytes that each frame has.

        Returns
        -------
        values : (n,) array
            NaN where there is none.
        said : dict from str to array of int
            Places of codes that say why.
        short : array of int
            Places of frames that end before the signal does.
        """
        short = length < self.field.n_byte
        if self.field.n_byte > data.shape[1]:
            return np.full(len(data), np.nan), {}, np.flatnonzero(short)
        number = as_number(unsigned(data, self.field), self.field.length, signed=self.signed, real=self.real)
        values = np.where(short, np.nan, self.scale * number + self.offset)
        said: dict[str, np.ndarray] = {}
        for low, high, text in self.codes:
            there = (number >= low) & (number <= high) & ~short
            if there.any():
                values[there] = np.nan
                said[text] = np.union1d(said.get(text, []), np.flatnonzero(there)).astype(np.int64)
        return values, said, np.flatnonzero(short)


@dataclass(frozen=True)
class Message:
    """A message of a database: its signals, its length in bytes, the file that it is from, and why other signals are not numbers."""

    name: str
    length: int
    j1939: bool
    signals: tuple[CanSignal, ...]
    source: Path
    left_out: dict[str, str] = field(default_factory=dict)


class Messages:
    """Messages by identifier; those of J1939 by their group, whatever priority and sender."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self.exact: dict[tuple[int, bool], Message] = {}
        self.groups: dict[int, Message] = {}
        for path in paths:
            for frame, extended, message in _read(path):
                other = self.exact.get((frame, extended))
                if other is not None and other.signals != message.signals:
                    raise InputError(
                        f"{path}: message {message.name!r} has the identifier {frame:#x} of {other.name!r} in {other.source}; "
                        "give databases of one bus"
                    )
                self.exact[frame, extended] = message
                if message.j1939 and extended:
                    self.groups.setdefault(parameter_group(frame), message)

    def find(self, frame: int, extended: bool) -> Message | None:
        """Return the message of an identifier, if there is one."""
        found = self.exact.get((frame, extended))
        return found or (self.groups.get(parameter_group(frame)) if extended else None)


def parameter_group(frame: int) -> int:
    """Group of a J1939 identifier: without priority and sender, and without destination where it has one."""
    group = (frame >> 8) & 0x3FFFF
    return group if (group >> 8) & 0xFF >= _PDU2 else group & 0x3FF00


def j1939_codes(length: int) -> list[StatusText]:
    """Raw values of J1939 that stand for no value, by the number of bits."""
    if length in (2, 4, 10):
        top = 2**length - 1
        return [StatusText(top - 1, top - 1, ERROR), StatusText(top, top, NOT_AVAILABLE)]
    if length == 8 or 12 <= length <= 32:
        step = 2 ** (length - 8)  # what the highest byte says
        of_byte = ((251, 252, SPECIFIC), (252, 254, RESERVED), (254, 255, ERROR), (255, 256, NOT_AVAILABLE))
        return [StatusText(low * step, high * step - 1, text) for low, high, text in of_byte]
    return []


def _without(code: StatusText, named: Sequence[float]) -> list[StatusText]:
    """What is left of a range of raw values without those that a database names, which rise."""
    found, low = [], code.low
    for value in [value for value in named if code.low <= value <= code.high]:
        found += [StatusText(low, value - 1, code.text)] if value > low else []
        low = value + 1
    return found + ([StatusText(low, code.high, code.text)] if low <= code.high else [])


def _read(path: Path) -> list[tuple[int, bool, Message]]:
    cantools = need("cantools", "can")
    if path.suffix.lower() != ".dbc":
        raise InputError(f"{path}: a CAN database ends in .dbc")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:  # what most tools write
        text = content.decode("cp1252", "replace")
    _check_sizes(text, path)
    try:
        database = cantools.database.load_string(text, database_format="dbc", strict=False)
        protocol = database.dbc.attributes.get("ProtocolType") if database.dbc else None
        bus = protocol is not None and str(protocol.value).upper().startswith("J1939")
        return [
            (int(m.frame_id), bool(m.is_extended_frame), _message(m, path, bus))
            for m in database.messages
            if m.name != "VECTOR__INDEPENDENT_SIG_MSG"  # signals that are in no message
        ]
    except Exception as error:  # cantools raises errors of many kinds
        raise InputError(f"{path}: cannot be read as a CAN database ({error})") from error


def _check_sizes(text: str, path: Path) -> None:
    """Refuse numbers of which cantools would fill the memory."""
    for pattern, what, most in _SIZES:
        for name, number in pattern.findall(text):
            if len(number) > 9 or int(number) > most:
                raise InputError(f"{path}: {what.format(repr(name), number[:20])}; at most {most}: the file is damaged")
    for name, ranges in _RANGES.findall(text):
        for low, high in _RANGE.findall(ranges):
            if len(high) > 20 or int(high) - int(low[:20]) >= _MOST_VALUES:
                raise InputError(
                    f"{path}: signal {name!r} is there for multiplexer values from {low[:20]} to {high[:20]}; a range holds at most "
                    f"{_MOST_VALUES} values: the file is damaged"
                )


def _message(message: Any, path: Path, bus: bool) -> Message:
    """Take a message over; on a bus of J1939 those with long identifiers are of it, unless they say otherwise themselves."""
    by_name = {signal.name: signal for signal in message.signals}
    own = message.dbc is not None and "VFrameFormat" in message.dbc.attributes
    j1939 = message.protocol == "j1939" or (bus and bool(message.is_extended_frame) and not own)
    left_out = {signal.name: reason for signal in message.signals if (reason := _no_number(signal, by_name))}
    signals = tuple(_signal(signal, by_name, j1939) for signal in message.signals if signal.name not in left_out)
    return Message(message.name, int(message.length), j1939, signals, path, left_out)


def _no_number(signal: Any, by_name: dict[str, Any]) -> str:
    """Why a signal, or a multiplexer that it depends on, is no number; empty if it is one."""
    for one in _chain(signal, by_name):
        of = "" if one is signal else f"its multiplexer {one.name!r} "
        if one.length > 64:
            return f"{of}has {one.length} bits, as a text has; a number has at most 64"
        if one.is_float and one.length not in _REALS:
            return f"{of}is a real number of {one.length} bits; there are those of 16, 32 and 64"
    if not (isfinite(signal.scale) and isfinite(signal.offset)):
        return f"its factor {signal.scale:g} or offset {signal.offset:g} is no finite number"
    return ""


def _chain(signal: Any, by_name: dict[str, Any]) -> list[Any]:
    """The signal, its multiplexer, the multiplexer of that one."""
    found = [signal]
    while (above := found[-1].multiplexer_signal) and len(found) <= len(by_name):
        found.append(by_name[above])
    return found


def _signal(signal: Any, by_name: dict[str, Any], j1939: bool) -> CanSignal:
    chain = _chain(signal, by_name)
    selections = [
        Selection(_field(above), tuple(int(v) for v in below.multiplexer_ids or ())) for below, above in pairwise(chain)
    ]
    unit, length = str(signal.unit or "").strip(), int(signal.length)
    texts = [StatusText(float(value), float(value), str(text)) for value, text in (signal.choices or {}).items()]
    scaled = bool(unit) or (float(signal.scale), float(signal.offset)) != (1.0, 0.0)
    kept = states(texts, scaled=scaled, bits=length)
    codes = [t for t, number in zip(texts, kept, strict=True) if not number]
    if signal.is_multiplexer:
        codes = []
    elif j1939 and not (signal.is_signed or signal.is_float):
        named = sorted(t.low for t, number in zip(texts, kept, strict=True) if number)
        codes += [piece for code in j1939_codes(length) for piece in _without(code, named)]
    return CanSignal(
        signal.name, unit, _field(signal), bool(signal.is_signed), bool(signal.is_float), float(signal.scale),
        float(signal.offset), tuple(reversed(selections)), tuple(codes),
    )  # fmt: skip


def _field(signal: Any) -> Field:
    return Field(int(signal.start), int(signal.length), signal.byte_order == "big_endian")
