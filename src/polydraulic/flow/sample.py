"""Evaluate a flow model at many points: maps, databases, error maps."""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.flow.dispatch import FLOW_KINDS, flow_name, flow_step
from polydraulic.machine.pump import Pump, single_circuit
from polydraulic.machine.state import Links
from polydraulic.machine.valve import ValveTables, orifices


class FlowSample(NamedTuple):
    """What a flow model gives at each point; links along the last axis, in the order of `LINKS`."""

    q_in: np.ndarray  # (n_point, 3) m3/s
    k_out: np.ndarray  # (n_point, 3) m3/s/Pa^0.5
    p_pump: np.ndarray  # (n_point, 2) Pa, of the boom's pump and the series pump; 0 where the model does not give it
    q_bypass: np.ndarray  # (n_point, 2) m3/s, what returns from each pump's last bypass to the tank


@driver
def _evaluate(
    model: Any,
    memory: np.ndarray,
    spool: np.ndarray,
    p_in: np.ndarray,
    p_out: np.ndarray,
    q: np.ndarray,
    k: np.ndarray,
    p: np.ndarray,
    bypass: np.ndarray,
) -> None:
    for i in range(spool.shape[0]):
        memory[:] = 0.0
        flows = flow_step(
            model,
            memory,
            Links(spool[i, 0], spool[i, 1], spool[i, 2]),
            Links(p_in[i, 0], p_in[i, 1], p_in[i, 2]),
            Links(p_out[i, 0], p_out[i, 1], p_out[i, 2]),
            0.005,
        )
        q[i, 0], q[i, 1], q[i, 2] = flows.q_in.swing, flows.q_in.boom, flows.q_in.stick
        k[i, 0], k[i, 1], k[i, 2] = flows.k_out.swing, flows.k_out.boom, flows.k_out.stick
        p[i, 0], p[i, 1] = flows.boom.p_pump, flows.series.p_pump
        bypass[i, 0], bypass[i, 1] = flows.boom.q_bypass, flows.series.q_bypass


def sample_flow(model: Any, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray) -> FlowSample:
    """Flows at given spool displacements (m) and line pressures (Pa), each (n_point, 3); every point starts afresh."""
    points = [np.ascontiguousarray(v, dtype=np.float64) for v in (spool, p_in, p_out)]
    n = len(points[0])
    sample = FlowSample(np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 2)), np.empty((n, 2)))
    memory = np.zeros(FLOW_KINDS[flow_name(model)].n_memory(model))
    _evaluate(model, memory, points[0], points[1], points[2], *sample)
    return sample


@driver
def _feed(valve: ValveTables, pump: Pump, points: np.ndarray, q: np.ndarray) -> None:
    for i in range(points.shape[0]):
        fed = Pump(points[i, 0], pump.relief, pump.p_return, pump.limit_start, pump.limit_exponent, pump.log_least)
        q[i] = single_circuit(orifices(points[i, 1], valve), points[i, 2], fed).q_in


def sample_fed(valve: ValveTables, pump: Pump, points: np.ndarray) -> np.ndarray:
    """Flow into the actuator behind one valve that is fed by a given flow, (n_point,) in m3/s.

    Parameters
    ----------
    valve : ValveTables
    pump : Pump
        Its relief and return pressures count, not its flow.
    points : (n_point, 3) array
        Flow that reaches the valve in m3/s, spool displacement in m, pressure at the pressurised port in Pa.
    """
    q = np.empty(len(points))
    _feed(valve, pump._replace(log_least=0.0), np.ascontiguousarray(points), q)
    return q
