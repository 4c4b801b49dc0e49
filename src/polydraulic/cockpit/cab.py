"""The machine that is driven: what the driver wants becomes voltages, steps are made, what is seen becomes a snapshot.

Nothing here knows a clock, so that the same wishes at the same steps give the same bits.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.cockpit.patterns import Axis, lever_patterns
from polydraulic.cockpit.protocol import Flag
from polydraulic.cockpit.wanted import Snapshot, Wanted
from polydraulic.errors import SimulationError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.stepping.levers import full_lever
from polydraulic.simulation.stepping.simulator import Simulator

DT = 5e-3  # s
_MOST_EVENTS = 32  # that a snapshot shows
_RELIEF = 1e-12  # m3/s: below is rounding
_POWER, _PAYLOAD = "pump.power", "payload"


class Seen(NamedTuple):
    """A column of a frame."""

    name: str
    unit: str


class Cab:
    """A machine and its levers.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    flow : str

    Attributes
    ----------
    machine : LayoutMachine
    simulator : Simulator
    patterns : mapping from name to mapping from function to Axis
    columns : tuple of Seen
        What a frame holds.
    shown : Snapshot
        What the machine does; replaced whole.
    """

    def __init__(self, machine: LayoutMachine | str | Path, flow: str = "exact") -> None:
        self.simulator = Simulator(machine, flow, dt=DT, load={"payload": 0.0})
        self.machine = self.simulator.machine
        self.patterns = lever_patterns(self.machine)
        self._levers = {name: self._mixer(axes) for name, axes in self.patterns.items()}
        sim = self.simulator
        self.columns = (*(Seen(name, sim.units[name]) for name in sim.place), Seen(_POWER, "W"), Seen(_PAYLOAD, "kg"))
        self._take = np.array(list(sim.place.values()))
        self._pumps = [(sim[f"{c.name}.q_pump"], sim[f"{c.name}.p_pump"]) for c in self.machine.circuits]
        self._relief = [sim[f"{c.name}.q_relief"] for c in self.machine.circuits]
        self._joints = np.array([sim.place[self._position(name)] for name in sim.names])
        self._stops = np.array([f.stops[:2] for f in self.machine.functions]).T
        self._row = np.zeros(len(self.columns), dtype="<f4")
        self._resets, self._steps, self._n_events = 0, 0, 0
        self._events: tuple[tuple[int, list[Any]], ...] = ()
        self._payload, self._outside = 0.0, 0
        self.shown = self._snapshot(Wanted(), 0, 0.0)

    def warm_up(self) -> None:
        """Compile, or load, all that a step and another payload need; the machine is as before."""
        self.simulator.step(np.zeros(len(self.simulator.names)), 1, {"payload": 1.0})
        self.simulator.reset()

    def move(self, wanted: Wanted, n: int, *, overruns: int = 0, rate: float = 0.0) -> None:
        """Make `n` steps as the driver wants, and show them."""
        error, seq = "", wanted.seq
        if wanted.resets != self._resets:
            self._resets = wanted.resets
            self.simulator.reset()
            self._payload = 0.0
        try:
            load = None
            if wanted.payload != self._payload:
                load, self._payload = {"payload": wanted.payload}, wanted.payload
            self.simulator.step(self.voltages(wanted), n, load)
            for event in self.simulator.events:
                self._n_events += 1
                self._events = (*self._events, (self._n_events, event))[-_MOST_EVENTS:]
        except SimulationError as failed:
            error = str(failed)
        self._steps += n
        self.shown = self._snapshot(wanted._replace(seq=seq), overruns, rate)._replace(error=error)

    def voltages(self, wanted: Wanted) -> np.ndarray:
        """What the levers give, V, in the order of the functions."""
        if wanted.locked:
            return np.zeros(len(self.simulator.names))
        return np.asarray(self._levers[wanted.pattern] @ np.array(wanted.axes))

    def _mixer(self, axes: Mapping[str, Axis]) -> np.ndarray:
        """Matrix from sticks to voltages."""
        found = np.zeros((len(self.simulator.names), 6))
        for row, f in enumerate(self.machine.functions):
            axis, sign = axes[f.name]
            found[row, axis] = sign * full_lever(f)
        return found

    def _position(self, function: str) -> str:
        slides = self.machine.link(self.machine.function(function).moves).joint == "prismatic"
        return f"{function}.position" if slides else f"{function}.angle"

    def _snapshot(self, wanted: Wanted, overruns: int, rate: float) -> Snapshot:
        sim, row = self.simulator, self._row
        n = len(self._take)
        row[:n] = sim.values[self._take]
        row[n] = sum(float(q) * float(p) for q, p in self._pumps)
        row[n + 1] = self._payload
        joints, (low, high) = sim.values[self._joints], self._stops
        flags = Flag.LOCKED if wanted.locked else Flag(0)
        flags |= Flag.RELIEF if any(float(q) > _RELIEF for q in self._relief) else Flag(0)
        flags |= Flag.STOP if bool(np.any((joints <= low) | (joints >= high))) else Flag(0)
        flags |= Flag.OUTSIDE if sim.steps_out_of_domain > self._outside else Flag(0)
        self._outside = sim.steps_out_of_domain
        return Snapshot(self._steps, wanted.seq, sim.time, overruns, int(flags), row.tobytes(), self._events, rate)
