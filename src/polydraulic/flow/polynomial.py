"""Networks by region in place of orifice areas and pump pressures (thesis 4.2, 5.1): polynomials, or perceptrons.

Inlets: the boom's flow from its spool travel and line pressure; the flows of swing and stick, whose valves stand in
series, in one of two arrangements. In "direct" both read both travels and both pressures (thesis Table 3). In "cascade"
the stick's network reads the flow that the swing leaves, as its valve does. Outlets: the conductance Q_pop(x) of Eq. (7) from
the spool alone, or the thesis' output flow of the boom from spool and sqrt(P_o - P_e). Neither orifice areas nor the
pump pressure appear; flow and relief setting of the pumps must be known: nothing enters a line at relief pressure.

A flow is the least of the pump's modes (`places`). Where modes have networks of their own, those of the inlets know constant
flow alone; with the relief valve open the inlets of boom and swing are conductances k_in(x), and the stick's flow depends on
both travels and sqrt(P_relief - P_i).
"""

from collections.abc import Sequence
from importlib.resources import files
from math import sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.interface import OK, OUT_OF_DOMAIN, Flows
from polydraulic.flow.network_slots import (
    BOOM_IN,
    BOOM_LIMITED,
    BOOM_OUT,
    BOTH,
    PASSED,
    STICK_LIMITED,
    STICK_RELIEF,
    SWING_LIMITED,
    Place,
    choose_model,
    k_in,
    k_out,
    q_in,
)
from polydraulic.machine.pump import Circuit, Pump, prepare_pump
from polydraulic.machine.state import Links
from polydraulic.networks.model.model import Model, Variable, pack_models
from polydraulic.networks.model.model_file import parse_models
from polydraulic.networks.model.partition import Regions, choose
from polydraulic.networks.model.table import Network, NetworkTable, evaluate, work_size
from polydraulic.parameters.load import as_excavator
from polydraulic.parameters.schema import LINKS, Machine

ARRANGEMENTS = ("cascade", "direct")
TRAINED_ON = "cat215b"
_SMALLEST_ROOT = 1.0  # Pa^0.5; below it the outlet conductance no longer follows from flow / root


class Serves(NamedTuple):
    """Links for which there are networks."""

    swing: bool
    boom: bool
    stick: bool


class Inlets(NamedTuple):
    """Which networks give the input flows, at constant flow alone or in all modes."""

    boom: Regions
    swing: Regions
    stick: Regions
    cascade: bool  # whether the stick's reads the flow that the swing leaves


class Others(NamedTuple):
    """Which networks give the flows of the other modes; in place of a missing one there is a constant, never the least."""

    boom_k_in: Regions
    swing_k_in: Regions
    stick_relief: Regions
    boom_limited: Regions
    swing_limited: Regions
    stick_limited: Regions


class Outlets(NamedTuple):
    """Which networks give the outlets."""

    swing: Regions
    boom: Regions
    stick: Regions
    boom_by_root: bool  # whether the boom's gives a flow, of spool and root of the pressure drop


class NetworkFlow(NamedTuple):
    """All networks in one table, the largest inlet pressures for which they were trained, and what must be known besides."""

    table: NetworkTable
    inlets: Inlets
    others: Others
    outlets: Outlets
    p_high: Links
    root_high: float
    serves: Serves
    swing_closes: float  # travel in m beyond which the first valve passes nothing on
    boom_pump: Pump
    series_pump: Pump


class PolynomialFlow(NamedTuple):
    """Polynomial networks."""

    networks: NetworkFlow


class NeuralFlow(NamedTuple):
    """Perceptrons in the same places."""

    networks: NetworkFlow


def polynomial_flow(
    machine: Machine | str | Path, *, models: Sequence[Model] | None = None, arrangement: str = "cascade"
) -> PolynomialFlow:
    """Flow model from polynomial networks.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
        Its pump flows and relief setting are used; a torque limit is known only to networks that were trained with one.
    models : sequence of Model, optional
        In SI: ``boom.q_in``, ``swing.q_in``, ``stick.q_in`` and ``boom.k_out`` (or ``boom.q_out``), ``swing.k_out``,
        ``stick.k_out``. Those of the boom alone, or of swing and stick alone, serve runs that move nothing else. For
        modes of their own also ``boom.k_in``, ``swing.k_in``, ``stick.q_in_relief``, and for the torque limit
        ``boom.q_in_limited``, ``swing.q_in_limited``, ``stick.q_in_limited``; each may be missing. If no models are
        given, the networks that come with the package; they know the torque limit where the machine has one.
    arrangement : {"cascade", "direct"}
        Which of the package's networks; given models say it by what ``stick.q_in`` reads.

    Raises
    ------
    InputError
        If a model is missing or reads other inputs, or there is no such arrangement; without models, if pumps, spools or
        valves are not those that the package's networks were trained on.
    """
    machine = as_excavator(machine)
    if arrangement not in ARRANGEMENTS:
        raise InputError(f"arrangement = {arrangement!r}: choose one of {ARRANGEMENTS}")
    if models is None:
        _check_circuits(machine)
        models = shipped_models(arrangement, limited=machine.pumps.torque_limit_enabled)
    return PolynomialFlow(network_flow(machine, models))


def neural_flow(machine: Machine | str | Path, *, models: Sequence[Model] | None = None) -> NeuralFlow:
    """Flow model from perceptrons.

    Parameters
    ----------
    machine, models
        As for `polynomial_flow`.
    """
    machine = as_excavator(machine)
    if models is None:
        _check_circuits(machine)
        models = shipped_models("neural")
    return NeuralFlow(network_flow(machine, models))


def network_flow(machine: Machine, models: Sequence[Model]) -> NetworkFlow:
    """Put networks into their places."""
    given = {model.output.name for model in models}
    serves = Serves(*(any(name.startswith(f"{link}.") for name in given) for link in LINKS))
    if not (serves.boom or (serves.swing and serves.stick)):
        raise InputError(
            f"given are models of {sorted(given)}; a flow model needs those of the boom, or of swing and stick, or all"
        )
    chosen: list[Model] = []

    def place(needed: bool, *alternatives: Place, otherwise: Model = _NOTHING) -> Model:
        chosen.append(choose_model(models, *alternatives) if needed else otherwise)
        return chosen[-1]

    by_link = dict(zip(LINKS, serves, strict=True))
    boom_in = place(serves.boom, BOOM_IN)
    swing_in = place(serves.swing, (q_in("swing"), BOTH))
    stick_in = place(serves.stick, (q_in("stick"), PASSED), (q_in("stick"), BOTH))
    outs = [
        place(by_link[link], (k_out(link), (Variable(f"{link}.spool", "m"),)), *([BOOM_OUT] if link == "boom" else []))
        for link in LINKS
    ]
    for other in (k_in("boom"), k_in("swing"), STICK_RELIEF, BOOM_LIMITED, SWING_LIMITED, STICK_LIMITED):
        place(other[0].name in given, other, otherwise=_NEVER_LEAST)
    regions, table = pack_models(chosen)
    p_high = Links(
        *(_highest(model, link) for model, link in ((swing_in, "swing"), (boom_in, "boom"), (stick_in, "stick")))
    )
    return NetworkFlow(
        table=table,
        inlets=Inlets(regions[0], regions[1], regions[2], len(stick_in.inputs) == len(PASSED)),
        others=Others(*regions[6:]),
        outlets=Outlets(regions[3], regions[4], regions[5], len(outs[1].inputs) == 2),
        p_high=p_high,
        root_high=float(outs[1].domain()[1, 1]) if len(outs[1].inputs) == 2 else np.inf,
        serves=serves,
        swing_closes=machine.spool.bypass_closed,
        boom_pump=prepare_pump(machine, machine.pumps.boom_flow),
        series_pump=prepare_pump(machine, machine.pumps.series_flow),
    )


def shipped_models(name: str = "cascade", *, limited: bool = False) -> list[Model]:
    """Networks that come with the package, trained on the circuits of `TRAINED_ON`.

    Parameters
    ----------
    name : {"cascade", "direct", "neural"}
    limited : bool
        Also those of the torque limit; they go with the cascade and with direct networks.
    """
    parts = ["outlets", *(["inlets"] if name in ARRANGEMENTS else []), name, *(["limited"] if limited else [])]
    found = []
    for file in (f"{part}.json" for part in parts):
        source = files("polydraulic.flow") / "trained" / file
        found += parse_models(source.read_text(encoding="utf-8"), f"trained/{file}")
    return found


def _check_circuits(machine: Machine) -> None:
    """Refuse the package's networks to circuits that they were not trained on."""
    trained, limit = as_excavator(TRAINED_ON), machine.pumps.torque_limit_enabled
    known = _circuits(trained) | {"pumps.torque_limit_enabled": limit}
    for name, value in _circuits(machine).items():
        if value != known[name] and (limit or not name.startswith("pumps.torque_limit")):
            raise InputError(
                f"{name} = {value}, and {known[name]} in {TRAINED_ON}, whose circuits the package's networks were trained on: "
                "train networks for this machine (polydraulic train --out FOLDER --machine MACHINE) and give them as models"
            )


def _circuits(machine: Machine) -> dict[str, object]:
    """Parameters that decide the flows, by name."""
    parts: dict[str, Any] = {"pumps": machine.pumps, "spool": machine.spool, "tank": machine.tank}
    parts |= {f"{link}.valve": getattr(machine, link).valve for link in LINKS}
    return {f"{part}.{name}": value for part, values in parts.items() for name, value in values._asdict().items()}


def networks_serve(model: PolynomialFlow | NeuralFlow) -> tuple[str, ...]:
    """Links for which a flow model has networks."""
    return tuple(link for link, has in zip(LINKS, model.networks.serves, strict=True) if has)


def scratch(model: PolynomialFlow | NeuralFlow) -> int:
    """Floats that a step needs as scratch."""
    return max(len(BOTH), work_size(model.networks.table))


def _constant(y: float) -> Model:
    return Model((Variable("none"),), Variable("none"), (Network((), (0.0,), (1.0,), (0.0,), (0.0,), y, 1.0),))


_NOTHING = _constant(0.0)
_NEVER_LEAST = _constant(1e6)  # as a flow, and as a conductance, a hair below relief pressure


def _highest(model: Model, link: str) -> float:
    """Largest inlet pressure of a link in the domain of its input-flow model."""
    names = [variable.name for variable in model.inputs]
    return float(model.domain()[names.index(f"{link}.p_in"), 1]) if f"{link}.p_in" in names else np.inf


@kernel
def _inlet(flow: NetworkFlow, regions: Regions, memory: np.ndarray, a: float, b: float, c: float, d: float) -> float:
    """Value of a network of up to four inputs."""
    memory[0] = a
    memory[1] = b
    memory[2] = c
    memory[3] = d
    return evaluate(flow.table, choose(regions, memory), memory)


@kernel
def _or_less(
    q: float, flow: NetworkFlow, regions: Regions, memory: np.ndarray, a: float, b: float, c: float, d: float
) -> float:
    """The least of a flow and of that of another mode; where nothing flows in one, no other is less."""
    return min(q, _inlet(flow, regions, memory, a, b, c, d)) if q > 0.0 else 0.0


@kernel
def _entering(q: float, k: float, p: float, pump: Pump) -> float:
    """Flow into a line at pressure p: the least of q, of the flow with the relief valve open, and of the pump's."""
    return min(max(q, 0.0), min(k * sqrt(max(pump.relief - p, 0.0)), pump.flow))


@kernel
def network_step(flow: NetworkFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links) -> Flows:
    """Evaluate the networks of all inlets and outlets; `memory` is their scratch."""
    inlets, others, outlets = flow.inlets, flow.others, flow.outlets
    swing, boom, stick = abs(spool.swing), abs(spool.boom), abs(spool.stick)
    Q, below = flow.series_pump.flow, sqrt(max(flow.series_pump.relief - p_in.stick, 0.0))

    q_boom = _inlet(flow, inlets.boom, memory, boom, p_in.boom, 0.0, 0.0)
    q_boom = _or_less(q_boom, flow, others.boom_limited, memory, boom, p_in.boom, 0.0, 0.0)
    k = _inlet(flow, others.boom_k_in, memory, boom, 0.0, 0.0, 0.0) if q_boom > 0.0 else 0.0
    q_boom = _entering(q_boom, k, p_in.boom, flow.boom_pump)

    q_swing = _inlet(flow, inlets.swing, memory, swing, stick, p_in.swing, p_in.stick)
    q_swing = _or_less(q_swing, flow, others.swing_limited, memory, swing, stick, p_in.swing, p_in.stick)
    k = _inlet(flow, others.swing_k_in, memory, swing, 0.0, 0.0, 0.0) if q_swing > 0.0 else 0.0
    q_swing = _entering(q_swing, k, p_in.swing, flow.series_pump)

    passed = Q - q_swing if swing <= flow.swing_closes else 0.0
    q_stick = (
        _inlet(flow, inlets.stick, memory, passed, stick, p_in.stick, 0.0)
        if inlets.cascade
        else _inlet(flow, inlets.stick, memory, swing, stick, p_in.swing, p_in.stick)
    )
    q_stick = _or_less(q_stick, flow, others.stick_relief, memory, swing, stick, below, 0.0)
    q_stick = _or_less(q_stick, flow, others.stick_limited, memory, swing, stick, p_in.swing, p_in.stick)
    q_stick = min(max(q_stick, 0.0), passed) if p_in.stick < flow.series_pump.relief else 0.0

    root = sqrt(max(p_out.boom - flow.boom_pump.p_return, 0.0))
    k_swing = _inlet(flow, outlets.swing, memory, spool.swing, 0.0, 0.0, 0.0)
    k_boom = _inlet(flow, outlets.boom, memory, spool.boom, root, 0.0, 0.0)
    k_boom = k_boom / max(root, _SMALLEST_ROOT) if outlets.boom_by_root else k_boom
    k_stick = _inlet(flow, outlets.stick, memory, spool.stick, 0.0, 0.0, 0.0)

    high = flow.p_high
    inside = p_in.swing <= high.swing and p_in.boom <= high.boom and p_in.stick <= high.stick and root <= flow.root_high
    return Flows(
        Links(q_swing, q_boom, q_stick),
        Links(max(k_swing, 0.0), max(k_boom, 0.0), max(k_stick, 0.0)),
        Circuit(flow.boom_pump.flow, flow.boom_pump.flow - q_boom, 0.0, 0.0, 0.0),
        Circuit(Q, Q - q_swing - q_stick, 0.0, 0.0, 0.0),
        0.0,
        OK if inside else OUT_OF_DOMAIN,
    )


@kernel
def polynomial_step(
    model: PolynomialFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float
) -> Flows:
    """Evaluate polynomial networks."""
    return network_step(model.networks, memory, spool, p_in, p_out)


@kernel
def neural_step(model: NeuralFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float) -> Flows:
    """Evaluate perceptrons."""
    return network_step(model.networks, memory, spool, p_in, p_out)
