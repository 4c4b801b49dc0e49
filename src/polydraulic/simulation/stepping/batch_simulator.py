"""`BatchSimulator`: thousands of machines side by side, moved step by step, each by levers of its own."""

from collections.abc import Collection, Mapping, Sequence
from math import ceil
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Any, Self

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.loads import DIRECTIONS
from polydraulic.simulation.batch.family import family_of
from polydraulic.simulation.layout.columns import EFFECTOR
from polydraulic.simulation.layout.prepare import start_vector
from polydraulic.simulation.layout.text import layout_of
from polydraulic.simulation.stepping.batch_engine import batch_engine, extra_rows
from polydraulic.simulation.stepping.levers import lever_voltages, named_voltages, refused
from polydraulic.simulation.stepping.per_machine import as_many, count, per_machine
from polydraulic.simulation.stepping.saved import SavedBatch
from polydraulic.simulation.stepping.setup import set_up, states_from
from polydraulic.simulation.stepping.tip_load import PAYLOAD, as_loads

_MOST = 1_000_000  # machines
_COUNTS = ("whole", "steps", "unsettled")
AnyMachine = LayoutMachine | str | Path


class BatchSimulator:
    """Machines of one layout that are moved step by step, side by side; steps have the bits of `simulate_batch` and `simulate`.

    Parameters
    ----------
    machines : LayoutMachine, or name or path of a parameter set, or sequence of these
        One for all, or one for each; all of one layout.
    n : int, optional
        How many, if they are all alike.
    flow : str or flow model
        ``"exact"``, which has a form for machines side by side.
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
        What cannot be used, as for `Simulator`; machines of several layouts; a flow model without such a form.

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
        flow: str = "exact",
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
        self._setup = set_up(given[0], flow, dt, locked, loads)
        if self._setup.flow.kernels != "exact":
            raise InputError(
                f"flow {self._setup.flow.name!r} cannot be stepped side by side; use 'exact', `simulate_batch`, or a `Simulator` for each machine"
            )
        self.machine, self.names, self.dt = self._setup.machine, self._setup.machine.names, dt
        self._machines = [self.machine] * self.n if alike else [self._alike(item) for item in given]
        self._masses = values.get(PAYLOAD, np.zeros(self.n))
        dead = max(f.pilot.dead_time for machine in self._machines for f in machine.functions)
        if longest_delay is not None and not longest_delay >= dead:
            raise InputError(f"longest_delay = {longest_delay} s: the machines have dead times of up to {dead:g} s")
        self._longest = ceil((dead if longest_delay is None else longest_delay) / dt - 1e-9)
        rows = self._shown(columns)
        self._engine = batch_engine(
            self._setup,
            self._machines,
            self._masses,
            list(rows.values()),
            count(threads, "threads", 1024),
            longest=self._longest,
            differ=not alike,
        )
        seen = self._engine.out.view()
        seen.flags.writeable = False
        shown = {name: seen[k, : self.n] for k, name in enumerate(rows)}
        self._counts = {name: shown.pop(name) for name in _COUNTS}
        self.outputs: Mapping[str, np.ndarray] = MappingProxyType(shown)
        self._shape, self._levers = (self.n, len(self.names)), self._engine.given[: self.n, : len(self.names)]
        self._size, self._within = np.empty(self._shape), np.empty(self._shape, dtype=bool)
        self._closed = False
        self._first = {name: value for name, value in values.items() if name in DIRECTIONS}
        self.reset()

    def __len__(self) -> int:
        return self.n

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.outputs:
            raise InputError(f"no output {briefly(name)}; there are {list(self.outputs)}")
        return self.outputs[name]

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
        """Begin anew, all machines or some; the others stay as they are, bit for bit.

        Parameters
        ----------
        mask : (n,) array of bool, optional
            Which; all if not given.
        state : (n_state,) or (n, n_state) array, or mapping from column to a value or (n,) values, optional
            As for `Simulator.reset`, one for all or one for each of the n machines.
        machines : machine or sequence of n machines, optional
            Other parameters from now on, where the simulator was built with a sequence; some milliseconds for each machine.
        payload : float or (n,) array, kg, optional
            As `machines`, where the simulator was built with a payload.

        Raises
        ------
        InputError
            What cannot be used; all machines stay as they are.
        """
        chosen = self._mask(mask)
        others = self._others(machines, payload, chosen)
        news, starts = self._machines, self._engine.starts[: self.n]
        if others:
            news, starts = list(news), starts.copy()
        for i, (machine, _) in others.items():
            news[i], starts[i] = machine, start_vector(machine)
        states = states_from(self._setup, news, starts, state, chosen)
        engine = self._engine
        for i, (machine, mass) in others.items():
            engine.place(i, self._setup, machine, mass)
            self._machines[i], self._masses[i] = machine, mass
        engine.states[: self.n] = engine.starts[: self.n]
        engine.states[: self.n][chosen] = states
        self._levers[chosen] = 0.0
        if mask is None:
            for name, value in self._first.items():
                self._push(name, value)
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
        load : mapping of ``"x"``, ``"y"``, ``"z"`` to a value or (n_machine,) values, N, optional
            Force at the tips from now on.

        Raises
        ------
        InputError
            What cannot be used; nothing has moved.
        """
        if self._closed:
            raise InputError("the simulator is closed; build another one")
        steps = count(n, "n", 1_000_000)
        values = {} if load is None else {name: self._force(name, value) for name, value in load.items()}
        if inputs is not None:
            found = self._read(inputs)
            np.abs(found, out=self._size)
            np.less_equal(self._size, self._engine.most[: self.n], out=self._within)
            if not self._within.all():
                machine, place = (int(k) for k in np.argwhere(~self._within)[0])
                raise refused(
                    self._machines[machine].functions[place], float(found[machine, place]), f" of machine {machine}"
                )
            self._levers[:] = found
        for name, value in values.items():
            self._push(name, value)
        if self._engine.run(steps):
            self._hide()

    def save(self) -> SavedBatch:
        """All that changes, to come back to by `restore`: bit for bit."""
        arrays = {name: None if (own := getattr(self._engine, name)) is None else own.copy() for name in _CHANGING}
        return SavedBatch(self._of(), arrays, self._engine.clock, tuple(self._machines), self._masses.copy())

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

    def close(self) -> None:
        """End: further steps are refused, outputs can still be read, and threads end."""
        self._closed = True
        if self._engine.pool is not None:
            self._engine.pool.shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

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

    def _others(self, machines: Any, payload: Any, chosen: np.ndarray) -> dict[int, tuple[LayoutMachine, float]]:
        """Machines of the lanes that get another one, or another payload."""
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
        masses = self._masses if payload is None else per_machine(payload, "payload", self.n, low=0.0)
        found = {}
        for i in np.flatnonzero(chosen) if machines is not None or payload is not None else ():
            if news[i] is not self._machines[i] or masses[i] != self._masses[i]:
                dead = max(f.pilot.dead_time for f in news[i].functions)
                if ceil(dead / self.dt - 1e-9) > self._longest:
                    raise InputError(
                        f"machine {i} has a dead time of {dead:g} s; build the simulator with longest_delay={dead:g}"
                    )
                found[int(i)] = (news[i], float(masses[i]))
        return found

    def _read(self, inputs: Any) -> np.ndarray:
        if isinstance(inputs, Mapping):
            named = named_voltages(inputs, self.names, self._setup.locked)
            return np.column_stack(
                [as_many(value, name, self.n) for value, name in zip(named, self.names, strict=True)]
            )
        if inputs.__class__ is np.ndarray and inputs.shape == self._shape and inputs.dtype == np.float64:
            return inputs
        return lever_voltages(inputs, self.names, self._shape)

    def _force(self, name: str, value: Any) -> np.ndarray:
        if name not in DIRECTIONS:
            raise InputError(
                f"load names {briefly(name)}: must be one of {list(DIRECTIONS)}; a payload changes by `reset`"
            )
        if not self._setup.loads.force:
            raise InputError(
                'load: has a force at the tip, for which this simulator was not built; build it with load={"x": 0.0}'
            )
        return per_machine(value, f"load: {name}", self.n)

    def _push(self, name: str, value: np.ndarray) -> None:
        self._engine.given[: self.n, len(self.names) + DIRECTIONS.index(name)] = value

    def _hide(self) -> None:
        """What diverged is no number in any output."""
        lost = self.diverged
        if lost.any():
            self._engine.out[: len(self.outputs), : self.n][:, lost] = np.nan

    def _of(self) -> tuple[Any, ...]:
        forced, weighed = bool(self._setup.loads.force), self._setup.loads.payload is not None
        # numbers of machines that have their own are saved with them
        fixed = self.machine if self._engine.own_valves is None else layout_of(self.machine)
        return fixed, self.n, self.dt, self._setup.locked, forced, weighed, tuple(self.outputs), self._longest


_CHANGING = ("blocks", "given", "wait", "delay", "most", "starts", "out", "own_valves", "own_plant")
