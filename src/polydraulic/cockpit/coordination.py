"""Coordinated control at the cockpit: sticks say how the tip is to move, and the controller moves all levers for it."""

from typing import Any

import numpy as np

from polydraulic.control.coordinated import ControlSettings, CoordinatedControl
from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.fault_catalogue import position_columns
from polydraulic.parameters.faults import Since, faulty_readings
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.stepping.simulator import Simulator

# as `CoordinatedControl.velocity` has them
AXES = {
    "swing": (0, -1.0),
    "reach": (1, 1.0),
    "pitch": (2, 1.0),
    "height": (3, -1.0),
}


class Coordination:
    """A controller of a simulator's machine.

    Parameters
    ----------
    simulator : Simulator
    machine : LayoutMachine
        As the controller knows it: without faults.
    flow : str or flow model
        That it inverts.

    Raises
    ------
    InputError
        A machine or a flow model that cannot be coordinated.
    """

    def __init__(self, simulator: Simulator, machine: LayoutMachine, flow: str | FlowModel) -> None:
        self._simulator, n = simulator, len(machine.names)
        self._control = CoordinatedControl(machine, flow, settings=ControlSettings())
        self.period = round(self._control.settings.dt / simulator.dt)  # steps between two calls
        pressures = [f"{name}.{quantity}" for quantity in ("p_a", "p_b") for name in machine.names]
        self._columns = [*position_columns(machine), *pressures]
        self._held: dict[tuple[str, str], float] = {}
        # of a state
        self._places = np.concatenate([np.arange(3 * n, 4 * n), np.arange(n, 2 * n), np.arange(2 * n, 3 * n)])
        self._left, self._volts = 0, np.zeros(n)

    def begin(self) -> None:
        """Begin where the machine is now."""
        self._control.reset()
        self._left = 0

    def voltages(self, axes: tuple[float, ...], most: int, faults: Since) -> tuple[np.ndarray, int]:
        """Voltages of the levers, V, and for how many of the next `most` steps they hold.

        Parameters
        ----------
        axes : tuple of float
            Sticks, -1 to 1.
        most : int
        faults : sequence of (Fault, s)
            Whose readings the controller is deceived by, and how long they have been there.
        """
        if self._left == 0:
            seen = self._simulator.state[self._places]
            if any(fault.readings for fault, _ in faults):
                read = faulty_readings(dict(zip(self._columns, seen.tolist(), strict=True)), faults, self._held)
                seen = np.array(list(read.values()))
            else:
                self._held.clear()
            self._volts = self._control.step(seen, self._control.velocity(np.array(axes))).copy()
            self._left = self.period
        n = min(most, self._left)
        self._left -= n
        return self._volts, n


def coordination_of(
    simulator: Simulator, machine: LayoutMachine, flow: str | FlowModel
) -> tuple[Coordination | None, str]:
    """A controller, or why there is none."""
    try:
        return Coordination(simulator, machine, flow), ""
    except InputError as error:
        return None, str(error)


def coordinated_axes(able: bool, why: str) -> dict[str, Any]:
    """What a page is told of it: whether it can be had, why not, and which stick moves what."""
    axes = {name: {"axis": axis, "sign": sign} for name, (axis, sign) in AXES.items()}
    return {"able": able, "why": why, "axes": axes}
