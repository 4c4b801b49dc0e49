"""What a recorded drive consists of: how the machine was at its beginning, and stamps of all that was done to it at which step.

A tape is text, line by line: what is written is whole up to its last line however the program ends. Steps that were not made leave no trace.
"""

import hashlib
import json
from base64 import b64decode, b64encode
from collections.abc import Mapping
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.simulation.stepping.saved import SavedState
from polydraulic.simulation.stepping.simulator import Simulator

FORM = "polydraulic drive 1"
BLOCK = 200  # steps, after which a block is handed over
MOST_BLOCKS = 30  # that wait to be written
_CHECKED = 2000  # steps between hashes of the state


class Tape:
    """Stamps of a drive, as they come.

    Parameters
    ----------
    number : int
        Of the drive.
    head : dict
        See `head_of`.

    Attributes
    ----------
    step : int
        Since the beginning.
    blocks : tuple of str
        The last ones that are complete; `first` is the number of the first of them.
    """

    def __init__(self, number: int, head: Mapping[str, Any]) -> None:
        self.number, self.step, self.first, self.ended = number, 0, 0, False
        self.blocks: tuple[str, ...] = ()
        self._lines = [json.dumps(head)]
        self._begun, self._levers = 0, b""

    def put(self, **what: Any) -> None:
        """Stamp something that acts from this step on."""
        self._lines.append(json.dumps({"step": self.step, **what}))

    def levers(self, volts: np.ndarray) -> None:
        """Stamp the levers, if they have moved."""
        bits = volts.tobytes()
        if bits != self._levers:
            self._levers = bits
            self.put(levers=volts.tolist())

    def made(self, n: int, simulator: Simulator) -> None:
        """Go on by steps that were made."""
        before, self.step = self.step, self.step + n
        if before // _CHECKED != self.step // _CHECKED:
            self.put(hash=state_hash(simulator))
        if self.step - self._begun >= BLOCK:
            self._hand_over()

    def end(self, simulator: Simulator) -> None:
        """Close the tape."""
        self.put(hash=state_hash(simulator), end=True)
        self.ended = True
        self._hand_over()

    def _hand_over(self) -> None:
        block = "".join(f"{line}\n" for line in self._lines)
        self._lines, self._begun = [], self.step
        kept = (*self.blocks, block)
        self.first += max(len(kept) - MOST_BLOCKS, 0)
        self.blocks = kept[-MOST_BLOCKS:]


def head_of(simulator: Simulator, machine: str, flow: str, values: Mapping[str, float]) -> dict[str, Any]:
    """First line of a tape.

    Parameters
    ----------
    simulator : Simulator
        As it is at the beginning.
    machine, flow : str
        What it was built with, by name or path.
    values : mapping from path to value in SI
        Numbers that were changed since.
    """
    saved = simulator.save()
    return {
        "form": FORM,
        "machine": machine,
        "flow": flow,
        "dt": simulator.dt,
        "functions": list(simulator.names),
        "of": saved.of,
        "values": dict(values),
        "payload": saved.mass,
        "start": {"live": _text(saved.live), "counts": _text(saved.counts), "delay": _text(saved.delay)},
    }


def start_of(head: Mapping[str, Any], simulator: Simulator, healthy: LayoutMachine) -> SavedState:
    """What to restore a simulator to, before the first stamp.

    Parameters
    ----------
    head : mapping
    simulator : Simulator
        Built as the one that was recorded.
    healthy : LayoutMachine
        Its machine as it was built with.

    Raises
    ------
    InputError
        A tape of another machine, flow model or version; one that is damaged.
    """
    like = simulator.save()
    if head["of"] != like.of:
        raise InputError(
            f"the drive was recorded of {head['machine']} as it was then, with flow {head['flow']!r}: its file, the flow model or the "
            "version of polydraulic has changed since, so that it cannot be replayed bit for bit"
        )
    parts = {}
    for name, array in (("live", like.live), ("counts", like.counts), ("delay", like.delay)):
        try:
            content = b64decode(str(head["start"][name]), validate=True)
        except (KeyError, ValueError) as error:
            raise InputError(f"the drive's start is damaged: {name} cannot be read") from error
        if len(content) != array.nbytes:
            raise InputError(f"the drive's start is damaged: {name} has {len(content)} bytes instead of {array.nbytes}")
        parts[name] = np.frombuffer(content, dtype=array.dtype).reshape(array.shape)
    mass = float(head["payload"])
    machine = healthy.with_values(head["values"]) if head["values"] else healthy
    return SavedState(like.of, **parts, loads=Loads({}, Payload((0.0,), (mass,))), mass=mass, machine=machine)


def state_hash(simulator: Simulator) -> str:
    """Digest of all that a simulator remembers: the same only if every bit is."""
    saved = simulator.save()
    return hashlib.sha256(saved.live.tobytes() + saved.delay.tobytes()).hexdigest()[:32]


def _text(array: np.ndarray) -> str:
    return b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
