"""The whole swap mechanism: one table of flow models, each a builder of what the text of a machine's step reads.

A flow model names the page of flows that stands in that text, so that the step is written once and compiled once for each of them. To
add a model: a page, a builder, and one row here (docs/extending.md).
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.flow.iterative import iterative_flow
from polydraulic.flow.layout.model import LayoutFlow, check_machine, exact_flow
from polydraulic.flow.lookup import lookup_flow
from polydraulic.flow.polynomial import fine_flow, neural_flow, polynomial_flow
from polydraulic.flow.pressure import pressure_flow
from polydraulic.flow.residual import residual_flow
from polydraulic.flow.stiff import stiff_flow
from polydraulic.flow.tlm import tlm_flow
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine

FlowModel = LayoutFlow  # what builders give and `simulate` takes

FLOW_KINDS: dict[str, Callable[..., FlowModel]] = {
    "exact": exact_flow,
    "iterative": iterative_flow,
    "stiff": stiff_flow,
    "tlm": tlm_flow,
    "lookup": lookup_flow,
    "polynomial": polynomial_flow,
    "polynomial-fine": fine_flow,
    "neural": neural_flow,
    "pressure": pressure_flow,
    "residual": residual_flow,
}


def build_flow(name: str, machine: LayoutMachine | str | Path, **options: Any) -> FlowModel:
    """Build a flow model by name.

    Parameters
    ----------
    name : str
        A key of `FLOW_KINDS`.
    machine : LayoutMachine, or name or path of a parameter set
    **options
        Settings of that model's builder; ``models=[...]``, networks, for ``"polynomial"`` and ``"neural"``.

    Raises
    ------
    InputError
        If there is no such model, or none for the circuits of this machine.
    """
    if name not in FLOW_KINDS:
        raise InputError(f"unknown flow model {name!r}; choose one of {sorted(FLOW_KINDS)}")
    return FLOW_KINDS[name](as_machine(machine), **options)


def layout_flow(flow: str | FlowModel, machine: LayoutMachine) -> FlowModel:
    """Return a flow model that is given, if it is one for this machine, or build the one of that name."""
    if isinstance(flow, str):
        flow = build_flow(flow, machine)
    if not isinstance(flow, LayoutFlow):
        raise InputError(f"{type(flow).__name__} is not a flow model; choose one of {sorted(FLOW_KINDS)}")
    check_machine(flow, machine)
    return flow
