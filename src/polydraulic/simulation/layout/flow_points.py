"""A flow model of a machine by itself: its flows at any points."""

from typing import NamedTuple

import numpy as np

from polydraulic.flow.dispatch import FlowModel, layout_flow
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.module import layout_module
from polydraulic.simulation.layout.prepare import valves_of


class FlowSample(NamedTuple):
    """Flows at points; functions and circuits stand in the machine's order.

    Attributes
    ----------
    q_in : (n_point, n_function) array, m3/s
    k_out : (n_point, n_function) array, m3/s/Pa^0.5
    p_pump : (n_point, n_circuit) array, Pa
        0 where the flow model does not give it.
    q_bypass : (n_point, n_circuit) array, m3/s
        What returns to the tank through the last valve.
    """

    q_in: np.ndarray
    k_out: np.ndarray
    p_pump: np.ndarray
    q_bypass: np.ndarray


def sample_flow(
    machine: LayoutMachine, flow: str | FlowModel, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray
) -> FlowSample:
    """Flows of a machine's circuits; every point starts afresh.

    Parameters
    ----------
    machine : LayoutMachine
    flow : str or flow model
    spool : (n_point, n_function) array, m
    p_in, p_out : (n_point, n_function) array, Pa
        At the pressurised ports and at the outlets.
    """
    model = layout_flow(flow, machine)
    module, of = layout_module(machine, flow=model.kernels), columns_of(machine, stores_oil=model.stores_oil)
    points = [np.ascontiguousarray(values, dtype=np.float64) for values in (spool, p_in, p_out)]
    rows = np.zeros((len(points[0]), len(of.columns)))
    module.sample_flows(valves_of(machine, module, model), np.zeros(model.n_memory), *points, rows)
    found = (
        rows[:, [of.place[f"{name}.{what}"] for name in names]]
        for names, what in (
            (machine.names, "q_in"),
            (machine.names, "q_out"),
            ([c.name for c in machine.circuits], "p_pump"),
            ([c.name for c in machine.circuits], "q_bypass"),
        )
    )
    return FlowSample(*found)
