"""Evaluate a flow model of the boom circuit at many points: maps, databases, error maps."""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.flow.dispatch import FLOW_KINDS, flow_name, flow_step
from polydraulic.machine.state import Links


class FlowSample(NamedTuple):
    """Flow of the boom's valve at each point, arrays of shape (n_point,)."""

    q_in: np.ndarray  # m3/s
    k_out: np.ndarray  # m3/s/Pa^0.5
    p_pump: np.ndarray  # Pa, 0 where the model does not give it


@driver
def _evaluate(
    model: Any, memory: np.ndarray, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray, out: np.ndarray
) -> None:
    for i in range(spool.shape[0]):
        flows = flow_step(
            model,
            memory,
            Links(0.0, spool[i], 0.0),
            Links(0.0, p_in[i], 0.0),
            Links(0.0, p_out[i], 0.0),
            0.005,
        )
        out[0, i], out[1, i], out[2, i] = flows.q_in.boom, flows.k_out.boom, flows.boom.p_pump


def sample_flow(model: Any, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray) -> FlowSample:
    """Flows at given spool displacements (m) and line pressures (Pa); the arguments broadcast."""
    points = [np.ascontiguousarray(v, dtype=np.float64) for v in np.broadcast_arrays(spool, p_in, p_out)]
    out = np.empty((3, points[0].size))
    memory = np.zeros(FLOW_KINDS[flow_name(model)].n_memory(model))
    x, p, r = (v.ravel() for v in points)
    _evaluate(model, memory, x, p, r, out)
    return FlowSample(*(row.reshape(points[0].shape) for row in out))
