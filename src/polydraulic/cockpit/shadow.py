"""A second flow model beside the one that is driven: how far it runs away in a state of its own, and how far off one step of it is."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from polydraulic.errors import InputError, SimulationError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.stepping.simulator import Simulator

ERRORS = (("tip_error", "m"), ("step_speed_error", "m/s"), ("step_flow_error", "m3/s"))


class Shadow:
    """A machine that follows another one's levers.

    Parameters
    ----------
    machine : LayoutMachine
    flow : str or flow model
    dt : float, s

    Attributes
    ----------
    lost : str
        Why it follows no more until the next beginning; empty while it does.
    outside : int
        Steps outside the flow model's domain.

    Raises
    ------
    InputError
        A flow model that does not fit the machine.
    """

    def __init__(self, machine: LayoutMachine, flow: str | FlowModel, dt: float) -> None:
        self._free, self._one = (Simulator(machine, flow, dt=dt, load={"payload": 0.0}) for _ in range(2))
        self._n, self._dt = len(machine.names), dt
        self._tip = np.array([self._free.place[f"effector.{c}"] for c in "xyz"])
        self._inlets = np.array([self._free.place[f"{name}.q_in"] for name in machine.names])
        self._machine = machine
        self._changed: set[str] = set()  # numbers that have been others than the machine's
        self.lost = ""
        self._weighed = [0.0, 0.0]  # kg, at the tips of both
        self._step_errors = (0.0, 0.0)

    @property
    def outside(self) -> int:
        """Steps outside the flow model's domain."""
        return self._free.steps_out_of_domain

    def begin(self, state: np.ndarray, values: dict[str, float]) -> None:
        """Begin where the other machine is, with the numbers that it has."""
        self.lost, self._step_errors = "", (0.0, 0.0)
        for simulator in (self._free, self._one):
            simulator.reset(state)
        self._weighed = [0.0, 0.0]
        healthy = {n.path: n.value for n in self._machine.numbers if n.path in self._changed} if self._changed else {}
        self.change(healthy | values)

    def change(self, values: Mapping[str, float]) -> None:
        """Take other numbers, if the flow model knows them."""
        if values and not self.lost:
            try:
                for simulator in (self._free, self._one):
                    simulator.change(values)
                self._changed.update(values)
            except InputError:
                self.lost = f"no shadow until the next reset: its flow model is not for another {', '.join(values)}"

    def step(self, volts: np.ndarray, n: int, payload: float) -> None:
        """Make `n` steps as the other machine does, with a payload in kg."""
        self._move(0, volts, n, payload)

    def step_from(
        self, state: np.ndarray, volts: np.ndarray, payload: float, after: np.ndarray, place: Mapping[str, int]
    ) -> None:
        """Make the same step as the other machine, from its state: what this flow model alone is off.

        To be called before `step` makes it, so that levers that are still on their way through dead times are the same.

        Parameters
        ----------
        state : (n_state,) array
            Of the other machine, before its step.
        volts, payload
            As in `step`.
        after : array
            Its outputs behind it.
        place : mapping from column to place in them
        """
        if self.lost:
            return
        try:
            self._one.reset(state)
            self._weighed[1] = 0.0
            free = self._free.save()
            self._one.restore(replace(self._one.save(), delay=free.delay, counts=free.counts))
            self._move(1, volts, 1, payload)
        except InputError as error:
            self.lost = f"the shadow is lost: {error}"
        if self.lost:
            return
        own = self._one.values
        tip = np.array([after[place[f"effector.{c}"]] for c in "xyz"])
        flows = np.array([after[place[f"{name}.q_in"]] for name in self._machine.names])
        speed = float(np.linalg.norm(own[self._tip] - tip)) / self._dt
        self._step_errors = speed, float(np.abs(own[self._inlets] - flows).max())

    def seen(self, tip: np.ndarray) -> np.ndarray:
        """Its joints and its `ERRORS`, (n_function + 3,) in rad or m, m, m/s, m3/s; as they were if it is lost.

        `ERRORS` are how far its tip is from the other one's, and of one step from the other machine's state how far off the speed of the tip is, and the
        largest error of a flow into an actuator.
        """
        values = self._free.values
        joints = values[3 * self._n : 4 * self._n]
        return np.array([*joints, np.linalg.norm(values[self._tip] - tip), *self._step_errors])

    def _move(self, which: int, volts: np.ndarray, n: int, payload: float) -> None:
        if self.lost:
            return
        load = None if payload == self._weighed[which] else {"payload": payload}
        self._weighed[which] = payload
        try:
            (self._free, self._one)[which].step(volts, n, load)
        except (InputError, SimulationError) as error:
            self.lost = f"the shadow is lost: {error}"
