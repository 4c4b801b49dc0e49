"""What page and server say to each other.

``GET /?token=T`` gives a cookie and leads to ``/``, the page; ``/page/NAME`` are its files; ``/machine.json`` describes the machine
(`description`); ``/results.json`` what was achieved in exercises. All of them, and the websocket ``/live``, want the cookie.

Frames, to the page, 60 a second: binary, little endian, `HEAD` and then as many float32 as ``columns`` of ``/machine.json`` says, in SI::

    0  uint32   number of the frame
    4  uint32   `seq` of the last sticks that were applied before the last step (0: none)
    8  float64  simulated time in s
    16 uint32   overruns: steps that were given up because they came too late
    20 uint32   flags, see `Flag`
    24 float32  values

Texts, to the page, when something changes (JSON)::

    {"type": "status", "driver": "you|other|nobody", "locked", "mode", "pattern", "recording": name or null, "faults": [names],
     "guard": whether tips are guarded against, "shadow": why it is lost, or "", "exercise": {"name", "subject"} or null, "replay": {"name", "time", "end", "playing"} or null,
     "study": null or {"title", "subjects", "subject", "task": null or {"number", "block", "practice", "exercise", "mode", "repetition"}, "tasks",
     "question": "" before all is done, "answers", "answer"}, "recordings": [names], "payload": kg,
     "rate": simulated seconds for each of the last second}
    {"type": "events", "events": [[time in s, function or circuit, what], ...]}
    {"type": "score", "exercise", "subject", "running": bool, "finished": bool, "values": {name: [value, unit]}}   ten times a second
        of "time", "error_rms", "error_max", "effort", "stops", and "energy" of the pumps or, where their pressures are not known,
        "actuator_energy"
    {"type": "error", "text"}

Texts, from the page, at most `MOST_BYTES` long::

    {"type": "sticks", "seq": n, "axes": [lx, ly, rx, ry, a5, a6]}   -1..1; right and forward are positive. While levers are not neutral
        they are to be sent at least every `SILENCE` s, or the machine takes them for released; while they are, once a second.
    {"type": "lock", "on": bool}
    {"type": "mode", "mode": "joint|coordinated", "pattern": "iso|sae"}   coordinated: left stick swing and reach, right one pitch and height
    {"type": "guard", "on": bool}                                    coordinated mode: slow, and refuse, what would tip the machine
    {"type": "drive"}                                                ask to be the driver; all below and above is for the driver alone
    {"type": "reset"}
    {"type": "payload", "mass": kg}
    {"type": "record", "on": bool}
    {"type": "fault", "name", "on": bool}
    {"type": "exercise", "name", "action": "start|stop", "subject": code}
    {"type": "study", "action": "subject|start|skip|answer", "text"}   text: code of the subject, or the answer
    {"type": "replay", "name", "action": "play|pause|seek|restart|stop", "time": s}   restart: go on by hand from where the replay is

A message that is anything else is answered by an error, and changes nothing.
"""

import json
from collections.abc import Callable
from enum import IntFlag
from math import isfinite
from struct import Struct
from typing import Any, NamedTuple, NoReturn

from polydraulic.errors import InputError, briefly

HEAD = Struct("<IIdII")
FRAMES = 60  # a second
MOST_BYTES = 4096
N_AXES = 6
SILENCE = 0.25  # s without sticks until levers are released
_LARGEST = 2**32 - 1
_LONGEST, _LONGEST_TEXT = 64, 200  # letters of a name, and of an answer


class Flag(IntFlag):
    """Conditions of a frame."""

    LOCKED = 1
    DRIVER = 2  # who gets the frame drives
    RELIEF = 4  # of a pump
    STOP = 8  # a joint is at its end
    OUTSIDE = 16  # steps outside the domain of the flow model, or of the shadow's
    RECORDING = 32
    REPLAY = 64
    TARGET = 128  # there is a target: `target.x`, `.y`, `.z`
    TIPPING = 256  # the machine tips, or a tip is foreseen to within 2 s
    GUARDED = 512  # the guard against tipping slows or refuses what the sticks ask for


class PageMessage(NamedTuple):
    """What a page said: which type, and its fields, checked."""

    type: str
    fields: dict[str, Any]


def read_message(text: str) -> PageMessage:
    """Read a message of a page.

    Parameters
    ----------
    text : str
        JSON.

    Raises
    ------
    InputError
        Anything but one of the messages above, with all its fields and no others.
    """
    if len(text.encode("utf-8", "replace")) > MOST_BYTES:
        raise InputError(f"a message is longer than {MOST_BYTES} bytes")
    try:
        found = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise InputError(f"a message is no JSON: {briefly(text)}") from error
    kind = found.get("type") if isinstance(found, dict) else None
    if not isinstance(kind, str) or kind not in _FIELDS:
        raise InputError(f"a message of type {briefly(kind)}: must be one of {list(_FIELDS)}")
    fields = _FIELDS[kind]
    optional = _OPTIONAL.get(kind, set())
    given = {key: value for key, value in found.items() if key != "type"}
    for key in given:
        if key not in fields:
            raise InputError(f"{kind}: unknown field {briefly(key)}; it has {list(fields)}")
    for key in fields:
        if key not in given and key not in optional:
            raise InputError(f"{kind}: the field {key!r} is missing")
    return PageMessage(kind, {key: fields[key](given[key], f"{kind}: {key}") for key in given})


def frame(number: int, seq: int, time: float, overruns: int, flags: int, values: bytes) -> bytes:
    """One frame, `values` as float32."""
    return HEAD.pack(number & _LARGEST, seq, time, min(overruns, _LARGEST), flags) + values


def _no_number(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number of JSON")


def _number(value: Any, what: str) -> float:
    try:
        found = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else float("nan")
    except OverflowError:
        found = float("inf")
    if not isfinite(found):
        raise InputError(f"{what} = {briefly(value)}: must be a finite number")
    return found


def _axes(value: Any, what: str) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != N_AXES:
        raise InputError(f"{what} = {briefly(value)}: must be a list of {N_AXES} numbers")
    return tuple(min(max(_number(x, what), -1.0), 1.0) for x in value)


def _count(value: Any, what: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= _LARGEST:
        raise InputError(f"{what} = {briefly(value)}: must be a whole number from 0 to {_LARGEST}")
    return value


def _switch(value: Any, what: str) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"{what} = {briefly(value)}: must be true or false")
    return value


def _name(value: Any, what: str) -> str:
    if not isinstance(value, str) or len(value) > _LONGEST or not value.isprintable():
        raise InputError(f"{what} = {briefly(value)}: must be a name of at most {_LONGEST} letters")
    return value


def _text(value: Any, what: str) -> str:
    if not isinstance(value, str) or len(value) > _LONGEST_TEXT or not value.isprintable():
        raise InputError(f"{what} = {briefly(value)}: must be a text of at most {_LONGEST_TEXT} letters")
    return value


def _amount(value: Any, what: str) -> float:
    if (found := _number(value, what)) < 0.0:
        raise InputError(f"{what} = {briefly(value)}: must not be negative")
    return found


def _one_of(*words: str) -> Callable[[Any, str], str]:
    def check(value: Any, what: str) -> str:
        if not isinstance(value, str) or value not in words:
            raise InputError(f"{what} = {briefly(value)}: must be one of {list(words)}")
        return value

    return check


_OPTIONAL = {"replay": {"time"}, "exercise": {"subject"}, "study": {"text"}}
_FIELDS: dict[str, dict[str, Callable[[Any, str], Any]]] = {
    "sticks": {"seq": _count, "axes": _axes},
    "lock": {"on": _switch},
    "mode": {"mode": _one_of("joint", "coordinated"), "pattern": _one_of("iso", "sae")},
    "guard": {"on": _switch},
    "drive": {},
    "reset": {},
    "payload": {"mass": _amount},
    "record": {"on": _switch},
    "fault": {"name": _name, "on": _switch},
    "study": {"action": _one_of("subject", "start", "skip", "answer"), "text": _text},
    "exercise": {"name": _name, "action": _one_of("start", "stop"), "subject": _name},
    "replay": {"name": _name, "action": _one_of("play", "pause", "seek", "restart", "stop"), "time": _amount},
}
