"""The compiled part of many machines that are moved step by step: one driver, and the arrays that it changes.

Machines stand side by side in blocks of 64 lanes, each block one flat array. Where machines differ, or can come to differ, each lane has
numbers of its own. As with a single `engine`, the driver runs without Python's lock, here on several threads at once.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from polydraulic.flow.lanes import LANES, leaves
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.prepare import ReadyMachine
from polydraulic.simulation.stepping.levers import hand_of
from polydraulic.simulation.stepping.packed import pack_tree
from polydraulic.simulation.stepping.setup import Setup, loaded_machine, readied
from polydraulic.simulation.stepping.text import MORE_ROWS, lanes_module


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
            self.numbers, self.whole, self.own_valves, self.own_plant, self.blocks, self.given, self.taken, self.moves, self.wait,
            self.delay, self.scratch[k], self.mask, self.states, self.signal, self.chosen, self.out, self.clock, n, first, last,
        )  # fmt: skip

    def place(self, lane: int, setup: Setup, machine: LayoutMachine, mass: float) -> None:
        """Put another machine, of the same layout, into a lane; it shows from the next start or step on."""
        setup = setup._replace(machine=machine)
        ready, hand = readied(setup, loaded_machine(setup, mass)), hand_of(machine, setup.dt, setup.locked)
        b, at = divmod(lane, LANES)
        for own, numbers in ((self.own_valves, ready.valves), (self.own_plant, ready.plant)):
            if own is not None:
                own[b].reshape(-1, LANES)[:, at] = leaves(numbers)
        self.starts[lane], self.most[lane] = ready.start, hand.most
        self.wait[b, :, at] = hand.wait


def batch_engine(
    setup: Setup,
    machines: Sequence[LayoutMachine],
    masses: np.ndarray,
    rows: Sequence[int],
    threads: int,
    *,
    longest: int,
    differ: bool,
) -> BatchEngine:
    """Compile, or load, what moves machines side by side.

    Parameters
    ----------
    setup : Setup
        Of the first machine.
    machines : sequence of LayoutMachine
        One for each lane that is used, all of one layout.
    masses : (n,) array, kg
        At their tips.
    rows : sequence of int
        Rows of a block that are shown; `tip_row`, `count_rows` give those that no run records.
    threads : int
    longest : int
        Dead time in steps that any of them may have.
    differ : bool
        Whether they have, or can come to have, numbers of their own.
    """
    first: ReadyMachine = readied(setup, loaded_machine(setup, masses[0]))
    hand, n_block = hand_of(setup.machine, setup.dt, setup.locked), -(-len(machines) // LANES)
    n_lane, n_function = n_block * LANES, len(setup.machine.names)
    parts: dict[str, Any] = {"valves": first.valves, "plant": first.plant}
    module = lanes_module(loaded_machine(setup, masses[0]), first.module, parts, force=bool(setup.loads.force))
    n_input, n_row = n_function + (3 if setup.loads.force else 0), first.module.N_ROW + MORE_ROWS

    def own(numbers: Any) -> np.ndarray:
        return np.repeat(np.tile(leaves(numbers), (n_block, 1)), LANES, axis=1)

    engine = BatchEngine(
        module.advance_blocks,
        *pack_tree(tuple(parts.values())),
        own_valves=own(first.valves) if differ else None,
        own_plant=own(first.plant) if differ or setup.loads.payload is not None else None,
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
    )
    for lane, (machine, mass) in enumerate(zip(machines, masses, strict=True)):
        if machine is not machines[0] or mass != masses[0]:
            engine.place(lane, setup, machine, mass)
    return engine


def extra_rows(setup: Setup, mass: float) -> dict[str, int]:
    """Rows of a block that no run records, by what they hold."""
    module = readied(setup, loaded_machine(setup, mass)).module
    tip = {f"effector.{axis}": module.N_ROW + 1 + k for k, axis in enumerate("xyz")}
    return {
        "whole": module.N_ROW,
        "steps": module.STEPS_ROW // LANES,
        "unsettled": module.UNSETTLED_ROW // LANES,
        **tip,
    }
