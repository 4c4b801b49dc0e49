"""How near the machine that is driven comes to tipping, at the pace of what people see."""

import numpy as np

from polydraulic.cockpit.protocol import Flag
from polydraulic.parameters.layout.chassis import Chassis, edge_names
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.stability.monitor import StabilityMonitor
from polydraulic.simulation.stepping.simulator import Simulator

EVERY = 6  # steps, after which it is looked at anew
HELD = 200  # steps for which a warning stays
SEEN = (
    ("tipping.distance", "m"), ("tipping.dynamic_distance", "m"), ("tipping.force_angle", "N m"), ("tipping.edge", "1"),
    ("tipping.time", "s"), ("tipping.gravity_x", "m"), ("tipping.gravity_y", "m"),
    ("tipping.guard", "1"),
)  # fmt: skip


class Tipping:
    """Margins of a simulator's machine against tipping.

    Parameters
    ----------
    simulator : Simulator
        Of a machine with a chassis. Numbers that faults change count.

    Attributes
    ----------
    values : (8,) array
        Those of `SEEN`: least distances over all edges, the edge with the least dynamic one, the time to a tip, where the line of gravity meets the
        ground; and what the guard of coordinated control leaves of a motion, which `guard` sets.
    warning, over : bool
        Whether a tip is foreseen to within 2 s, or was during the last second, since an arm swings on its oil; whether the machine tips.
    """

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._of: LayoutMachine | None = None
        self._seen, self._warned = -1, -HELD
        self.values, self.warning, self.over = np.zeros(len(SEEN)), False, False
        self.guard(1.0)

    def guard(self, share: float) -> None:
        """Show what the guard leaves of a motion."""
        self.values[-1] = share

    @property
    def direction(self) -> str:
        """Where it would tip."""
        return self._monitor.edges[int(self.values[3])]

    @property
    def conditions(self) -> dict[Flag, bool]:
        """Of a frame."""
        return {Flag.TIPPING: self.warning, Flag.GUARDED: bool(self.values[-1] < 1.0)}

    def look(self, payload: float) -> bool:
        """Look, if it is time to; whether that was so."""
        simulator = self._simulator
        if simulator.machine is not self._of:
            self._of, self._monitor = simulator.machine, StabilityMonitor(simulator.machine, dt=simulator.dt)
        elif 0 <= simulator.steps - self._seen < EVERY:
            return False
        if simulator.steps < self._seen:  # begun anew
            self._warned = -HELD
        self._seen = simulator.steps
        found = self._monitor(simulator.state, payload=payload)
        least = (found.distance.min(), found.dynamic_distance.min(), found.force_angle.min())
        self.values[:-1] = (*least, found.edge, found.time_to_tip, *found.gravity)
        if found.warning:
            self._warned = self._seen
        self.warning, self.over = self._seen - self._warned < HELD, bool(least[1] <= 0.0)
        return True

    def forget(self) -> None:
        """Look anew next time, whatever the time is."""
        self._seen, self._warned = -EVERY, -HELD


def chassis_data(chassis: Chassis | None) -> dict[str, object] | None:
    """What a page is told of what a machine stands on: corners in m, the direction of tipping over the edge from each to the next."""
    if chassis is None:
        return None
    corners = np.array(chassis.corners)
    ways = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-ways[:, 1], ways[:, 0]], axis=1) / np.hypot(ways[:, 0], ways[:, 1])[:, None]
    far = np.einsum("ek,ek->e", corners[:, :2].mean(axis=0) - corners[:, :2], inward)
    return {"corners": corners.tolist(), "edges": list(edge_names(chassis)), "most": float(far.min())}
