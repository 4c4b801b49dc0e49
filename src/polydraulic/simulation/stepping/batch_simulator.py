"""`BatchSimulator`: thousands of machines side by side, moved step by step, each by levers of its own."""

from collections.abc import Collection, Mapping, Sequence
from math import ceil
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.loads import DIRECTIONS
from polydraulic.simulation.batch.family import family_of
from polydraulic.simulation.layout.columns import EFFECTOR
from polydraulic.simulation.layout.seen import is_identified
from polydraulic.simulation.layout.text import layout_of
from polydraulic.simulation.stepping.batch_engine import LaneNumbers, batch_engine, extra_rows
from polydraulic.simulation.stepping.levers import refused
from polydraulic.simulation.stepping.per_machine import as_many, count, per_machine
from polydraulic.simulation.stepping.saved import SavedBatch
from polydraulic.simulation.stepping.setup import flow_key, set_up, setup_beside, states_from
from polydraulic.simulation.stepping.stepped import PIECE, Stepped
from polydraulic.simulation.stepping.tip_load import PAYLOAD, as_loads, check_kept
from polydraulic.simulation.steps import MOST_STEPS

_MOST = 1_000_000  # machines
_MOST_KNOWN = 256  # machines, with masses at their tips, of which prepared numbers are kept
_COUNTS = ("whole", "steps", "unsettled", "outside", "beyond_log")
AnyMachine = LayoutMachine | str | Path


class BatchSimulator(Stepped):
    """Machines of one layout that are moved step by step, side by side; steps have the bits of `simulate_batch` and `simulate`.

    Parameters
    ----------
    machines : LayoutMachine, or name or path of a parameter set, or sequence of these
        One for all, or one for each; all of one layout.
    n : int, optional
        How many, if they are all alike.
    flow : str or flow model
        One that has a form for machines side by side: ``"exact"``, ``"polynomial"``, ``"neural"``, ``"pressure"``, ``"residual"``. A name builds
        the model of each machine, and all of them must share their networks; a model serves all machines.
    dt : float, s
    locked : collection of str
        Functions whose joints are held, in all machines.
    load : mapping, optional
        ``"x"``, ``"y"``, ``"z"`` (force at the tips along the ground's axes, N) and ``"payload"`` (kg), each one value for all or (n,) values.
        Whether there is a force, and whether there is a payload, is settled here; give 0 for one that comes later.
    columns : sequence of str, optional
        Outputs that are wanted; all if not given. Fewer cost less.
    threads : int
        That share the machines; results do not depend on it.
    longest_delay : float, s, optional
        Dead time of a pilot that machines may come to have by `reset`; those given here have at most as much.

    Attributes
    ----------
    names : tuple of str
        Functions, in the order of the levers.
    outputs : mapping from column to (n,) array
        Read-only views of what the machines do now; they follow every step, and are nan for machines that have diverged.
    units : mapping from column to unit

    Raises
    ------
    InputError
        What cannot be used, as for `Simulator`; machines of several layouts, or with several networks; a flow model without such a form.

    Examples
    --------
    >>> with BatchSimulator("wheel_loader", 100) as loaders:
    ...     loaders.step(np.random.default_rng(0).uniform(-0.8, 0.8, (100, 2)), n=20)
    ...     raised = loaders["lift.angle"]
    >>> raised.shape
    (100,)
    """

    def __init__(
        self,
        machines: AnyMachine | Sequence[AnyMachine],
        n: int | None = None,
        flow: str | FlowModel = "exact",
        *,
        dt: float = 5e-3,
        locked: Collection[str] = (),
        load: Mapping[str, Any] | None = None,
        columns: Sequence[str] | None = None,
        threads: int = 1,
        longest_delay: float | None = None,
    ) -> None:
        alike = isinstance(machines, AnyMachine)
        given: Sequence[Any] = [machines] if alike else list(machines)  # type: ignore[arg-type]
        if not given:
            raise InputError("0 machines: give one with n, or as many as there are to be")
        if alike and n is None:
            raise InputError("n: give the number of machines, or as many machines as there are to be")
        if not alike and n not in (None, len(given)):
            raise InputError(f"n = {n}: there are {len(given)} machines; give one of the two")
        self.n = count(n if alike else len(given), "n", _MOST)
        values = {
            name: per_machine(value, f"load: {name}", self.n, low=0.0 if name == PAYLOAD else None)
            for name, value in (load or {}).items()
        }
        loads = as_loads({name: float(value[0]) for name, value in values.items()} if values else None)
        setup = set_up(given[0], flow, dt, locked, loads)
        super().__init__(setup, flow, (self.n, len(setup.machine.names)))
        if family_of(self.machine, setup.flow).run_block is None:
            raise InputError(
                f"flow {setup.flow.name!r} cannot be stepped side by side; use 'exact', `simulate_batch`, or a `Simulator` for each machine"
            )
        self._machines = [self.machine] * self.n if alike else [self._alike(item) for item in given]
        self._masses = values.get(PAYLOAD, np.zeros(self.n))
        dead = max(f.pilot.dead_time for machine in self._machines for f in machine.functions)
        if longest_delay is not None and not longest_delay >= dead:
            raise InputError(f"longest_delay = {longest_delay} s: the machines have dead times of up to {dead:g} s")
        self._longest = ceil((dead if longest_delay is None else longest_delay) / dt - 1e-9)
        rows, first = self._shown(columns), float(self._masses[0])
        shares = count(threads, "threads", 1024)
        self._engine = batch_engine(
            setup, first, self.n, list(rows.values()), shares, longest=self._longest, differ=not alike
        )
        self._known: dict[tuple[int, float], tuple[LayoutMachine, LaneNumbers]] = {}
        for i, machine in enumerate(self._machines):
            if machine is not self.machine or self._masses[i] != first:
                self._engine.place(i, self._numbers(machine, self._masses[i]))
        seen = self._engine.out.view()
        seen.flags.writeable = False
        shown = {name: seen[k, : self.n] for k, name in enumerate(rows)}
        self._counts = {name: shown.pop(name) for name in _COUNTS}
        self.outputs: Mapping[str, np.ndarray] = MappingProxyType(shown)
        self._levers, self._forces = np.split(self._engine.given[: self.n], [len(self.names)], axis=1)
        self._size, self._within = np.empty(self._shape), np.empty(self._shape, dtype=bool)
        # what episodes begin with
        self._first, self._first_masses = np.zeros(self._forces.shape), self._masses.copy()
        for name in [name for name in values if name in DIRECTIONS]:
            self._first[:, DIRECTIONS.index(name)] = values[name]
        self.reset()

    def __len__(self) -> int:
        return self.n

    @property
    def steps(self) -> np.ndarray:
        """Steps that each machine has made since it began, (n,) array of int."""
        return self._counts["steps"].astype(np.int64)

    @property
    def time(self) -> np.ndarray:
        """Simulated seconds of each machine since it began, (n,) array."""
        return self.steps * self.dt

    @property
    def steps_not_converged(self) -> np.ndarray:
        """Steps of each machine whose flows did not converge, (n,) array of int."""
        return self._counts["unsettled"].astype(np.int64)

    @property
    def steps_out_of_domain(self) -> np.ndarray:
        """Steps of each outside the flow model's domain, or beyond the log that it was identified from, whichever are more, (n,) array of int."""
        return np.maximum(self._counts["outside"], self._counts["beyond_log"]).astype(np.int64)

    @property
    def steps_beyond_log(self) -> np.ndarray:
        """Steps of each beyond the log that it was identified from, (n,) array of int."""
        return self._counts["beyond_log"].astype(np.int64)

    @property
    def diverged(self) -> np.ndarray:
        """Machines of which a rate grew without bound, (n,) array of bool: they stand still until they are reset."""
        return np.asarray(self._counts["whole"] == 0.0)

    def reset(
        self,
        mask: np.ndarray | None = None,
        state: np.ndarray | Mapping[str, Any] | None = None,
        *,
        machines: AnyMachine | Sequence[AnyMachine] | None = None,
        payload: float | np.ndarray | None = None,
    ) -> None:
        """Begin anew, all machines or some, with centred levers and the load that they were built with; the others stay as they are, bit for bit.

        Parameters
        ----------
        mask : (n,) array of bool, optional
            Which; all if not given.
        state : (n_state,) or (n, n_state) array, or mapping from column to a value or (n,) values, optional
            As for `Simulator.reset`, one for all or one for each of the n machines.
        machines : machine or sequence of n machines, optional
            Other parameters from now on, where the simulator was built with a sequence; some milliseconds for each machine.
        payload : float or (n,) array, kg, optional
            Instead of the one that they were built with, now and whenever they begin anew.

        Raises
        ------
        InputError
            What cannot be used; all machines stay as they are.
        """
        chosen = self._mask(mask)
        news, masses = self._others(machines, payload)
        others = {
            i: self._numbers(news[i], masses[i])
            for i in np.flatnonzero(chosen).tolist()
            if news[i] is not self._machines[i] or masses[i] != self._masses[i]
        }
        engine, starts = self._engine, self._engine.starts[: self.n]
        if others:
            starts = starts.copy()
            for i, new in others.items():
                starts[i] = new.ready.start
        states = states_from(self._setup, news, starts, state, chosen)
        self._first_masses[chosen] = masses[chosen]
        self._place(others, news, masses)
        engine.states[: self.n] = engine.starts[: self.n]
        engine.states[: self.n][chosen] = states
        self._levers[chosen], self._forces[chosen] = 0.0, self._first[chosen]
        engine.mask[:] = 0
        engine.mask[: self.n] = chosen
        if mask is None:
            engine.mask[:] = 1
        engine.run(0)
        self._hide()

    def step(self, inputs: Any = None, n: int = 1, load: Mapping[str, Any] | None = None) -> None:
        """Make `n` steps with constant levers.

        Parameters
        ----------
        inputs : (n_machine, n_function) array, or mapping from function to a value or (n_machine,) values, optional
            Voltages of the levers, as for `Simulator.step`. Without, levers stay as they are; those of machines that have begun anew are
            centred.
        n : int
        load : mapping of ``"x"``, ``"y"``, ``"z"`` (N) and ``"payload"`` (kg) to a value or (n_machine,) values, optional
            What pushes and hangs at the tips from now on; what it leaves out stays. Numbers of a machine with another payload take some
            milliseconds to prepare, once for machines that are one.

        Raises
        ------
        InputError
            What cannot be used; nothing has moved.
        """
        self._check_open()
        left = count(n, "n", MOST_STEPS)
        values = {} if load is None else {name: self._load(name, value) for name, value in load.items()}
        if inputs is not None:
            found = self._voltages(inputs)
            np.abs(found, out=self._size)
            np.less_equal(self._size, self._engine.most[: self.n], out=self._within)
            if not self._within.all():
                machine, place = (int(k) for k in np.argwhere(~self._within)[0])
                raise refused(
                    self._machines[machine].functions[place], float(found[machine, place]), f" of machine {machine}"
                )
        masses = values.pop(PAYLOAD, self._masses)
        others = np.flatnonzero(masses != self._masses).tolist()
        self._place({i: self._numbers(self._machines[i], masses[i]) for i in others}, self._machines, masses)
        if inputs is not None:
            self._levers[:] = found
        for name, value in values.items():
            self._forces[:, DIRECTIONS.index(name)] = value
        while left:
            piece = min(left, PIECE)
            lost = self._engine.run(piece)
            left -= piece
        if lost:
            self._hide()

    def save(self) -> SavedBatch:
        """All that changes, to come back to by `restore`: bit for bit."""
        arrays = {name: None if (own := getattr(self._engine, name)) is None else own.copy() for name in _CHANGING}
        return SavedBatch(
            self._of(),
            arrays,
            self._engine.clock,
            tuple(self._machines),
            self._masses.copy(),
            self._first_masses.copy(),
        )

    def restore(self, saved: SavedBatch) -> None:
        """Go back to what was saved, of this simulator or of one that is built alike.

        Raises
        ------
        InputError
            What other machines, or another step, have saved.
        """
        if not isinstance(saved, SavedBatch) or saved.of != self._of():
            raise InputError(
                "what was saved is of other machines, another number, load, step or set of locked functions or columns"
            )
        for name, values in saved.arrays.items():
            if values is not None:
                getattr(self._engine, name)[:] = values
        self._engine.clock, self._machines, self._masses = saved.clock, list(saved.machines), saved.masses.copy()
        self._engine.logged, self._first_masses = any(map(is_identified, saved.machines)), saved.first_masses.copy()

    def close(self) -> None:
        """End: further steps are refused, outputs can still be read, and threads end."""
        super().close()
        if self._engine.pool is not None:
            self._engine.pool.shutdown()

    def _alike(self, machine: Any) -> LayoutMachine:
        """A machine that can stand beside the first one."""
        found = as_machine(machine)
        if layout_of(found) != layout_of(self.machine):
            raise InputError(
                f"{found.title!r} has another layout than {self.machine.title!r}; machines side by side differ in numbers alone"
            )
        return found

    def _shown(self, columns: Sequence[str] | None) -> dict[str, int]:
        """Rows of a block that are wanted, by column."""
        free = [name for name in self.names if name not in self._setup.locked]
        family = family_of(self.machine, self._setup.flow, force=bool(self._setup.loads.force)).columns(free)
        extra = extra_rows(self._setup, float(self._masses[0]))
        able = {name: row for name, (row, _) in family.items()} | {name: extra[name] for name in EFFECTOR}
        units = {name: unit for name, (_, unit) in family.items()} | dict.fromkeys(EFFECTOR, "m")
        unknown = [name for name in columns or () if name not in able]
        if unknown or isinstance(columns, str):
            raise InputError(f"columns = {briefly(columns)}: must be a list of some of {list(able)}")
        wanted = list(able) if columns is None else list(dict.fromkeys(columns))
        self.units = MappingProxyType({name: units[name] for name in wanted})
        return {name: able[name] for name in wanted} | {name: extra[name] for name in _COUNTS}

    def _mask(self, mask: Any) -> np.ndarray:
        if mask is None:
            return np.ones(self.n, dtype=bool)
        found = np.asarray(mask)
        if found.shape != (self.n,) or found.dtype != bool:
            raise InputError(
                f"mask: must be {self.n} values, True or False; it has the shape {found.shape} of {found.dtype}"
            )
        return found

    def _others(self, machines: Any, payload: Any) -> tuple[list[LayoutMachine], np.ndarray]:
        """Machines of all lanes, and masses at their tips, as they begin."""
        if machines is not None and self._engine.own_valves is None:
            raise InputError(
                "machines: this simulator was built of one machine; build it of a sequence, of equal ones if need be"
            )
        if payload is not None and self._setup.loads.payload is None:
            raise InputError('payload: this simulator was built without; build it with load={"payload": 0.0}')
        news = self._machines
        if machines is not None:
            items = [machines] * self.n if isinstance(machines, AnyMachine) else list(machines)
            if len(items) != self.n:
                raise InputError(f"{len(items)} machines: give one for all, or {self.n}")
            news = [self._alike(item) for item in items]
        return news, self._first_masses if payload is None else per_machine(payload, "payload", self.n, low=0.0)

    def _numbers(self, machine: LayoutMachine, mass: float) -> LaneNumbers:
        """Numbers of a machine with a mass at its tip, prepared once."""
        key = id(machine), float(mass)
        if key not in self._known:
            dead = max(f.pilot.dead_time for f in machine.functions)
            if ceil(dead / self.dt - 1e-9) > self._longest:
                raise InputError(
                    f"{machine.title!r} has a dead time of {dead:g} s; build the simulator with longest_delay={dead:g}"
                )
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            self._known[key] = machine, self._engine.prepared(setup_beside(self._setup, self._flow, machine), key[1])
        return self._known[key][1]

    def _place(self, others: Mapping[int, LaneNumbers], machines: Sequence[LayoutMachine], masses: np.ndarray) -> None:
        """Let other machines, and masses at their tips, be in some lanes."""
        for i, new in others.items():
            self._engine.place(i, new)
            self._machines[i], self._masses[i] = machines[i], masses[i]

    def _in_order(self, values: list[Any]) -> np.ndarray:
        return np.column_stack([as_many(value, name, self.n) for value, name in zip(values, self.names, strict=True)])

    def _load(self, name: str, value: Any) -> np.ndarray:
        if name not in (*DIRECTIONS, PAYLOAD):
            raise InputError(f"load names {briefly(name)}: must be one of {[*DIRECTIONS, PAYLOAD]}")
        check_kept(as_loads({name: 0.0}), self._setup.loads)
        return per_machine(value, f"load: {name}", self.n, low=0.0 if name == PAYLOAD else None)

    def _hide(self) -> None:
        """What diverged is no number in any output."""
        lost = self.diverged
        if lost.any():
            self._engine.out[: len(self.outputs), : self.n][:, lost] = np.nan

    def _of(self) -> tuple[Any, ...]:
        forced, weighed = bool(self._setup.loads.force), self._setup.loads.payload is not None
        # numbers of machines that have their own are saved with them
        fixed = self.machine if self._engine.own_valves is None else layout_of(self.machine)
        flow = flow_key(self._setup.flow)
        return fixed, flow, self.n, self.dt, self._setup.locked, forced, weighed, tuple(self.outputs), self._longest


_CHANGING = ("blocks", "given", "wait", "delay", "most", "starts", "out", "own_valves", "own_plant", "seen")
