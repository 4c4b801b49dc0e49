"""`simulate_batch`: many machines at once, with inputs, initial states and parameters of their own.

Flow models with a lane form run 64 machines side by side, as vector instructions; the others run machine by machine. Blocks,
or machines, are shared out among threads. Nothing is kept but what was asked for.
"""

import os
from collections import deque
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from threading import Event, Thread
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.flow.lanes import LANES, arrays_in, leaves
from polydraulic.machine.reach.tip import tip_at_joints
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import Scenario
from polydraulic.progress import Progress, quiet
from polydraulic.simulation.batch.batch_inputs import Cases, arrange_cases
from polydraulic.simulation.batch.family import tips_of
from polydraulic.simulation.lane_blocks import Kept, LaneBlock
from polydraulic.simulation.layout.columns import EFFECTOR, columns_of
from polydraulic.simulation.layout.seen import beyond_seen, lane_limits
from polydraulic.tables import Table

KEEP = ("rows", "range")


@dataclass(frozen=True)
class Batch:
    """Results of many machines.

    Attributes
    ----------
    names : tuple of str
        Columns, as in the table of `simulate`.
    units : dict from name to unit
    time : (n_time,) array, s
    rows : (n_machine, n_time, n_column) array or None
        What was recorded, if asked for.
    final : (n_machine, n_column) array
        At the end.
    lowest, highest : (n_machine, n_column) array or None
        Over all steps and the start, if asked for.
    steps : (n_machine,) array of int
        Steps made. Fewer than `info` says where a run diverged: later rows, final values and ranges are nan there.
    not_converged, out_of_domain : (n_machine,) array of int
        Steps that did not converge; those outside the flow model's domain, or beyond the log that a machine was identified from, whichever are more.
    beyond_log : (n_machine,) array of int
        Steps beyond the travel or pressure of the log that a machine was identified from; 0 if it was not.
    info : dict
        ``doubtful_inputs``, if there are any, as of `simulate`: voltages far beyond those of full travel, each of the machine where it is worst.
    """

    names: tuple[str, ...]
    units: dict[str, str]
    time: np.ndarray
    rows: np.ndarray | None
    final: np.ndarray
    lowest: np.ndarray | None
    highest: np.ndarray | None
    steps: np.ndarray
    not_converged: np.ndarray
    out_of_domain: np.ndarray
    beyond_log: np.ndarray
    info: dict[str, object]

    def __len__(self) -> int:
        return len(self.final)

    def place(self, name: str) -> int:
        """Place of a column in the last axis of the arrays."""
        if name not in self.names:
            raise InputError(f"no column {name!r}; the batch has {list(self.names)}")
        return self.names.index(name)

    def __getitem__(self, name: str) -> np.ndarray:
        return self._recorded()[:, :, self.place(name)]

    def table(self, machine: int) -> Table:
        """Recorded rows of one machine, as a trajectory."""
        rows = self._recorded()[machine]
        columns = {name: np.ascontiguousarray(rows[:, place]) for place, name in enumerate(self.names)}
        return Table({"time": self.time, **columns}, {"time": "s", **self.units}, {**self.info, "machine": machine})

    def _recorded(self) -> np.ndarray:
        if self.rows is None:
            raise InputError("the batch has no rows; ask for them: simulate_batch(..., keep=['rows'])")
        return self.rows


def simulate_batch(
    machines: LayoutMachine | str | Path | Sequence[LayoutMachine | str | Path],
    flow: str | FlowModel,
    inputs: Scenario | str | Path | Sequence[Scenario | str | Path] | np.ndarray,
    *,
    dt: float = 5e-3,
    t_end: float | None = None,
    x0: np.ndarray | None = None,
    keep: Collection[str] = (),
    columns: Sequence[str] | None = None,
    every: int = 1,
    threads: int | None = None,
    faults: Sequence[Any] = (),
    progress: Progress = quiet,
) -> Batch:
    """Simulate many machines with the loop of `simulate`; the results have the same bits.

    Flow models with a lane form (``exact``, ``polynomial``, ``neural``, ``pressure``, ``residual``) run 64 machines side by side as vector instructions, of
    which networks are asked one after the other; all others run machine by machine. Both use all `threads`.

    Parameters
    ----------
    machines : LayoutMachine, or name or path of a parameter set, or sequence of these
        All of one layout.
    flow : str or flow model
        A name builds the model of each machine; a model serves all of them.
    inputs : Scenario, or name or path of one, or sequence of these, or array
        An array of shape (n_step, n_function) or (n_machine, n_step, n_function) holds the voltages at the pilots, after any dead time, each
        constant over a step. Machines, inputs and initial states may each be one for all, or one for each.
    dt : float, s
    t_end : float, s, optional
        Instead of the duration of the scenarios, which otherwise must be equal, or of the whole array.
    x0 : (n_state,) or (n_machine, n_state) array, optional
        States at the start: spools, pressures at A and B, positions and rates of all functions, then what declared effects keep (``driven``,
        ``flow_shift``, ``gap``); by default those of scenarios and machines.
    keep : collection of str
        Of ``"rows"`` (recorded every `every` steps) and ``"range"`` (lowest and highest value over all steps). Final
        values are always kept.
    columns : sequence of str, optional
        Which columns, by default all of them. Columns of ``effector`` come last, bring the angles that they follow from,
        and have no range.
    every : int
        Record every so many steps.
    threads : int, optional
        By default as many as there are processors. Results do not depend on it.
    faults : sequence of str, Fault or ScheduledFault, or sequence of such sequences
        As for `simulate`, besides those of scenarios: one list for all machines, or a list of lists, one for each. Faults of sensors do not act.
    progress : Progress, optional
        Told how many machines are done.

    Returns
    -------
    Batch

    Raises
    ------
    InputError
        Lengths or shapes that do not fit, an unknown column, a fault that a machine cannot have, a scenario that moves functions which the flow model does not serve, or
        what `simulate` would refuse.
    """
    cases = arrange_cases(machines, flow, inputs, dt=dt, t_end=t_end, x0=x0, every=every, faults=faults)
    unknown = [name for name in ([keep] if isinstance(keep, str) else keep) if name not in KEEP]
    if unknown or isinstance(keep, str):
        raise InputError(f"keep = {keep!r}: must be a list of {list(KEEP)}")
    if threads is not None and (not isinstance(threads, int) or threads < 1):
        raise InputError(f"threads = {threads!r}: must be a whole number, at least 1")
    family, n, n_step = cases.family, len(cases.kind), cases.voltage.shape[1]
    places, units, names = _chosen(cases, columns, "range" in keep)
    shape = (n, len(names))
    kept = Kept(
        columns=np.array(places, dtype=np.int64),
        circuits=any(row in family.pump_rows for row in places),
        every=every if "rows" in keep else 0,
        rows=np.empty((n, n_step // every + 1 if "rows" in keep else 0, len(names))),
        final=np.empty(shape),
        lowest=np.full(shape if "range" in keep else (0, 0), np.inf),
        highest=np.full(shape if "range" in keep else (0, 0), -np.inf),
        tips=tips_of(family, [cases.kinds[0].machine] * LANES, _tip_row(cases) if EFFECTOR[0] in names else 0),
    )
    counts = np.zeros((n, 4), dtype=np.int64)
    work = _blocks(cases, kept, counts) if family.run_block is not None else _singles(cases, kept, counts)
    _share_out(work, threads or _processors(), n, progress)
    for i in np.flatnonzero(counts[:, 0] < n_step):
        for values in (kept.final, kept.lowest, kept.highest):
            values[i : i + 1] = np.nan
        kept.rows[i, counts[i, 0] // every + 1 :] = np.nan
    return Batch(
        names=names,
        units=units,
        time=np.arange(kept.rows.shape[1]) * every * dt,
        rows=kept.rows if "rows" in keep else None,
        final=kept.final,
        lowest=kept.lowest if "range" in keep else None,
        highest=kept.highest if "range" in keep else None,
        steps=counts[:, 0],
        not_converged=counts[:, 1],
        out_of_domain=counts[:, 2:].max(axis=1),
        beyond_log=counts[:, 3],
        info={"flow": cases.flow, "dt": dt, "steps": n_step}
        | ({"doubtful_inputs": cases.doubts} if cases.doubts else {}),
    )


class _Chosen(NamedTuple):
    """Rows of a block to keep, units, and names; those of the effector follow the rows of all else."""

    rows: list[int]
    units: dict[str, str]
    names: tuple[str, ...]


def _tip_row(cases: Cases) -> int:
    """First row of a block for the tip's place: behind what a step keeps or uses as scratch."""
    return cases.family.n_row + -(-cases.n_memory // LANES)


def _chosen(cases: Cases, columns: Sequence[str] | None, ranges: bool) -> _Chosen:
    family, able = cases.family, cases.family.columns(cases.free)
    wanted = [*able, *([] if ranges else EFFECTOR)] if columns is None else list(dict.fromkeys(columns))
    unknown = [name for name in wanted if name not in able and name not in EFFECTOR]
    if unknown or not wanted:
        raise InputError(f"columns = {columns!r}: must be some of {[*able, *EFFECTOR]}")
    axes = EFFECTOR if any(name in EFFECTOR for name in wanted) else ()
    if axes and ranges:
        raise InputError(f"{', '.join(EFFECTOR)} have no range; keep rows, or leave them out of the columns")
    angles = family.joints if axes else ()
    names = tuple(dict.fromkeys([*(name for name in wanted if name not in EFFECTOR), *angles]))
    units = {name: able[name][1] for name in names} | dict.fromkeys(axes, "m")
    rows = [able[name][0] for name in names] + [_tip_row(cases) + k for k, _ in enumerate(axes)]
    return _Chosen(rows, units, names + axes)


def _blocks(cases: Cases, kept: Kept, counts: np.ndarray) -> list[Callable[[], int]]:
    """Work in blocks of lanes, each of one flow model's arrays; machines with equal parameters come together, and blocks of them share one set."""
    of_kinds = np.array([leaves((kind.model, kind.plant)) for kind in cases.kinds], dtype=np.float64)
    numbers, number = np.unique(of_kinds, axis=0, return_inverse=True)
    parameters, group = number.reshape(-1), _groups(cases)
    order = np.lexsort((cases.kind * np.isin(cases.kind, list(cases.later)), parameters[cases.kind], group))
    n_model, family = len(leaves(cases.kinds[0].model)), cases.family

    def numbers_at(kinds: np.ndarray) -> list[Any]:
        """Parameters of lanes: those of the first, and rows of their own where they differ."""
        own = np.ascontiguousarray(numbers[parameters[kinds]].T)
        differs, first = np.any(own != own[:, :1], axis=1), cases.kinds[kinds[0]]
        return [
            first.model,
            own[:n_model].ravel() if differs[:n_model].any() else None,
            first.plant,
            own[n_model:].ravel() if differs.any() else None,
            lane_limits([cases.kinds[k].machine for k in kinds]),
        ]

    def block(machine: np.ndarray) -> int:
        lanes = np.concatenate([machine, np.full(LANES - len(machine), machine[0])])
        rows = np.zeros((_tip_row(cases) + len(EFFECTOR)) * LANES)
        found = rows.reshape(-1, LANES)
        found[: family.n_state] = cases.x0[lanes].T
        lowest = np.full((kept.lowest.shape[1], LANES), np.inf)
        lane_block, of_block = LaneBlock(rows, machine, cases.signal[lanes], lowest, -lowest), kept
        if kept.tips.row > 0 and len(cases.kinds) > 1:
            machines = [cases.kinds[k].machine for k in cases.kind[lanes]]
            of_block = kept._replace(tips=tips_of(family, machines, kept.tips.row))
        for first, end, kinds in _parts(cases, lanes):
            family.run_block(*numbers_at(kinds), cases.voltage, first, end, lane_block, of_block)  # type: ignore[misc]  # there are lanes where there are blocks
        for place, row in enumerate((family.steps, family.unsettled, family.outside, family.beyond_log)):
            if row is not None:
                counts[machine, place] = found[row, : len(machine)]
        return len(machine)

    alike = np.split(order, np.flatnonzero(np.diff(group[order])) + 1)
    return [partial(block, one[i : i + LANES]) for one in alike for i in range(0, len(one), LANES)]


def _groups(cases: Cases) -> np.ndarray:
    """Number of a group for each machine: in one, all have the same arrays of a flow model at all times."""
    arrays = [tuple(array.tobytes() for array in arrays_in(kind.model)) for kind in cases.kinds]
    numbers: dict[Any, int] = {}

    def group(kind: int) -> int:
        held: list[Any] = [(0, arrays[kind])]
        for step, later in sorted(cases.later.get(kind, {}).items()):
            if arrays[later] != held[-1][1]:
                held.append((step, arrays[later]))
        return numbers.setdefault(tuple(held), len(numbers))

    return np.array([group(kind) for kind in range(len(cases.kinds))])[cases.kind]


def _parts(cases: Cases, machines: np.ndarray) -> Iterator[tuple[int, int, np.ndarray]]:
    """Steps, from one to before another, in which the kinds of some machines are what they are."""
    kinds, n_step = cases.kind[machines], cases.voltage.shape[1]
    changes = [cases.later.get(kind, {}) for kind in kinds.tolist()]
    begins = sorted({0, *(step for change in changes for step in change if step < n_step)})
    for first, end in zip(begins, [*begins[1:], n_step], strict=True):
        kinds = np.array([change.get(first, kind) for change, kind in zip(changes, kinds.tolist(), strict=True)])
        yield first, end, kinds


def _singles(cases: Cases, kept: Kept, counts: np.ndarray) -> list[Callable[[], int]]:
    """Work machine by machine, with the loop of `simulate`."""
    n_step, family = cases.voltage.shape[1], cases.family
    n, run, columns = (
        len(family.functions),
        family.run,
        columns_of(family.machine, stores_oil=cases.kinds[0].flow.stores_oil),
    )

    def single(i: int) -> int:
        rows, memory = np.empty((n_step + 1, _tip_row(cases) + len(EFFECTOR))), np.zeros(cases.n_memory)
        voltage, states = cases.voltage[cases.signal[i]], np.empty((n_step + 1, family.n_record))
        for first, end, kinds in _parts(cases, np.array([i])):
            kind, x0, before = cases.kinds[kinds[0]], states[first, : family.n_state].copy(), states[first].copy()
            x0 = x0 if first else cases.x0[i]
            own = states[first : end + 1]
            made = run(kind.model, memory, kind.plant, x0, voltage[first:end], 1, own, counts[i, 1:])
            counts[i, 0] += made
            beyond = beyond_seen(kind.machine, columns, own[1 : made + 1])
            counts[i, 3] += 0 if beyond is None else beyond.sum()
            if first:  # the row before stays that of the machine as it was
                states[first] = before
            elif made < end:  # the first row holds the step that failed; what it held before is the start
                run(kind.model, np.zeros_like(memory), kind.plant, x0, voltage[:0], 1, states[:1], counts[i, 1:])
            if made < end - first:
                break
        rows[:, : family.n_record] = states
        spool, p_a, p_b = (states[:, k * n : (k + 1) * n] for k in range(3))  # as states begin, whatever the layout
        rows[:, family.p_in : family.p_in + n] = np.where(spool >= 0.0, p_a, p_b)
        rows[:, family.p_out : family.p_out + n] = np.where(spool >= 0.0, p_b, p_a)
        if kept.tips.row > 0:
            with np.errstate(invalid="ignore"):  # what stands behind the step in which a run diverged
                rows[:, _tip_row(cases) :] = tip_at_joints(cases.kinds[cases.kind[i]].machine, states[:, 3 * n : 4 * n])
        values = rows[:, kept.columns]
        kept.final[i] = values[-1]
        if kept.every:
            kept.rows[i] = values[:: kept.every]
        if len(kept.lowest):
            kept.lowest[i], kept.highest[i] = values.min(axis=0), values.max(axis=0)
        return 1

    return [partial(single, i) for i in range(len(cases.kind))]


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _share_out(work: Sequence[Callable[[], int]], threads: int, n: int, progress: Progress) -> None:
    """Do all work, each piece in some thread; a piece returns how many machines are done.

    An error, or an interrupt of the program, ends the wait at once: compiled code cannot be stopped, so that pieces which have begun go
    on in threads for which nobody waits.
    """
    waiting, results, ended = deque(work), SimpleQueue[int | BaseException](), Event()

    def serve() -> None:
        while not ended.is_set():
            try:
                task = waiting.popleft()
            except IndexError:
                return
            try:
                results.put(task())
            except BaseException as error:
                results.put(error)

    for _ in range(min(threads, len(work))):
        Thread(target=serve, daemon=True).start()
    try:
        done = 0
        for _ in work:
            found = results.get()
            if isinstance(found, BaseException):
                raise found
            done += found
            progress("simulate", done, n)
    finally:
        ended.set()
