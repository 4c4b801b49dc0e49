"""Coordinated control at the cockpit: sticks say how the tip is to move, and the controller moves all levers for it."""

from typing import Any

import numpy as np

from polydraulic.cockpit.wanted import Wanted
from polydraulic.control.coordinated import ControlSettings, CoordinatedControl
from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.faults import Since, faulty_readings
from polydraulic.parameters.layout.schema import LayoutMachine, position_columns
from polydraulic.simulation.stepping.simulator import Simulator

# as `CoordinatedControl.velocity` has them
AXES = {
    "swing": (0, -1.0),
    "reach": (1, 1.0),
    "pitch": (2, 1.0),
    "height": (3, -1.0),
}


GUARD_MARGIN = 0.2  # m of the dynamic distance that the guard keeps


class Coordination:
    """A controller of a simulator's machine, and another one that guards it against tipping.

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

    Attributes
    ----------
    unguarded : str
        Why the machine cannot be guarded; empty if it can.
    period : int
        Steps between two calls.
    tip_share : float
        What the guard left of the motion in the last call.
    """

    def __init__(self, simulator: Simulator, machine: LayoutMachine, flow: str | FlowModel) -> None:
        self._simulator, n = simulator, len(machine.names)
        self._free = CoordinatedControl(machine, flow, settings=ControlSettings())
        self._guard, self.unguarded = None, "its file says nothing of what it stands on: it has no [chassis]"
        if machine.chassis is not None:
            settings = ControlSettings(tip_margin=GUARD_MARGIN)
            self._guard, self.unguarded = CoordinatedControl(machine, flow, settings=settings), ""
        self.period, self.tip_share = round(self._free.dt / simulator.dt), 1.0
        pressures = [f"{name}.{quantity}" for quantity in ("p_a", "p_b") for name in machine.names]
        self._columns = [*position_columns(machine), *pressures]
        self._held: dict[tuple[str, str], float] = {}
        # of a state
        self._places = np.concatenate([np.arange(3 * n, 4 * n), np.arange(n, 2 * n), np.arange(2 * n, 3 * n)])
        self._left, self._volts, self._moving = 0, np.zeros(n), self._free

    def warm_up(self) -> None:
        """Compile, or load, both."""
        for guarded in (True, False):
            self.begin()
            self.voltages(Wanted(guarded=guarded), 0.0, 1, ())

    def begin(self) -> None:
        """Begin where the machine is now."""
        self._moving.reset()
        self._left = 0

    def voltages(self, wanted: Wanted, payload: float, most: int, faults: Since) -> tuple[np.ndarray, int]:
        """Voltages of the levers, V, and for how many of the next `most` steps they hold.

        Parameters
        ----------
        wanted : Wanted
            Sticks, and whether to guard the machine against tipping.
        payload : float, kg
            What hangs at the tip, as far as the driver knows.
        most : int
        faults : sequence of (Fault, s)
            Whose readings the controller is deceived by, and how long they have been there.
        """
        control = self._guard if wanted.guarded and self._guard is not None else self._free
        if control is not self._moving:
            self._moving = control
            self.begin()
        if self._left == 0:
            if control is self._guard and payload != control.settings.payload:
                control.carry(payload)
            seen = self._simulator.state[self._places]
            if any(fault.readings for fault, _ in faults):
                read = faulty_readings(dict(zip(self._columns, seen.tolist(), strict=True)), faults, self._held)
                seen = np.array(list(read.values()))
            else:
                self._held.clear()
            self._volts = control.step(seen, control.velocity(np.array(wanted.axes))).copy()
            self._left, self.tip_share = self.period, float(control.tip_share)
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


def coordinated_axes(coordination: Coordination | None, why: str) -> dict[str, Any]:
    """What a page is told of it: whether it can be had, why not, which stick moves what; and whether tips can be guarded against."""
    axes = {name: {"axis": axis, "sign": sign} for name, (axis, sign) in AXES.items()}
    unguarded = why if coordination is None else coordination.unguarded
    guard = {"able": not unguarded, "why": unguarded, "margin": GUARD_MARGIN}
    return {"able": coordination is not None, "why": why, "axes": axes, "guard": guard}
