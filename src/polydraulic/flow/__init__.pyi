from .database import boom_table, sample_boom, sample_series
from .dispatch import FLOW_KINDS, FlowKind, FlowModel, flow_name, flow_step, served_links
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
    "FlowModel",
    "Flows",
    "boom_table",
    "exact_flow",
    "flow_name",
    "flow_step",
    "iterative_flow",
    "lookup_flow",
    "neural_flow",
    "polynomial_flow",
    "pressure_flow",
    "sample_boom",
    "sample_series",
    "served_links",
    "stiff_flow",
    "table_bytes",
    "tlm_flow",
]
