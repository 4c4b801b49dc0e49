"""Slopes of one valve on a pump, and of two in series, in the form that circuits of any length have."""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuit_slopes import series_slopes, single_slopes
from polydraulic.machine.circuits.series.short import Series1, Series2
from polydraulic.machine.pump import Pump
from polydraulic.machine.valve import Orifices


class Slopes1(NamedTuple):
    """Slope of the inlet flow over its port pressure, m3/s/Pa, and over its spool, m2/s."""

    by_p_1_1: float
    by_x_1_1: float


class Slopes2(NamedTuple):
    """Slopes of inlet flows: by_p_i_j and by_x_i_j are those of valve i over port pressure and spool of valve j."""

    by_p_1_1: float  # m3/s/Pa
    by_p_1_2: float
    by_p_2_1: float
    by_p_2_2: float
    by_x_1_1: float  # m2/s
    by_x_1_2: float
    by_x_2_1: float
    by_x_2_2: float


@kernel
def series_1_slopes(k_1: Orifices, d_1: Orifices, s: Series1, pump: Pump) -> Slopes1:
    """Slopes at a solution `s` of `series_1`; d_1 are the slopes of the conductances k_1 over the spool."""
    found = single_slopes(k_1, d_1, s.q_in_1, s.circuit, pump)
    return Slopes1(found.by_p, found.by_spool)


@kernel
def series_2_slopes(k_1: Orifices, k_2: Orifices, d_1: Orifices, d_2: Orifices, s: Series2, pump: Pump) -> Slopes2:
    """Slopes at a solution `s` of `series_2`; d_i are the slopes of the conductances k_i over the spool."""
    found = series_slopes(k_1, k_2, d_1, d_2, s.q_in_1, s.q_in_2, s.circuit, pump)
    return Slopes2(
        found.first_by_p,
        found.other_by_p,
        found.other_by_p,
        found.second_by_p,
        found.first_by_first,
        found.first_by_second,
        found.second_by_first,
        found.second_by_second,
    )
