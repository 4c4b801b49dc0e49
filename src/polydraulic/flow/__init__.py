"""The swappable subsystem: pump and main valves.

Read `interface` (what a model gives), `dispatch` (how one is chosen), then the models: `exact`, `iterative`, `stiff`
and `tlm`, which give pipes and passages a volume, `polynomial` (and neural, the same with perceptrons), `lookup`
(tables), and `pressure`, the historical attempt that fails.
"""

from polydraulic.flow.dispatch import FLOW_KINDS, FlowKind, build_flow, flow_name, flow_step, served_links
from polydraulic.flow.exact import exact_flow
from polydraulic.flow.interface import NOT_CONVERGED, OK, OUT_OF_DOMAIN, Flows
from polydraulic.flow.iterative import iterative_flow
from polydraulic.flow.lookup import lookup_flow, table_bytes
from polydraulic.flow.polynomial import neural_flow, polynomial_flow
from polydraulic.flow.pressure import pressure_flow
from polydraulic.flow.stiff import stiff_flow
from polydraulic.flow.tlm import tlm_flow

__all__ = [
    "FLOW_KINDS",
    "NOT_CONVERGED",
    "OK",
    "OUT_OF_DOMAIN",
    "FlowKind",
    "Flows",
    "build_flow",
    "exact_flow",
    "flow_name",
    "flow_step",
    "iterative_flow",
    "lookup_flow",
    "neural_flow",
    "polynomial_flow",
    "pressure_flow",
    "served_links",
    "stiff_flow",
    "table_bytes",
    "tlm_flow",
]
