"""What a flow model gives for one step, whatever its kind."""

from typing import NamedTuple

from polydraulic.machine.pump import Circuit
from polydraulic.machine.state import Links

OK, NOT_CONVERGED, OUT_OF_DOMAIN = 0, 1, 2


class Flows(NamedTuple):
    """Flow through each main valve over one step.

    Attributes
    ----------
    q_in : Links, m3/s
        Into the pressurised port of each actuator.
    k_out : Links, m3/s/Pa^0.5
        Conductance of each outlet: Q_o = k_out sqrt(P_o - P_e). The hose stage solves the outlet implicitly.
    boom : Circuit
        Pump, bypass and relief flow of the boom's circuit.
    series : Circuit
        The same of the circuit of swing and stick; its bypass flow is what has passed both valves.
    p_between : float, Pa
        Pressure between the valves of swing and stick.
    status : int
        OK, NOT_CONVERGED or OUT_OF_DOMAIN.
    """

    q_in: Links
    k_out: Links
    boom: Circuit
    series: Circuit
    p_between: float
    status: int


class FlowSlopes(NamedTuple):
    """Slopes of a model's flows: of the inlets over the pressures at the fed ports (m3/s/Pa) and over the spools (m2/s).

    Swing and stick share a pump, so that each also feels the other; the boom is alone.
    """

    by_own_p: Links
    swing_by_stick_p: float
    stick_by_swing_p: float
    by_own_spool: Links
    swing_by_stick_spool: float
    stick_by_swing_spool: float
    outlet_by_spool: Links  # of k_out, m2/s/Pa^0.5
