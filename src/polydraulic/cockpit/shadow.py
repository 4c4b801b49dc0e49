"""A second flow model that does what the first one does, in a state of its own: how far it is away is its error."""

from collections.abc import Mapping

import numpy as np

from polydraulic.errors import InputError, SimulationError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.stepping.simulator import Simulator


class Shadow:
    """A machine that follows another one's levers.

    Parameters
    ----------
    machine : LayoutMachine
    flow : str
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

    def __init__(self, machine: LayoutMachine, flow: str, dt: float) -> None:
        self._simulator = Simulator(machine, flow, dt=dt, load={"payload": 0.0})
        self._n = len(machine.names)
        self._tip = np.array([self._simulator.place[f"effector.{c}"] for c in "xyz"])
        self._machine = machine
        self._changed: set[str] = set()  # numbers that have been others than the machine's
        self.lost, self._payload = "", 0.0

    @property
    def outside(self) -> int:
        """Steps outside the flow model's domain."""
        return self._simulator.steps_out_of_domain

    def begin(self, state: np.ndarray, values: dict[str, float]) -> None:
        """Begin where the other machine is, with the numbers that it has."""
        self.lost = ""
        self._simulator.reset(state)
        self._payload = 0.0
        healthy = {n.path: n.value for n in self._machine.numbers if n.path in self._changed} if self._changed else {}
        self.change(healthy | values)

    def change(self, values: Mapping[str, float]) -> None:
        """Take other numbers, if the flow model knows them."""
        if values and not self.lost:
            try:
                self._simulator.change(values)
                self._changed.update(values)
            except InputError:
                self.lost = f"no shadow until the next reset: its flow model is not for another {', '.join(values)}"

    def step(self, volts: np.ndarray, n: int, payload: float) -> None:
        """Make `n` steps as the other machine does, with a payload in kg."""
        if self.lost:
            return
        load = None if payload == self._payload else {"payload": payload}
        self._payload = payload
        try:
            self._simulator.step(volts, n, load)
        except (InputError, SimulationError) as error:
            self.lost = f"the shadow is lost: {error}"

    def seen(self, tip: np.ndarray) -> np.ndarray:
        """Its joints, and how far its tip is from the other one's, (n_function + 1,) in rad or m, m; as they were if it is lost."""
        values = self._simulator.values
        joints = values[3 * self._n : 4 * self._n]
        return np.append(joints, np.linalg.norm(values[self._tip] - tip))
