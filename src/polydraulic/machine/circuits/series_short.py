"""One valve on a pump, and two in series, in the form that circuits of any length have."""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.pump import (
    Bracket,
    Circuit,
    Pump,
    limit_series,
    limit_single,
    series_at,
    series_circuit,
    single_at,
    single_circuit,
)
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
def series_1_at(Q: float, k_1: Orifices, p_1: float, pump: Pump) -> Series1:
    """`series_1` on a pump that delivers Q."""
    found = single_at(Q, k_1, p_1, pump)
    return Series1(found.q_in, found.circuit, 0)


@kernel
def series_2_at(Q: float, k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Series2:
    """`series_2` on a pump that delivers Q."""
    found = series_at(Q, k_1, k_2, p_1, p_2, pump)
    return Series2(found.q_first, found.q_second, found.p_between, found.circuit, 0)


@kernel
def limit_series_1(x: Bracket, k_1: Orifices, p_1: float, pump: Pump) -> Bracket:
    """One step towards the torque limit of `series_1`."""
    return limit_single(x, k_1, p_1, pump)


@kernel
def limit_series_2(x: Bracket, k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Bracket:
    """One step towards the torque limit of `series_2`."""
    return limit_series(x, k_1, k_2, p_1, p_2, pump)
