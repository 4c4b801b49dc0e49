from .dispatch import FLOW_KINDS, FlowKind, FlowModel, flow_name, flow_step, served_links
from .exact import exact_flow
from .interface import NOT_CONVERGED, OK, OUT_OF_DOMAIN, Flows
from .iterative import iterative_flow
from .layout.database import circuit_table, sample_circuit
from .layout.model import LayoutFlow
from .lookup import lookup_flow, table_bytes
from .polynomial import neural_flow, polynomial_flow
from .pressure import pressure_flow
from .stiff import stiff_flow
from .tlm import tlm_flow
from .training.layout_models import TrainingEffort, train_layout

__all__ = [
    "FLOW_KINDS",
    "NOT_CONVERGED",
    "OK",
    "OUT_OF_DOMAIN",
    "FlowKind",
    "FlowModel",
    "Flows",
    "LayoutFlow",
    "TrainingEffort",
    "circuit_table",
    "exact_flow",
    "flow_name",
    "flow_step",
    "iterative_flow",
    "lookup_flow",
    "neural_flow",
    "polynomial_flow",
    "pressure_flow",
    "sample_circuit",
    "served_links",
    "stiff_flow",
    "table_bytes",
    "tlm_flow",
    "train_layout",
]
