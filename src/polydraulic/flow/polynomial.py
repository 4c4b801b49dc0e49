"""Polynomial flow: networks by region in place of orifice areas and pump pressure (thesis 4.2).

The input flow is learnt from spool travel and input line pressure, the output flow from spool displacement and
sqrt(P_o - P_e). Neither orifice areas nor the pump pressure appear; the flow of the pump must be known.
"""

from collections.abc import Sequence
from importlib.resources import files
from math import sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.exact import constant_boom_pump
from polydraulic.flow.interface import OK, OUT_OF_DOMAIN, Flows
from polydraulic.machine.pump import Circuit, Pump
from polydraulic.machine.state import Links
from polydraulic.networks import Model, NetworkTable, Variable, parse_models
from polydraulic.networks.model import pack_models
from polydraulic.networks.partition import Regions, choose
from polydraulic.networks.table import evaluate
from polydraulic.parameters import Machine

# What a model must be called, and read, to take its place in the circuit (SI units).
Q_IN = (Variable("boom.q_in", "m3/s"), (Variable("boom.travel", "m"), Variable("boom.p_in", "Pa")))
Q_OUT = (Variable("boom.q_out", "m3/s"), (Variable("boom.spool", "m"), Variable("boom.root_p_out", "Pa^0.5")))
_SMALLEST_ROOT = 1.0  # Pa^0.5; below it the outlet conductance no longer follows from flow / root


class PolynomialFlow(NamedTuple):
    """Networks for input and output flow in one table, and the largest pressures they were trained for."""

    table: NetworkTable
    q_in: Regions
    q_out: Regions
    p_in_high: float
    root_p_out_high: float
    boom_pump: Pump


def polynomial_flow(machine: Machine, *, models: Sequence[Model] | None = None) -> PolynomialFlow:
    """Flow model from trained networks.

    Parameters
    ----------
    machine : Machine
    models : sequence of Model, optional
        Must hold ``boom.q_in`` (of ``boom.travel``, ``boom.p_in``) and ``boom.q_out`` (of ``boom.spool``,
        ``boom.root_p_out``), in SI. If not given, the networks that come with the package.

    Raises
    ------
    InputError
        If a model is missing or reads other inputs.
    """
    q_in, q_out = (choose_model(shipped_models() if models is None else models, *need) for need in (Q_IN, Q_OUT))
    (regions_in, regions_out), table = pack_models([q_in, q_out])
    p_in_high, root_high = (float(model.domain()[1, 1]) for model in (q_in, q_out))
    return PolynomialFlow(table, regions_in, regions_out, p_in_high, root_high, constant_boom_pump(machine))


def shipped_models() -> list[Model]:
    """Networks that come with the package, trained on the boom circuit of ``cat215b``."""
    source = files("polydraulic.flow") / "trained" / "boom.json"
    return parse_models(source.read_text(encoding="utf-8"), "trained/boom.json")


def choose_model(models: Sequence[Model], output: Variable, inputs: tuple[Variable, ...]) -> Model:
    """Return the model of an output, if it reads what the circuit offers in the units of the circuit."""
    found = [model for model in models if model.output.name == output.name]
    if len(found) != 1:
        given = [model.output.name for model in models]
        raise InputError(
            f"the flow model needs one model of {output.name!r}; given are {given}: fit it or add its file"
        )
    names = tuple(variable.name for variable in found[0].inputs)
    needed = tuple(variable.name for variable in inputs)
    if names != needed:
        raise InputError(
            f"the model of {output.name!r} reads {names}; the circuit needs one of {needed}, in this order"
        )
    for variable, need in zip((found[0].output, *found[0].inputs), (output, *inputs), strict=True):
        if variable.unit not in ("", need.unit):
            raise InputError(
                f"the model of {output.name!r} has {variable}; the circuit computes in SI: fit it on {need}"
            )
    return found[0]


@kernel
def polynomial_step(
    model: PolynomialFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float
) -> Flows:
    """Evaluate one input-flow and one output-flow network; `memory` is their scratch."""
    pump = model.boom_pump
    memory[0] = abs(spool.boom)
    memory[1] = p_in.boom
    q_in = evaluate(model.table, choose(model.q_in, memory), memory)
    q_in = min(max(q_in, 0.0), pump.flow)

    root = sqrt(max(p_out.boom - pump.p_return, 0.0))
    memory[0] = spool.boom
    memory[1] = root
    q_out = evaluate(model.table, choose(model.q_out, memory), memory)
    k_out = max(q_out, 0.0) / max(root, _SMALLEST_ROOT)

    inside = p_in.boom <= model.p_in_high and root <= model.root_p_out_high
    circuit = Circuit(pump.flow, pump.flow - q_in, 0.0, 0.0)
    return Flows(
        Links(0.0, q_in, 0.0),
        Links(0.0, k_out, 0.0),
        circuit,
        Circuit(0.0, 0.0, 0.0, 0.0),
        0.0,
        OK if inside else OUT_OF_DOMAIN,
    )
