"""What a frame shows of a machine: its columns, and what they say of stops and relief valves."""

from typing import NamedTuple

import numpy as np

from polydraulic.cockpit.shadow import ERRORS as SHADOW_ERRORS
from polydraulic.cockpit.shadow import Shadow
from polydraulic.cockpit.tipping import SEEN, Tipping
from polydraulic.parameters.layout.schema import position_columns
from polydraulic.simulation.stepping.simulator import Simulator

_RELIEF = 1e-12  # m3/s: below is rounding
TARGET = ("target.x", "target.y", "target.z")


class FrameColumn(NamedTuple):
    """A column of a frame, and its unit."""

    name: str
    unit: str


class View:
    """The columns of a simulator, and more that a page shows.

    Parameters
    ----------
    simulator : Simulator
    shadow : Shadow or None
    tipping : Tipping or None

    Attributes
    ----------
    columns : tuple of FrameColumn
        Those of the simulator, ``pump.power`` where it is known, ``payload``, the target of an exercise; of a shadow its joints, how far its tip is
        away, and what one step makes of its error; of a machine with a chassis how near it comes to tipping.
    """

    def __init__(self, simulator: Simulator, shadow: Shadow | None, tipping: Tipping | None = None) -> None:
        self._simulator, self._shadow, self._tipping, machine = simulator, shadow, tipping, simulator.machine
        own = [FrameColumn(name, simulator.units[name]) for name in simulator.place]
        pumps = [(f"{c.name}.q_pump", f"{c.name}.p_pump") for c in machine.circuits]
        self.knows_power = all(name in simulator.outputs for both in pumps for name in both)
        self._pumps = [(simulator[q], simulator[p]) for q, p in pumps] if self.knows_power else []
        added = [FrameColumn("pump.power", "W")] if self.knows_power else []
        added += [FrameColumn("payload", "kg"), *(FrameColumn(name, "m") for name in TARGET)]
        behind = (
            [FrameColumn(f"shadow.{name}", simulator.units[name]) for name in position_columns(simulator.machine)]
            if shadow
            else []
        )
        behind += [FrameColumn(f"shadow.{name}", unit) for name, unit in SHADOW_ERRORS] if shadow else []
        behind += [FrameColumn(*both) for both in SEEN] if tipping else []
        self.columns = (*own, *added, *behind)
        self._take = np.array(list(simulator.place.values()))
        self._n, self._row = len(own), np.zeros(len(self.columns), dtype="<f4")
        reliefs = [f"{c.name}.q_relief" for c in machine.circuits]
        self._reliefs = [simulator[name] for name in reliefs if name in simulator.outputs]
        self._joints = np.array([simulator.place[name] for name in position_columns(machine)])
        self._n_function = len(machine.names)
        self._p_a, self._p_b, self._inlets = (
            np.array([simulator.place[f"{name}.{quantity}"] for name in machine.names])
            for quantity in ("p_a", "p_b", "q_in")
        )
        self._tip = np.array([simulator.place[f"effector.{c}"] for c in "xyz"])
        self._low, self._high = np.array([f.stops[:2] for f in machine.functions]).T

    @property
    def tip(self) -> np.ndarray:
        """Place of the tip, (3,) in m."""
        return self._simulator.values[self._tip]

    @property
    def power(self) -> float:
        """Of all pumps, W; if the flow model does not find their pressures, which `knows_power` says, what flows into all actuators at their pressures."""
        if self.knows_power:
            return sum(float(q) * float(p) for q, p in self._pumps)
        values = self._simulator.values
        pressures = np.where(values[: self._n_function] >= 0.0, values[self._p_a], values[self._p_b])
        return float(values[self._inlets] @ pressures)

    @property
    def at_stop(self) -> np.ndarray:
        """Which joints are at an end, (n_function,)."""
        joints = self._simulator.values[self._joints]
        return np.asarray((joints <= self._low) | (joints >= self._high))

    @property
    def relieved(self) -> bool:
        """Whether a pump's relief valve is open."""
        return any(float(q) > _RELIEF for q in self._reliefs)

    def values(self, payload: float, target: np.ndarray | None) -> bytes:
        """The columns as float32; without a target, the tip in its place."""
        row, n = self._row, self._n
        row[:n] = self._simulator.values[self._take]
        if self.knows_power:
            row[n] = self.power
            n += 1
        row[n], row[n + 1 : n + 4] = payload, self.tip if target is None else target
        if self._shadow is not None:
            seen = self._shadow.seen(self.tip)
            row[n + 4 : n + 4 + len(seen)] = seen
        if self._tipping is not None:
            row[-len(SEEN) :] = self._tipping.values
        return row.tobytes()
