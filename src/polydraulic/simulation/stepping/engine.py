"""The compiled part of a single machine that is moved step by step: two drivers and the flat arrays that they change.

A call of `Engine.run` holds Python's lock only until the compiled code begins, so that another thread may serve people meanwhile. One
thread at a time may run an engine; what others are to see is copied between two calls.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.simulation.layout.prepare import ReadyMachine
from polydraulic.simulation.stepping.levers import hand_of
from polydraulic.simulation.stepping.marks import BEYOND, FLAGS, MOST_CHANGES, OUTSIDE, STEPS, Hand
from polydraulic.simulation.stepping.packed import pack_tree
from polydraulic.simulation.stepping.setup import Setup, flow_key, loaded_machine, readied
from polydraulic.simulation.stepping.text import Places, places_of, single_module


@dataclass
class Engine:
    """A machine as its drivers see it.

    Attributes
    ----------
    module : module
        Of the machine's step.
    begin, advance : drivers
        See ``pages/single.py.txt``.
    numbers, whole : arrays
        Packed parameters.
    valves : named tuple
        The parameters of which those are a copy: they keep the machine code of networks.
    live : array of float
        Recorded row, levers, and all else that changes, by `places`.
    counts : array of int
        See `marks`.
    delay : (n_function, n) array, V
        Levers of the last steps, where there are dead times.
    changes : (n, 1 + 2 n_record) array
        Step, and recorded rows before and after it, of steps in which an event begins or ends.
    start : (n_state,) array
        The machine's own.
    of : str
        Tells engines that can take each other's arrays from others.
    """

    module: ModuleType
    begin: Callable[..., int]
    advance: Callable[..., int]
    places: Places
    hand: Hand
    numbers: np.ndarray = field(repr=False)
    whole: np.ndarray = field(repr=False)
    valves: Any = field(repr=False)
    live: np.ndarray = field(repr=False)
    counts: np.ndarray = field(repr=False)
    delay: np.ndarray = field(repr=False)
    changes: np.ndarray = field(repr=False)
    start: np.ndarray = field(repr=False)
    of: str

    def reset(self, state: np.ndarray) -> None:
        """Start from a state, with nothing remembered."""
        self.live[:], self.counts[:], self.delay[:] = 0.0, 0, 0.0
        self.live[: len(state)] = state
        self.begin(self.numbers, self.whole, self.live, self.counts)

    def run(self, n: int) -> int:
        """Make up to `n` steps; how many were made, and `counts` says why no more."""
        return self.advance(self.numbers, self.whole, self.live, self.counts, self.delay, self.changes, n)

    def outside(self) -> int:
        """Steps outside the flow model's domain, or beyond the log that the machine was identified from, whichever are more."""
        return int(max(self.counts[OUTSIDE], self.counts[BEYOND]))

    def weigh(self, setup: Setup, mass: float) -> None:
        """Hang another mass at the tip; the flow model meets the state once more, as where a run of `simulate` goes on."""
        self._read(readied(setup, loaded_machine(setup, mass)))

    def change(self, setup: Setup, mass: float) -> None:
        """Go on as a machine with other numbers, and a mass in kg at its tip.

        Raises
        ------
        InputError
            A machine of another layout, or with longer dead times; nothing has changed.
        """
        hand, ready = hand_of(setup.machine, setup.dt, setup.locked), readied(setup, loaded_machine(setup, mass))
        if ready.module is not self.module:
            raise InputError(
                "these values change what the machine consists of, and not numbers alone: build another simulator"
            )
        if hand.wait.max() >= max(self.delay.shape[1], 1):
            raise InputError(
                "dead times cannot be longer than those that the simulator was built with: build it with the longest"
            )
        positions = self.live[3 * len(hand.moves) :][: len(hand.moves)]
        for f, q in zip(setup.machine.functions, positions.tolist(), strict=True):
            if not f.stops.low - 1e-9 <= q <= f.stops.high + 1e-9:
                raise InputError(f"functions.{f.name}.stops: the joint is at {q:g}, beyond them")
        self.hand, self.start = hand, ready.start
        self._read(ready)

    def _read(self, ready: ReadyMachine) -> None:
        """Take other numbers; the flow model meets the state with them."""
        valves = ready.valves
        self.numbers, self.whole = pack_tree((valves, ready.plant, self.hand))
        self.valves = valves
        if self.counts[STEPS] > 0:
            met, memory = self.live.copy(), self.places.memory
            self.begin(self.numbers, self.whole, met, self.counts.copy())
            self.live[memory:] = met[memory:]


def engine_of(setup: Setup, mass: float) -> Engine:
    """Compile, or load, what moves a machine, with a mass in kg at its tip.

    Raises
    ------
    InputError
        What cannot be prepared: a time step that is too long for a declared effect, a dead time that is too long.
    """
    machine, hand = loaded_machine(setup, mass), hand_of(setup.machine, setup.dt, setup.locked)
    ready, force = readied(setup, machine), bool(setup.loads.force)
    parts = {"valves": ready.valves, "plant": ready.plant, "hand": hand}
    shape = {"force": force, "stores_oil": setup.flow.stores_oil}
    module, places = single_module(machine, ready.module, parts, **shape), places_of(machine, **shape)
    longest, packed = int(hand.wait.max()), pack_tree(tuple(parts.values()))
    return Engine(
        ready.module,
        module.begin,
        module.advance,
        places,
        hand,
        *packed,
        ready.valves,
        live=np.zeros(places.memory + ready.n_memory),
        counts=np.zeros(FLAGS + 2 * places.n_flag, dtype=np.int64),
        delay=np.zeros((len(machine.names), longest + 1 if longest else 0)),
        changes=np.zeros((MOST_CHANGES, 1 + 2 * places.n_record)),
        start=ready.start,
        of=_digest(setup, module),
    )


def _digest(setup: Setup, module: ModuleType) -> str:
    flow = flow_key(setup.flow)
    kept = (module.__name__, setup.machine, setup.dt, setup.locked, setup.loads.payload is None, flow)
    return hashlib.sha256(repr(kept).encode()).hexdigest()
