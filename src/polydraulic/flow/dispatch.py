"""The whole swap mechanism: one table of flow models, one `flow_step` that chooses by the type of its first argument.

The time loop is written once and compiled once for each type, with the step inlined; in plain Python the choice is a
look-up. To add a model: a NamedTuple, a step kernel, a builder, and one row here (docs/extending.md).
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from polydraulic._kernel import KERNEL_OPTIONS
from polydraulic.errors import InputError
from polydraulic.flow.exact import ExactFlow, exact_flow, exact_slopes, exact_step
from polydraulic.flow.exact_lanes import exact_lanes
from polydraulic.flow.interface import Flows, FlowSlopes
from polydraulic.flow.iterative import IterativeFlow, iterative_flow, iterative_layout, iterative_step
from polydraulic.flow.layout.model import LayoutFlow, check_machine, exact_layout
from polydraulic.flow.layout.networks import layout_networks
from polydraulic.flow.lookup import LookupFlow, lookup_flow, lookup_layout, lookup_step
from polydraulic.flow.polynomial import (
    NeuralFlow,
    PolynomialFlow,
    networks_serve,
    neural_flow,
    neural_step,
    polynomial_flow,
    polynomial_step,
    scratch,
)
from polydraulic.flow.pressure import PressureFlow, pressure_flow, pressure_layout, pressure_step
from polydraulic.flow.stiff import StiffFlow, stiff_flow, stiff_layout, stiff_step
from polydraulic.flow.tlm import TlmFlow, tlm_flow, tlm_layout, tlm_step
from polydraulic.machine.state import Links
from polydraulic.networks.model.table import work_size
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.schema import LINKS, Machine

FlowModel = (
    ExactFlow
    | IterativeFlow
    | StiffFlow
    | TlmFlow
    | LookupFlow
    | PolynomialFlow
    | NeuralFlow
    | PressureFlow
    | LayoutFlow
)  # what builders give and `simulate` takes


class FlowKind(NamedTuple):
    """One way of finding the flows.

    Attributes
    ----------
    model : NamedTuple class of its parameters
    step : kernel (model, memory, spool, p_in, p_out, dt) -> Flows
    build : function (machine, options) -> model
    n_memory : model -> floats that the step keeps or uses as scratch
    balances : whether pump flow = actuators + bypass + relief + stored at every step
    gives_pump_pressure : whether the pump pressure is computed
    links : which links it can serve
    served : model -> links that this model serves, where that depends on it; the others get no flow
    has_state : whether pressures of its own go on from step to step, so that the flows depend on what was before
    lanes : kernel (model, own, rows, whole) that finds the flows of a block of machines side by side; None where a step
        keeps memory or loops as long as its data ask, so that machines must run one by one
    slopes : kernel (model, spool, inside, flows) -> FlowSlopes; None where there is none
    layout : function (machine, options) -> LayoutFlow, for machines that are described by links
    """

    model: type
    step: Callable[..., Flows]
    build: Callable[..., "FlowModel"]
    n_memory: Callable[[Any], int]
    balances: bool
    gives_pump_pressure: bool
    links: tuple[str, ...]
    layout: Callable[..., LayoutFlow]
    served: Callable[[Any], tuple[str, ...]] | None = None
    has_state: bool = False
    lanes: Callable[..., None] | None = None
    slopes: Callable[..., FlowSlopes] | None = None


FLOW_KINDS: dict[str, FlowKind] = {
    "exact": FlowKind(
        ExactFlow,
        exact_step,
        exact_flow,
        lambda model: 1,
        True,
        True,
        LINKS,
        lanes=exact_lanes,
        slopes=exact_slopes,
        layout=exact_layout,
    ),
    "iterative": FlowKind(
        IterativeFlow, iterative_step, iterative_flow, lambda model: 3, True, True, LINKS, layout=iterative_layout
    ),
    "stiff": FlowKind(
        StiffFlow, stiff_step, stiff_flow, lambda model: 4, True, True, LINKS, has_state=True, layout=stiff_layout
    ),
    "tlm": FlowKind(TlmFlow, tlm_step, tlm_flow, lambda model: 7, True, True, LINKS, has_state=True, layout=tlm_layout),
    "lookup": FlowKind(LookupFlow, lookup_step, lookup_flow, lambda model: 1, True, False, LINKS, layout=lookup_layout),
    "polynomial": FlowKind(
        PolynomialFlow,
        polynomial_step,
        polynomial_flow,
        scratch,
        True,
        False,
        LINKS,
        served=networks_serve,
        layout=partial(layout_networks, kind="polynomial"),
    ),
    "neural": FlowKind(
        NeuralFlow,
        neural_step,
        neural_flow,
        scratch,
        True,
        False,
        LINKS,
        served=networks_serve,
        layout=partial(layout_networks, kind="neural"),
    ),
    "pressure": FlowKind(
        PressureFlow,
        pressure_step,
        pressure_flow,
        lambda model: work_size(model.table),
        False,
        True,
        ("boom",),
        layout=pressure_layout,
    ),
}

FLOW_STEPS = {kind.model: kind.step for kind in FLOW_KINDS.values()}
FLOW_LANES = {kind.model: kind.lanes for kind in FLOW_KINDS.values() if kind.lanes is not None}
FLOW_SLOPES = {kind.model: kind.slopes for kind in FLOW_KINDS.values() if kind.slopes is not None}


def flow_step(model: FlowModel, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float) -> Flows:
    """Flow through each main valve over one step; pump and valves are one subsystem, and the model owns both.

    Parameters
    ----------
    model : FlowModel
    memory : (n_memory,) array
        What the model keeps between steps; changed in place.
    spool : Links, m
    p_in, p_out : Links, Pa
        Pressures at the pressurised port and at the outlet of each actuator.
    dt : float, s
    """
    step: Callable[..., Flows] = FLOW_STEPS[type(model)]
    return step(model, memory, spool, p_in, p_out, dt)


@overload(flow_step, jit_options=KERNEL_OPTIONS)
def _flow_step_compiled(model: Any, memory: Any, spool: Any, p_in: Any, p_out: Any, dt: Any) -> Any:
    step = FLOW_STEPS[model.instance_class]

    def chosen(model: Any, memory: Any, spool: Any, p_in: Any, p_out: Any, dt: Any) -> Any:
        return step(model, memory, spool, p_in, p_out, dt)

    return chosen


def flow_slopes(model: Any, spool: Links, inside: Links, flows: Flows) -> FlowSlopes:
    """Slopes of `flow_step` at a solution, of a model that has them.

    Parameters
    ----------
    model : one of the models in `FLOW_SLOPES`
    spool : Links, m
    inside : Links, m
        Spools on the same segments of their tables, but not on a knot: at a knot the slopes of the two sides differ.
    flows : Flows
        The solution.
    """
    slopes: Callable[..., FlowSlopes] = FLOW_SLOPES[type(model)]
    return slopes(model, spool, inside, flows)


@overload(flow_slopes, jit_options=KERNEL_OPTIONS)
def _flow_slopes_compiled(model: Any, spool: Any, inside: Any, flows: Any) -> Any:
    slopes = FLOW_SLOPES[model.instance_class]

    def chosen(model: Any, spool: Any, inside: Any, flows: Any) -> Any:
        return slopes(model, spool, inside, flows)

    return chosen


def flow_lanes(model: Any, own: Any, rows: np.ndarray, whole: bool) -> None:
    """Flows of a block of machines side by side, for models whose kind has `lanes`.

    Parameters
    ----------
    model : flow model
        That of all machines, or one of them where they differ.
    own : None or flat array of rows
        Parameters of each machine where they differ; see `lanes.at`.
    rows : flat array of rows
        Reads SPOOL and P_IN; writes Q_IN, OUTLET and, for `whole`, the pump flows and pressures; see `lanes`.
    whole : bool
        Whether pump flows and pressures are wanted.
    """
    FLOW_LANES[type(model)](model, own, rows, whole)


@overload(flow_lanes, jit_options=KERNEL_OPTIONS)
def _flow_lanes_compiled(model: Any, own: Any, rows: Any, whole: Any) -> Any:
    lanes = FLOW_LANES[model.instance_class]

    def chosen(model: Any, own: Any, rows: Any, whole: Any) -> Any:
        lanes(model, own, rows, whole)

    return chosen


def build_flow(name: str, machine: Machine | LayoutMachine | str | Path, **options: Any) -> FlowModel:
    """Build a flow model by name.

    Parameters
    ----------
    name : str
        A key of `FLOW_KINDS`.
    machine : Machine or LayoutMachine, or name or path of a parameter set
    **options
        Settings of that model's builder; ``models=[...]``, networks, for ``"polynomial"`` and ``"neural"``.

    Raises
    ------
    InputError
        If there is no such model, or none for the layout of this machine.
    """
    if name not in FLOW_KINDS:
        raise InputError(f"unknown flow model {name!r}; choose one of {sorted(FLOW_KINDS)}")
    kind, machine = FLOW_KINDS[name], as_machine(machine)
    if not isinstance(machine, LayoutMachine):
        found: FlowModel = kind.build(machine, **options)
        return found
    return kind.layout(machine, **options)


def as_flow(flow: str | FlowModel, machine: Machine) -> FlowModel:
    """Return a flow model that is given, or build the one of that name."""
    if isinstance(flow, LayoutFlow):
        raise InputError(
            f"the flow model {flow.name!r} is for a machine with the circuits {', '.join(flow.circuits)}, described by links; this one is of the "
            "older form"
        )
    return build_flow(flow, machine) if isinstance(flow, str) else flow


def layout_flow(flow: str | FlowModel, machine: LayoutMachine) -> LayoutFlow:
    """`as_flow` for a machine of any layout."""
    if isinstance(flow, str):
        flow = build_flow(flow, machine)
    if not isinstance(flow, LayoutFlow):
        raise InputError(
            f"{type(flow).__name__} knows the layout of 'cat215b' alone; build_flow(name, machine, ...) makes one for {machine.title!r}"
        )
    check_machine(flow, machine)
    return flow


def flow_name(model: object) -> str:
    """Name under which the class of a flow model, `model`, stands in `FLOW_KINDS`."""
    for name, kind in FLOW_KINDS.items():
        if type(model) is kind.model:
            return name
    raise InputError(f"{type(model).__name__} is not a flow model; choose one of {sorted(FLOW_KINDS)}")


def served_links(model: FlowModel) -> tuple[str, ...]:
    """Links that a flow model serves."""
    kind = FLOW_KINDS[flow_name(model)]
    return kind.links if kind.served is None else kind.served(model)
