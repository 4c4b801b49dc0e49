"""`Simulator`: one machine, moved step by step by whoever holds its levers."""

import time as clocks
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from polydraulic.errors import InputError, SimulationError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.loads import DIRECTIONS, Loads
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.events import MAX_EVENTS
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.stepping import marks
from polydraulic.simulation.stepping.engine import engine_of
from polydraulic.simulation.stepping.levers import refused
from polydraulic.simulation.stepping.noted import events_between
from polydraulic.simulation.stepping.pace import Pace
from polydraulic.simulation.stepping.per_machine import count
from polydraulic.simulation.stepping.saved import SavedState
from polydraulic.simulation.stepping.setup import Setup, changed_setup, outputs_of, set_up, state_from
from polydraulic.simulation.stepping.stepped import PIECE, Stepped
from polydraulic.simulation.stepping.tip_load import as_loads, check_kept, mass_at
from polydraulic.simulation.stepping.until import steps_until
from polydraulic.simulation.steps import MOST_STEPS

_MOST_NOTED = 1000  # calls that wait for the names of their events


class Simulator(Stepped):
    """A machine that is moved step by step; steps have the bits of `simulate`.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    flow : str or flow model
        As for `simulate`.
    dt : float, s
        Time step; levers and force are constant over each.
    locked : collection of str
        Functions whose joints are held; their levers are ignored.
    load : mapping or Loads, optional
        What pushes and hangs at the tip, as for `step`. Whether there is a force, and whether there is a payload, is settled here; give 0
        for one that comes later.
    realtime : float, optional
        Keep `step` to the pace of a clock, so many simulated seconds for each of its own; see `pace`.
    clock, sleep : functions
        Of that pace: () -> s, which never goes back, and (s) -> None.

    Attributes
    ----------
    names : tuple of str
        Functions, in the order of the levers.
    outputs : mapping from column to array of no axes
        Read-only views of what the machine does now: columns as in the table of `simulate`, in the units of `units`. They follow every step.
    values : (n,) array
        All of them in one, at the places that `place` gives by name.
    state : (n_state,) array
        Those at its beginning: what `reset` takes.
    pace : Pace or None
        Overruns of real time.

    Raises
    ------
    InputError
        A machine, flow model, time step, name or load that cannot be used.

    Examples
    --------
    >>> with Simulator("wheel_loader") as loader:
    ...     loader.step({"lift": 0.5}, n=100)
    ...     raised = float(loader["lift.angle"])
    >>> round(loader.time, 6), raised > 0.0
    (0.5, True)
    """

    def __init__(
        self,
        machine: LayoutMachine | str | Path,
        flow: str | FlowModel = "exact",
        *,
        dt: float = 5e-3,
        locked: Collection[str] = (),
        load: Loads | Mapping[str, float] | None = None,
        realtime: float | None = None,
        clock: Callable[[], float] = clocks.perf_counter,
        sleep: Callable[[float], None] = clocks.sleep,
    ) -> None:
        setup = set_up(machine, flow, dt, locked, as_loads(load))
        super().__init__(setup, flow, (len(setup.machine.names),))
        oil, self._loads = self._setup.flow.stores_oil, self._setup.loads
        self._columns = columns_of(self.machine, stores_oil=oil)
        (self._mass, self._next_mass), self._steady = mass_at(self._loads.payload, 0, dt), True
        self._engine = engine_of(self._setup, self._mass)
        self._counts, self._live, given = self._engine.counts, self._engine.live, self._engine.places.given
        self._levers, self._push = self._live[given:][: len(self.names)], given + len(self.names)
        self._events: list[list[Any]] = []
        self._noted: list[np.ndarray] = []  # steps of which the events are not yet named
        self._dropped = 0
        self.pace = None if realtime is None else Pace(realtime, clock=clock, sleep=sleep)
        self._views(self._engine.places.n_out)
        self.reset()

    def _views(self, n_out: int) -> None:
        """Name what stands in the row."""
        seen = self._live.view()
        seen.flags.writeable = False
        found = outputs_of(self._setup)
        voltages_ = [(f"{f}.voltage", n_out + j) for j, f in enumerate(self.names) if f not in self._setup.locked]
        self.place = MappingProxyType({c.name: c.place for c in found} | dict(voltages_))
        self.units = MappingProxyType({c.name: c.unit for c in found} | {name: "V" for name, _ in voltages_})
        self.values = seen[: n_out + len(self.names)]
        self.state = seen[: self._columns.n_state]
        self.outputs = MappingProxyType({name: seen[at : at + 1].reshape(()) for name, at in self.place.items()})

    @property
    def events(self) -> list[list[Any]]:
        """What happened in the last call of `step` or `run_until`, [time in s, function or circuit, what], as in the ``info`` of a run."""
        self._name_events()
        return self._events

    @property
    def events_dropped(self) -> int:
        """How many of them there were beyond the number that a run keeps."""
        self._name_events()
        return self._dropped

    @property
    def time(self) -> float:
        """Simulated seconds since the start."""
        return int(self._counts[marks.STEPS]) * self.dt

    @property
    def steps(self) -> int:
        """Steps made since the start."""
        return int(self._counts[marks.STEPS])

    @property
    def steps_not_converged(self) -> int:
        """Of these, steps whose flows did not converge."""
        return int(self._counts[marks.UNSETTLED])

    @property
    def steps_out_of_domain(self) -> int:
        """Of these, steps outside the flow model's domain, or beyond the log that the machine was identified from, whichever are more."""
        return self._engine.outside()

    @property
    def steps_beyond_log(self) -> int:
        """Of these, steps beyond the travel or pressure of the log that the machine was identified from; 0 if it was not."""
        return int(self._counts[marks.BEYOND])

    def reset(self, state: np.ndarray | Mapping[str, float] | None = None) -> None:
        """Begin anew at time 0, with centred levers and the load that the simulator was built with.

        Parameters
        ----------
        state : (n_state,) array, or mapping from column to value, optional
            As `state` gives it; a mapping changes single values of the machine's own start.

        Raises
        ------
        InputError
            A state that cannot be used; the machine stays as it is.
        """
        start = state_from(self._setup, state, self._engine.start)
        self._counts[marks.STEPS] = 0
        self._take(self._setup.loads)
        self._hang()
        self._engine.reset(start)
        self._forget()

    def change(self, values: Mapping[str, float | Sequence[float]]) -> None:
        """Go on with other numbers of the machine, in SI by their paths as for `LayoutMachine.with_values`: a worn pump, a low relief.

        They hold from the next step on, `reset` included; initial values matter to `reset` alone. Takes some milliseconds.

        Raises
        ------
        InputError
            Unknown paths, values out of range, structure, longer dead times, a joint beyond its new stops; nothing has changed.
        """
        self._become(changed_setup(self._setup, self._flow, values), self._mass)

    def step(self, inputs: Any = None, n: int = 1, load: Loads | Mapping[str, float] | None = None) -> None:
        """Make `n` steps with constant levers.

        Parameters
        ----------
        inputs : (n_function,) array, or mapping from function to V, optional
            Voltages of the levers, in the order of `names`; functions that a mapping leaves out get 0 V. Without, levers stay as they are.
            Pilots see them after their dead times, rounded up to whole steps.
        n : int
        load : mapping or Loads, optional
            A mapping of ``"x"``, ``"y"``, ``"z"`` (force at the tip along the ground's axes, N) and ``"payload"`` (kg) holds from now on, and
            what it leaves out stays; `Loads`, as of a scenario, are functions of the simulator's time. Another payload takes some
            milliseconds to prepare.

        Raises
        ------
        InputError
            Voltages, number or load that cannot be used; nothing has moved. Where a lever is beyond its end, all are centred.
        SimulationError
            A rate grew without bound. The machine is as before that step.
        """
        if inputs is not None:
            self._hold(inputs)
        if load is not None:
            loads = as_loads(load, self._loads)
            check_kept(loads, self._setup.loads)
            self._take(loads)
        if n.__class__ is not int or not 1 <= n <= MOST_STEPS:
            n = count(n, "n", MOST_STEPS)
        if self._noted or self._events:
            self._no_events()
        if self.pace is not None and not self.pace.running:
            self.pace.start(self.time)
        self._run(n)
        if self.pace is not None:
            self.pace.wait(self.time)

    def run_until(
        self, until: float | str | Callable[["Simulator"], bool], inputs: Any = None, *, limit: float = 600.0
    ) -> bool:
        """Make steps until a time, an event, or a condition.

        Parameters
        ----------
        until : float, str or function
            Simulated time in s; an event, ``"high stop met"`` of any function or ``"lift high stop met"`` of one; or a function of the
            simulator that is asked after each step.
        inputs : as for `step`
        limit : float, s
            The end if neither event nor condition comes.

        Returns
        -------
        bool
            Whether it has come.

        Raises
        ------
        InputError, SimulationError
            As `step`; a time that has passed, an event that cannot be, a limit that is no time.
        """
        if inputs is not None:
            self._hold(inputs)
        left, event, timed = steps_until(until, limit, self.machine, self.time, self.dt)
        self._no_events()
        one_by_one = callable(until) or self.pace is not None
        if self.pace is not None and not self.pace.running:
            self.pace.start(self.time)
        self._counts[marks.STOP] = 1 if event else 0
        try:
            while left > 0:
                before, seen = self.steps, len(self.events)
                self._run(1 if one_by_one else left)
                left -= self.steps - before
                if self.pace is not None:
                    self.pace.wait(self.time)
                if event and any(event in (what, f"{where} {what}") for _, where, what in self.events[seen:]):
                    return True
                if callable(until) and until(self):
                    return True
        finally:
            self._counts[marks.STOP] = 0
        return timed

    def save(self) -> SavedState:
        """All that changes, to come back to by `restore`: bit for bit."""
        live, counts, delay = (kept.copy() for kept in (self._live, self._counts, self._engine.delay))
        return SavedState(self._engine.of, live, counts, delay, self._loads, self._mass, self.machine)

    def restore(self, saved: SavedState) -> None:
        """Go back to what was saved, of this simulator or of one that is built alike.

        Raises
        ------
        InputError
            What another machine, step or flow model has saved.
        """
        if not isinstance(saved, SavedState) or saved.of != self._engine.of:
            raise InputError(
                "what was saved is of another machine, load, flow model, step or set of locked functions: restore it to one that is built alike"
            )
        if (saved.machine, saved.mass) != (self.machine, self._mass):
            self._become(changed_setup(self._setup, self._flow, saved.machine), saved.mass)
        self._live[:], self._counts[:], self._engine.delay[:] = saved.live, saved.counts, saved.delay
        self._take(saved.loads)
        self._forget()

    def _become(self, setup: Setup, mass: float) -> None:
        """Let other numbers of the machine act from now on."""
        self._engine.change(setup, mass)
        self._setup, self.machine, self._mass = setup, setup.machine, mass

    def _hold(self, inputs: Any) -> None:
        """Set the levers."""
        self._levers[:] = self._voltages(inputs)

    def _take(self, loads: Loads) -> None:
        """Let other loads act from now on."""
        self._loads, self._steady, self._next_mass = loads, False, self.steps

    def _run(self, n: int) -> None:
        """Make steps; of an event that is waited for, up to it."""
        self._check_open()
        counts, left = self._counts, n
        while left:
            piece = left if self._steady else self._loaded(left)
            piece = min(piece, PIECE)
            made = self._engine.run(piece)
            left -= made
            if counts[marks.CHANGES]:
                self._note_events()
                if counts[marks.STOP]:
                    return
            elif made < piece:
                self._fail()

    def _loaded(self, most: int) -> int:
        """Let the load of the next step act; for how many steps it stays."""
        step = self.steps
        self._hang()
        if self._setup.loads.force:
            self._live[self._push : self._push + len(DIRECTIONS)] = self._loads.forces(np.array([step * self.dt]))[0]
        if not all(isinstance(signal, Constant) for signal in self._loads.force.values()):
            return 1
        self._steady = self._next_mass is None
        return most if self._next_mass is None else min(most, self._next_mass - step)

    def _hang(self) -> None:
        """Hang what the loads have at the tip now."""
        if self._next_mass is not None and self.steps >= self._next_mass:
            mass, self._next_mass = mass_at(self._loads.payload, self.steps, self.dt)
            if mass != self._mass:
                self._mass = mass
                self._engine.weigh(self._setup, mass)

    def _note_events(self) -> None:
        """Keep the pairs of rows that the last call has left: to name their events takes longer than many steps."""
        self._noted.append(self._engine.changes[: self._counts[marks.CHANGES]].copy())
        self._counts[marks.CHANGES] = 0
        if len(self._noted) == _MOST_NOTED:
            self._name_events()

    def _name_events(self) -> None:
        """Events in the rows that were kept."""
        for change in (row for rows in self._noted for row in rows):
            self._events += events_between(self.machine, self._columns, self._setup.locked, self.dt, change)
        self._noted.clear()
        self._dropped += max(len(self._events) - MAX_EVENTS, 0)
        del self._events[MAX_EVENTS:]

    def _no_events(self) -> None:
        self._events, self._noted, self._dropped = [], [], 0

    def _fail(self) -> None:
        """Say why steps have not been made."""
        if self._counts[marks.STATUS] == marks.REFUSED:
            place = int(self._counts[marks.WHICH])
            value = float(self._levers[place])
            self._levers[:] = 0.0
            raise refused(self.machine.functions[place], value)
        raise SimulationError(
            f"diverged: a rate grew without bound after t = {self.time:g} s; try a smaller dt or check the parameter set"
        )

    def _forget(self) -> None:
        """Nothing of the calls before."""
        self._no_events()
        self._counts[marks.CHANGES] = self._counts[marks.STOP] = 0
        if self.pace is not None:
            self.pace.stop()
