"""One valve on a pump, and two in series, in the form that circuits of any length have."""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.pump import Circuit, Pump, series_at, series_circuit, single_at, single_circuit
from polydraulic.machine.valve import Orifices


class Series1(NamedTuple):
    """One actuator on a pump."""

    q_in_1: float
    circuit: Circuit
    status: int


class Series2(NamedTuple):
    """Two actuators on a pump, the second fed by what passes the first valve's bypass."""

    q_in_1: float
    q_in_2: float
    p_between_1: float
    circuit: Circuit
    status: int


@kernel
def series_1(k_1: Orifices, p_1: float, pump: Pump) -> Series1:
    """Flows with one valve; a closed form, which is always right."""
    found = single_circuit(k_1, p_1, pump)
    return Series1(found.q_in, found.circuit, 0)


@kernel
def series_2(k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Series2:
    """Flows with two valves, the first of which has priority."""
    found = series_circuit(k_1, k_2, p_1, p_2, pump)
    return Series2(found.q_first, found.q_second, found.p_between, found.circuit, 0)


@kernel
def free_series_1(k_1: Orifices, p_1: float, pump: Pump) -> Series1:
    """`series_1` as if the pump had no torque limit."""
    found = single_at(pump.flow, k_1, p_1, pump)
    return Series1(found.q_in, found.circuit, 0)


@kernel
def free_series_2(k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Series2:
    """`series_2` as if the pump had no torque limit."""
    found = series_at(pump.flow, k_1, k_2, p_1, p_2, pump)
    return Series2(found.q_first, found.q_second, found.p_between, found.circuit, 0)
