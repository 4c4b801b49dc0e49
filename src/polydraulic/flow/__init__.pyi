from .dispatch import FLOW_KINDS, FlowModel
from .interface import NOT_CONVERGED, OK, OUT_OF_DOMAIN
from .iterative import iterative_flow
from .layout.database import circuit_table, sample_circuit
from .layout.model import LayoutFlow, exact_flow
from .lookup import lookup_flow, table_bytes
from .polynomial import neural_flow, polynomial_flow
from .pressure import pressure_flow
from .residual import residual_flow
from .stiff import stiff_flow
from .tlm import tlm_flow
from .training.layout_models import TrainingEffort, train_layout

__all__ = [
    "FLOW_KINDS",
    "NOT_CONVERGED",
    "OK",
    "OUT_OF_DOMAIN",
    "FlowModel",
    "LayoutFlow",
    "TrainingEffort",
    "circuit_table",
    "exact_flow",
    "iterative_flow",
    "lookup_flow",
    "neural_flow",
    "polynomial_flow",
    "pressure_flow",
    "residual_flow",
    "sample_circuit",
    "stiff_flow",
    "table_bytes",
    "tlm_flow",
    "train_layout",
]
