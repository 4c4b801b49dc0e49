from .dispatch import FLOW_KINDS, FlowKind, flow_name, flow_step, served_links
from .exact import exact_flow
from .interface import NOT_CONVERGED, OK, OUT_OF_DOMAIN, Flows
from .iterative import iterative_flow
from .lookup import lookup_flow, table_bytes
from .polynomial import neural_flow, polynomial_flow
from .pressure import pressure_flow
from .stiff import stiff_flow
from .tlm import tlm_flow

__all__ = [
    "FLOW_KINDS",
    "NOT_CONVERGED",
    "OK",
    "OUT_OF_DOMAIN",
    "FlowKind",
    "Flows",
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
