"""Networks in place of the valves of one circuit: the records and kernels that the text of a machine is written around."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.machine.pump import Pump
from polydraulic.networks.model.partition import Regions, choose
from polydraulic.networks.model.table import NetworkTable, evaluate

_SMALLEST_ROOT = 1.0  # Pa^0.5; below it the outlet conductance no longer follows from flow / root


class ValveNetworks(NamedTuple):
    """Which networks stand for a valve, and how far they know their inputs; for a missing mode there is a constant, never the least.

    Attributes
    ----------
    q_in : Regions
        At constant flow of the pump alone, or in all modes.
    relief, limited : Regions
        With the relief valve open, and at the torque limit. `relief` is the conductance of a first inlet.
    k_out : Regions
    cascade : bool
        Whether `q_in` reads what the valves before this one leave.
    by_root : bool
        Whether `k_out` gives a flow, of spool and root of the pressure drop.
    closes : float, m
        Travel beyond which the valve passes nothing on.
    travel_high, p_high, root_high : float
        Largest inputs for which the networks were trained.
    """

    q_in: Regions
    relief: Regions
    limited: Regions
    k_out: Regions
    cascade: bool
    by_root: bool
    closes: float
    travel_high: float
    p_high: float
    root_high: float


class PassedNetworks(NamedTuple):
    """Which networks give what passes the first of several valves, where the pump does not deliver its full flow."""

    relief: Regions
    limited: Regions


@kernel
def network_value(table: NetworkTable, regions: Regions, memory: np.ndarray) -> float:
    """Value of the network that answers for the inputs in the first places of `memory`, which is scratch."""
    return evaluate(table, choose(regions, memory), memory)


@kernel
def or_less(q: float, table: NetworkTable, regions: Regions, memory: np.ndarray) -> float:
    """The least of a flow and of that of another mode; where nothing flows in one, no other is less."""
    return min(q, network_value(table, regions, memory)) if q > 0.0 else 0.0


@kernel
def entering(q: float, table: NetworkTable, k_in: Regions, memory: np.ndarray, p: float, pump: Pump) -> float:
    """Flow into the first line at pressure p: the least of q, of the flow with the relief valve open, and of the pump's."""
    k = network_value(table, k_in, memory) if q > 0.0 else 0.0
    return min(max(q, 0.0), min(k * sqrt(max(pump.relief - p, 0.0)), pump.flow))


@kernel
def root_drop(p: float, p_rest: float) -> float:
    """Root of a pressure difference, 0 where it is negative."""
    return sqrt(max(p - p_rest, 0.0))


@kernel
def leaving(table: NetworkTable, valve: ValveNetworks, memory: np.ndarray, spool: float, root: float) -> float:
    """Conductance of an outlet."""
    memory[0] = spool
    memory[1] = root
    k = network_value(table, valve.k_out, memory)
    return max(k / max(root, _SMALLEST_ROOT) if valve.by_root else k, 0.0)
