"""The compiled part of many machines that are moved step by step: one driver, and the arrays that it changes.

Machines stand side by side in blocks of 64 lanes, each block one flat array. Where machines differ, or can come to differ, each lane has
numbers of its own. As with a single `engine`, the driver runs without Python's lock, here on several threads at once.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.lanes import LANES, arrays_in, leaves
from polydraulic.simulation.layout.prepare import ReadyMachine
from polydraulic.simulation.layout.seen import is_identified, seen_limits
from polydraulic.simulation.stepping.levers import hand_of
from polydraulic.simulation.stepping.marks import Hand
from polydraulic.simulation.stepping.packed import pack_tree
from polydraulic.simulation.stepping.setup import Setup, loaded_machine, readied
from polydraulic.simulation.stepping.text import MORE_ROWS, lanes_module, rows_before


class LaneNumbers(NamedTuple):
    """Numbers of one machine as it is set up, with a mass at its tip, for its lane."""

    setup: Setup
    mass: float
    ready: ReadyMachine
    hand: Hand


@dataclass
class BatchEngine:
    """Machines as their driver sees them; lanes beyond the last machine are filled up with the first one.

    Attributes
    ----------
    advance : driver
        See ``pages/lanes.py.txt``.
    numbers, whole : arrays
        Packed parameters of the first machine, or of all.
    own_valves, own_plant : (n_block, n_number * LANES) arrays or None
        Parameters of each machine, where they may differ.
    seen : (n_block, 3, n_function, LANES) array
        How far the logs went that they were identified from, in the order of `SeenLimits`.
    logged : bool
        Whether there are any.
    valves : named tuple
        The parameters of which `numbers` and `whole` are a copy: they keep the machine code of networks.
    blocks : (n_block, n_row * LANES) array
    given : (n_lane, n_input) array
        Levers in V, then the force at the tip in N.
    most : (n_lane, n_function) array, V
        Largest voltage of a lever to either side.
    out : (n_column, n_lane) array
        What is shown, column by column.
    starts : (n_lane, n_state) array
        The machines' own.
    clock : int
        Steps since the first one.
    """

    advance: Callable[..., int]
    numbers: np.ndarray = field(repr=False)
    whole: np.ndarray = field(repr=False)
    own_valves: np.ndarray | None = field(repr=False)
    own_plant: np.ndarray | None = field(repr=False)
    seen: np.ndarray = field(repr=False)
    valves: Any = field(repr=False)
    blocks: np.ndarray = field(repr=False)
    given: np.ndarray = field(repr=False)
    taken: np.ndarray = field(repr=False)
    moves: np.ndarray = field(repr=False)
    wait: np.ndarray = field(repr=False)
    delay: np.ndarray = field(repr=False)
    most: np.ndarray = field(repr=False)
    signal: np.ndarray = field(repr=False)
    chosen: np.ndarray = field(repr=False)
    out: np.ndarray = field(repr=False)
    starts: np.ndarray = field(repr=False)
    states: np.ndarray = field(repr=False)
    mask: np.ndarray = field(repr=False)
    scratch: np.ndarray = field(repr=False)
    pool: ThreadPoolExecutor | None = None
    clock: int = 0
    logged: bool = False

    def run(self, n: int) -> int:
        """Make `n` steps, or begin anew where `mask` is 1 for n = 0; how many machines have diverged."""
        n_part, n_block = len(self.scratch), len(self.blocks)
        bounds = [n_block * k // n_part for k in range(n_part + 1)]
        if self.pool is None:
            lost = self._part(n, 0, 0, n_block)
        else:
            parts = pairwise(bounds)
            futures = [self.pool.submit(self._part, n, k, first, last) for k, (first, last) in enumerate(parts)]
            lost = sum(future.result() for future in futures)
        self.clock += n
        return lost

    def _part(self, n: int, k: int, first: int, last: int) -> int:
        return self.advance(
            self.numbers, self.whole, self.own_valves, self.own_plant, self.seen, int(self.logged), self.blocks, self.given,
            self.taken, self.moves, self.wait, self.delay, self.scratch[k], self.mask, self.states, self.signal, self.chosen, self.out, self.clock, n, first, last,
        )  # fmt: skip

    def prepared(self, setup: Setup, mass: float) -> LaneNumbers:
        """Numbers of another machine, of the same layout, with a mass in kg at its tip.

        Raises
        ------
        InputError
            What cannot be prepared; networks of which machines side by side do not share all.
        """
        found = _prepared(setup, mass)
        shared = zip(arrays_in(self.valves), arrays_in(found.ready.valves), strict=True)
        if not all(np.array_equal(one, other) for one, other in shared):
            raise InputError(
                f"{setup.machine.title!r} has other networks of flow {setup.flow.name!r} than the first machine; machines side by side share "
                "theirs: give networks that all of them are to have, or use `simulate_batch`"
            )
        return found

    def place(self, lane: int, new: LaneNumbers) -> None:
        """Put another machine into a lane; it shows from the next start or step on."""
        b, at = divmod(lane, LANES)
        for own, numbers in ((self.own_valves, new.ready.valves), (self.own_plant, new.ready.plant)):
            if own is not None:
                own[b].reshape(-1, LANES)[:, at] = leaves(numbers)
        self.starts[lane], self.most[lane] = new.ready.start, new.hand.most
        self.wait[b, :, at] = new.hand.wait
        self.seen[b, :, :, at] = new.hand.seen
        self.logged = self.logged or is_identified(new.setup.machine)


def _prepared(setup: Setup, mass: float) -> LaneNumbers:
    ready = readied(setup, loaded_machine(setup, mass))
    return LaneNumbers(setup, mass, ready, hand_of(setup.machine, setup.dt, setup.locked))


def batch_engine(
    setup: Setup, mass: float, n: int, rows: Sequence[int], threads: int, *, longest: int, differ: bool
) -> BatchEngine:
    """Compile, or load, what moves machines side by side.

    Parameters
    ----------
    setup : Setup
        Of a machine that fills all lanes.
    mass : float, kg
        At its tip.
    n : int
        Lanes that are used.
    rows : sequence of int
        Rows of a block that are shown; `extra_rows` gives those that no run records.
    threads : int
    longest : int
        Dead time in steps that any of them may have.
    differ : bool
        Whether lanes can come to have numbers of their own.
    """
    _, _, first, hand = _prepared(setup, mass)
    n_block = -(-n // LANES)
    n_lane, n_function = n_block * LANES, len(setup.machine.names)
    parts: dict[str, Any] = {"valves": first.valves, "plant": first.plant}
    module = lanes_module(
        loaded_machine(setup, mass), first.module, parts, force=bool(setup.loads.force), flow=setup.flow
    )
    n_input, n_row = n_function + (3 if setup.loads.force else 0), rows_before(first.module, setup.flow) + MORE_ROWS

    def own(numbers: Any) -> np.ndarray:
        return np.repeat(np.tile(leaves(numbers), (n_block, 1)), LANES, axis=1)

    return BatchEngine(
        module.advance_blocks,
        *pack_tree(tuple(parts.values())),
        own_valves=own(first.valves) if differ else None,
        own_plant=own(first.plant) if differ or setup.loads.payload is not None else None,
        seen=np.repeat(np.tile(np.array(seen_limits(setup.machine)), (n_block, 1, 1))[..., None], LANES, axis=-1),
        valves=first.valves,
        blocks=np.zeros((n_block, n_row * LANES)),
        given=np.zeros((n_lane, n_input)),
        taken=np.zeros((n_lane, 1, n_input)),
        moves=hand.moves,
        wait=np.tile(hand.wait[:, None], (n_block, 1, LANES)),
        delay=np.zeros((n_block, n_function, longest + 1 if longest else 0, LANES)),
        most=np.tile(hand.most, (n_lane, 1)),
        signal=np.arange(n_lane).reshape(n_block, LANES),
        chosen=np.array(rows, dtype=np.int64),
        out=np.zeros((len(rows), n_lane)),
        starts=np.tile(first.start, (n_lane, 1)),
        states=np.tile(first.start, (n_lane, 1)),
        mask=np.ones(n_lane, dtype=np.int64),
        scratch=np.zeros((max(min(threads, n_block), 1), n_row * LANES)),
        pool=ThreadPoolExecutor(min(threads, n_block), "polydraulic") if min(threads, n_block) > 1 else None,
        logged=is_identified(setup.machine),
    )


def extra_rows(setup: Setup, mass: float) -> dict[str, int]:
    """Rows of a block that no run records, by what they hold."""
    module = readied(setup, loaded_machine(setup, mass)).module
    whole = rows_before(module, setup.flow)
    tip = {f"effector.{axis}": whole + 1 + k for k, axis in enumerate("xyz")}
    return {
        "whole": whole,
        "steps": module.STEPS_ROW // LANES,
        "unsettled": module.UNSETTLED_ROW // LANES,
        "outside": module.BEYOND_ROW // LANES,
        "beyond_log": module.BEYOND_LOG_ROW // LANES,
        **tip,
    }
