"""Networks by region in place of orifice areas and pump pressures (thesis 4.2, 5.1): polynomials, or perceptrons.

Inlets: the boom's flow from its spool travel and line pressure; the flows of swing and stick, whose valves stand in
series, in one of two arrangements. In "direct" both read both travels and both pressures (thesis Table 3). In "cascade"
the stick's network reads the flow that the swing leaves, as its valve does. Outlets: the conductance Q_pop(x) of Eq. (7) from
the spool alone, or the thesis' output flow of the boom from spool and sqrt(P_o - P_e). Neither orifice areas nor the
pump pressure appear; flow and relief setting of the pumps must be known: nothing enters a line at relief pressure.
"""

from collections.abc import Sequence
from importlib.resources import files
from math import sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.interface import OK, OUT_OF_DOMAIN, Flows
from polydraulic.machine.pump import Circuit, Pump, prepare_pump
from polydraulic.machine.state import Links
from polydraulic.networks import Model, Network, NetworkTable, Variable, parse_models
from polydraulic.networks.model import pack_models
from polydraulic.networks.partition import Regions, choose
from polydraulic.networks.table import evaluate, work_size
from polydraulic.parameters import LINKS, Machine

ARRANGEMENTS = ("cascade", "direct")
_SMALLEST_ROOT = 1.0  # Pa^0.5; below it the outlet conductance no longer follows from flow / root


def travel(link: str) -> Variable:
    """Distance of a link's spool from its centre."""
    return Variable(f"{link}.travel", "m")


def p_in(link: str) -> Variable:
    """Pressure at a link's pressurised port."""
    return Variable(f"{link}.p_in", "Pa")


def q_in(link: str) -> Variable:
    """Flow into a link's pressurised port."""
    return Variable(f"{link}.q_in", "m3/s")


def k_out(link: str) -> Variable:
    """Conductance of a link's outlet."""
    return Variable(f"{link}.k_out", "m3/s/Pa^0.5")


# What a model must be called, and read, to take its place in the circuits (SI units).
BOTH = (travel("swing"), travel("stick"), p_in("swing"), p_in("stick"))
PASSED = (Variable("series.q_passed", "m3/s"), travel("stick"), p_in("stick"))
BOOM_IN = (q_in("boom"), (travel("boom"), p_in("boom")))
BOOM_OUT = (Variable("boom.q_out", "m3/s"), (Variable("boom.spool", "m"), Variable("boom.root_p_out", "Pa^0.5")))


class Serves(NamedTuple):
    """Links for which there are networks."""

    swing: bool
    boom: bool
    stick: bool


class Inlets(NamedTuple):
    """Which networks give the input flows."""

    boom: Regions
    swing: Regions
    stick: Regions
    cascade: bool  # whether the stick's reads the flow that the swing leaves


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
    machine: Machine, *, models: Sequence[Model] | None = None, arrangement: str = "cascade"
) -> PolynomialFlow:
    """Flow model from polynomial networks.

    Parameters
    ----------
    machine : Machine
        Its pump flows are used; a torque limit is known only to networks that were trained with one.
    models : sequence of Model, optional
        In SI: ``boom.q_in``, ``swing.q_in``, ``stick.q_in`` and ``boom.k_out`` (or ``boom.q_out``), ``swing.k_out``,
        ``stick.k_out``. Those of the boom alone, or of swing and stick alone, serve runs that move nothing else. If not
        given, the networks that come with the package.
    arrangement : {"cascade", "direct"}
        Which of the package's networks; given models say it by what ``stick.q_in`` reads.

    Raises
    ------
    InputError
        If a model is missing or reads other inputs, or there is no such arrangement.
    """
    if arrangement not in ARRANGEMENTS:
        raise InputError(f"arrangement = {arrangement!r}: choose one of {ARRANGEMENTS}")
    return PolynomialFlow(network_flow(machine, shipped_models(arrangement) if models is None else models))


def neural_flow(machine: Machine, *, models: Sequence[Model] | None = None) -> NeuralFlow:
    """Flow model from perceptrons.

    Parameters
    ----------
    machine, models
        As for `polynomial_flow`.
    """
    return NeuralFlow(network_flow(machine, shipped_models("neural") if models is None else models))


def network_flow(machine: Machine, models: Sequence[Model]) -> NetworkFlow:
    """Put networks into their places."""
    given = {model.output.name for model in models}
    serves = Serves(*(any(name.startswith(f"{link}.") for name in given) for link in LINKS))
    if not (serves.boom or (serves.swing and serves.stick)):
        raise InputError(
            f"given are models of {sorted(given)}; a flow model needs those of the boom, or of swing and stick, or all"
        )
    chosen: list[Model] = []

    def place(needed: bool, *alternatives: tuple[Variable, tuple[Variable, ...]]) -> Model:
        chosen.append(choose_model(models, *alternatives) if needed else _NOTHING)
        return chosen[-1]

    by_link = dict(zip(LINKS, serves, strict=True))
    boom_in = place(serves.boom, BOOM_IN)
    swing_in = place(serves.swing, (q_in("swing"), BOTH))
    stick_in = place(serves.stick, (q_in("stick"), PASSED), (q_in("stick"), BOTH))
    outs = [
        place(by_link[link], (k_out(link), (Variable(f"{link}.spool", "m"),)), *([BOOM_OUT] if link == "boom" else []))
        for link in LINKS
    ]
    regions, table = pack_models(chosen)
    p_high = Links(
        *(_highest(model, link) for model, link in ((swing_in, "swing"), (boom_in, "boom"), (stick_in, "stick")))
    )
    return NetworkFlow(
        table=table,
        inlets=Inlets(regions[0], regions[1], regions[2], len(stick_in.inputs) == len(PASSED)),
        outlets=Outlets(regions[3], regions[4], regions[5], len(outs[1].inputs) == 2),
        p_high=p_high,
        root_high=float(outs[1].domain()[1, 1]) if len(outs[1].inputs) == 2 else np.inf,
        serves=serves,
        swing_closes=machine.spool.bypass_closed,
        boom_pump=prepare_pump(machine, machine.pumps.boom_flow),
        series_pump=prepare_pump(machine, machine.pumps.series_flow),
    )


def shipped_models(name: str = "cascade") -> list[Model]:
    """Networks that come with the package, trained on the circuits of ``cat215b``: ``cascade``, ``direct`` or ``neural``."""
    found = []
    for file in ("outlets.json", f"{name}.json"):
        source = files("polydraulic.flow") / "trained" / file
        found += parse_models(source.read_text(encoding="utf-8"), f"trained/{file}")
    return found


def choose_model(models: Sequence[Model], *alternatives: tuple[Variable, tuple[Variable, ...]]) -> Model:
    """Return the model of an output, if it reads what the circuit offers in the units of the circuit.

    Parameters
    ----------
    models : sequence of Model
    *alternatives : (output, inputs)
        What it may be.
    """
    outputs = sorted({output.name for output, _ in alternatives})
    found = [model for model in models if model.output.name in outputs]
    if len(found) != 1:
        given = [model.output.name for model in models]
        raise InputError(
            f"the flow model needs one model of {' or '.join(outputs)}; given are {given}: fit it or add its file"
        )
    names = tuple(variable.name for variable in found[0].inputs)
    fitting = [
        (output, inputs)
        for output, inputs in alternatives
        if output.name == found[0].output.name and names == tuple(variable.name for variable in inputs)
    ]
    if not fitting:
        needed = " or ".join(str(tuple(v.name for v in i)) for o, i in alternatives if o.name == found[0].output.name)
        raise InputError(
            f"the model of {found[0].output.name!r} reads {names}; the circuit needs one of {needed}, in this order"
        )
    output, inputs = fitting[0]
    for variable, need in zip((found[0].output, *found[0].inputs), (output, *inputs), strict=True):
        if variable.unit not in ("", need.unit):
            raise InputError(
                f"the model of {output.name!r} has {variable}; the circuit computes in SI: fit it on {need}"
            )
    return found[0]


def networks_serve(model: PolynomialFlow | NeuralFlow) -> tuple[str, ...]:
    """Links for which a flow model has networks."""
    return tuple(link for link, has in zip(LINKS, model.networks.serves, strict=True) if has)


def scratch(model: PolynomialFlow | NeuralFlow) -> int:
    """Floats that a step needs as scratch."""
    return max(len(BOTH), work_size(model.networks.table))


_NOTHING = Model((Variable("none"),), Variable("none"), (Network((), (0.0,), (1.0,), (0.0,), (0.0,), 0.0, 1.0),))


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
def network_step(flow: NetworkFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links) -> Flows:
    """Evaluate one input-flow and one outlet network for each link; `memory` is their scratch."""
    inlets, outlets = flow.inlets, flow.outlets
    swing, boom, stick = abs(spool.swing), abs(spool.boom), abs(spool.stick)
    Q = flow.series_pump.flow
    q_boom = _inlet(flow, inlets.boom, memory, boom, p_in.boom, 0.0, 0.0)
    q_boom = min(max(q_boom, 0.0), flow.boom_pump.flow) if p_in.boom < flow.boom_pump.relief else 0.0
    q_swing = _inlet(flow, inlets.swing, memory, swing, stick, p_in.swing, p_in.stick)
    q_swing = min(max(q_swing, 0.0), Q) if p_in.swing < flow.series_pump.relief else 0.0
    passed = Q - q_swing if swing <= flow.swing_closes else 0.0
    q_stick = (
        _inlet(flow, inlets.stick, memory, passed, stick, p_in.stick, 0.0)
        if inlets.cascade
        else _inlet(flow, inlets.stick, memory, swing, stick, p_in.swing, p_in.stick)
    )
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
