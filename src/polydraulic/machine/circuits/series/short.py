"""One valve on a pump, and two in series, in the form that circuits of any length have (Eqs 1-3, 8-13)."""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.series.check import PROVED, UNPROVED
from polydraulic.machine.circuits.series.torque_limit import Limited, limited_1, limited_2
from polydraulic.machine.pump import Circuit, Pump, Series, series_at, series_from, single_at
from polydraulic.machine.valve import Orifices, orifice_flow


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
def series_1_at(Q: float, k_1: Orifices, p_1: float, pump: Pump) -> Series1:
    """`series_1` on a pump that delivers Q; a closed form, which is always right."""
    found = single_at(Q, k_1, p_1, pump)
    return Series1(found.q_in, found.circuit, PROVED)


@kernel
def _both(found: Series, status: int) -> Series2:
    return Series2(found.q_first, found.q_second, found.p_between, found.circuit, status)


@kernel
def series_2_at(Q: float, k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Series2:
    """`series_2` on a pump that delivers Q."""
    found = series_at(Q, k_1, k_2, p_1, p_2, pump)
    return _both(found, PROVED)


@kernel
def series_1_limited(x: Limited, k_1: Orifices, p_1: float, pump: Pump) -> Series1:
    """`series_1` with a torque limit, and the pump's flow as it was found."""
    found = single_at(x.q, k_1, p_1, pump)
    return Series1(found.q_in, found.circuit, PROVED if x.still else UNPROVED)


@kernel
def series_2_limited(x: Limited, k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Series2:
    """`series_2` with a torque limit, and the flows of pump and first bypass as they were found.

    No more passes the first bypass than both take at relief, and the second inlet beyond them. Where the second port is at relief, a
    rounding of its pressure lets its inlet pass 3e-8 of the pump's flow, and passes know no pressure better; the drop from relief is exact.
    """
    w = min(x.w, x.both + orifice_flow(k_2.inlet, pump.relief - p_2))
    found = series_from(x.q, w, k_1, k_2, p_1, p_2, pump)
    return _both(found, PROVED if x.still else UNPROVED)


@kernel
def series_1(k_1: Orifices, p_1: float, pump: Pump) -> Series1:
    """Flows with one valve: conductances in m3/s/Pa^0.5, the pressure at the pressurised port in Pa."""
    if pump.log_least < 0.0:
        x = limited_1(k_1, p_1, pump)
        found = series_1_limited(x, k_1, p_1, pump)
    else:
        found = series_1_at(pump.flow, k_1, p_1, pump)
    return found


@kernel
def series_2(k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Series2:
    """Flows with two valves, the first of which has priority."""
    if pump.log_least < 0.0:
        x = limited_2(k_1, k_2, p_1, p_2, pump)
        found = series_2_limited(x, k_1, k_2, p_1, p_2, pump)
    else:
        found = series_2_at(pump.flow, k_1, k_2, p_1, p_2, pump)
    return found
