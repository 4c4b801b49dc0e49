"""Networks by region in place of orifice areas and pump pressures (thesis 4.2, 5.1): polynomials, or perceptrons.

Inlets: the flow into the first valve of a circuit from all travels and line pressures; the flows of valves behind it in one of two
arrangements. In "direct" they read everything, too (thesis Table 3). In "cascade" a network reads the flow that reaches its valve, as the
valve does. Outlets: the conductance Q_pop(x) of Eq. (7) from the spool alone, or the thesis' output flow from spool and sqrt(P_o - P_e).
Neither orifice areas nor the pump pressure appear; flow and relief setting of the pumps must be known: nothing enters a line at relief
pressure. A flow is the least of the pump's modes (`network_slots`).
"""

from collections.abc import Hashable, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.flow.layout.networks import layout_networks
from polydraulic.flow.network_slots import LIMITED
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.model_file import parse_models
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine, load_machine

ARRANGEMENTS = ("cascade", "direct")
TRAINED_ON = "cat215b"


def polynomial_flow(
    machine: LayoutMachine | str | Path, *, models: Sequence[Model] | None = None, arrangement: str = "cascade"
) -> LayoutFlow:
    """Flow model from polynomial networks.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        Flows and relief settings of its pumps are used, and where bypasses close; a torque limit is known only to networks that were
        trained with one.
    models : sequence of Model, optional
        In SI: of each function of a circuit ``NAME.q_in`` and ``NAME.k_out`` (or ``NAME.q_out``), and those of single modes of the pump,
        which may be missing; see `flow.layout.slots`. Those of one circuit alone serve runs that move nothing else. If no models are
        given, the networks that come with the package, of cat215b; they know the torque limits of those pumps that have one.
    arrangement : {"cascade", "direct"}
        Which of the package's networks; given models say it by what the inlets behind the first valve read.

    Raises
    ------
    InputError
        If a model is missing or reads other inputs, or there is no such arrangement; without models, if pumps or valves are not those that
        the package's networks were trained on.
    """
    machine = as_machine(machine)
    if arrangement not in ARRANGEMENTS:
        raise InputError(f"arrangement = {arrangement!r}: choose one of {ARRANGEMENTS}")
    check_circuits(machine, "polynomial")
    return _shipped_flow(machine, arrangement) if models is None else layout_networks(machine, models, "polynomial")


def fine_flow(machine: LayoutMachine | str | Path) -> LayoutFlow:
    """Flow model from the package's finer polynomial networks: those of the cascade, nearer to exact, in more regions.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        With circuits as `TRAINED_ON`. At a torque limit the networks of the cascade serve here, too.

    Raises
    ------
    InputError
        If pumps or valves are not those that the networks were trained on.
    """
    machine = as_machine(machine)
    check_circuits(machine, "polynomial-fine")
    return _shipped_flow(machine, "fine")


def neural_flow(machine: LayoutMachine | str | Path, *, models: Sequence[Model] | None = None) -> LayoutFlow:
    """Flow model from perceptrons.

    Parameters
    ----------
    machine, models
        As for `polynomial_flow`.
    """
    machine = as_machine(machine)
    check_circuits(machine, "neural")
    return _shipped_flow(machine, "neural") if models is None else layout_networks(machine, models, "neural")


_KINDS = {"neural": "neural", "fine": "polynomial-fine"}  # flow models by the networks that they are made of
_MOST_BUILT = 32
_built: dict[Hashable, LayoutFlow] = {}


def _shipped_flow(machine: LayoutMachine, name: str) -> LayoutFlow:
    """Flow model of the package's networks: one for all machines whose circuits have the same numbers, and its arrays take no others."""
    key = name, machine.circuits, machine.tank, tuple((f.name, f.valve) for f in machine.functions)
    found = _built.get(key)
    if found is None:
        kind = _KINDS.get(name, "polynomial")
        _check_trained(machine, kind)
        models = shipped_models(name, limited=kind != "neural" and _limited(machine))
        without = [f for c in machine.circuits if not c.pump.torque_limit_enabled for f in c.functions]
        models = [m for m in models if m.output.name not in {f"{f}.q_in{LIMITED}" for f in without}]
        found = layout_networks(machine, models, kind)
        _write_protect(found.parts)
        for oldest in list(_built)[: max(0, len(_built) - _MOST_BUILT + 1)]:
            _built.pop(oldest, None)
        _built[key] = found
    return found


def _write_protect(parts: object) -> None:
    for part in parts.values() if isinstance(parts, dict) else parts if isinstance(parts, tuple) else ():
        if isinstance(part, np.ndarray):
            part.flags.writeable = False
        _write_protect(part)


def shipped_models(name: str = "cascade", *, limited: bool = False) -> list[Model]:
    """Networks that come with the package, trained on the circuits of `TRAINED_ON`.

    Parameters
    ----------
    name : {"cascade", "direct", "neural", "fine"}
    limited : bool
        Also those of the torque limit; they go with all but perceptrons.
    """
    shared = {"neural": ["outlets"], "fine": []}.get(name, ["outlets", "inlets"])
    parts = [*shared, name, *(["limited"] if limited else [])]
    return [model for part in parts for model in _read(f"{part}.json")]


@cache
def _read(file: str) -> tuple[Model, ...]:
    source = files("polydraulic.flow") / "trained" / file
    return tuple(parse_models(source.read_text(encoding="utf-8"), f"trained/{file}"))


def _limited(machine: LayoutMachine) -> bool:
    return any(c.pump.torque_limit_enabled for c in machine.circuits)


def _check_trained(machine: LayoutMachine, kind: str) -> None:
    """Refuse the package's networks to circuits that they were not trained on."""
    trained, learnt = load_machine(TRAINED_ON), "neural" if kind == "neural" else "polynomial"
    train = f"train networks for this machine (polydraulic train --machine MACHINE --out networks.json, or `train_layout`) and give them as models (--flow {learnt} --model networks.json)"
    if circuits_of(machine) != circuits_of(trained):
        raise InputError(f"flow {kind!r}: no networks come with the package for {machine.title!r}: {train}")
    # a limit may be on or off, as there are networks for both; that of a pump that has none does not matter
    free = {f"{c.pump_path}.torque_limit_enabled" for c in machine.circuits}
    for c in machine.circuits:
        if not c.pump.torque_limit_enabled:
            free |= {f"{c.pump_path}.{name}" for name in c.pump._fields if name.startswith("torque_limit")}
    known = _circuit_numbers(trained)
    for name, value in _circuit_numbers(machine).items():
        if value != known[name] and name not in free:
            raise InputError(
                f"{name} = {value}, and {known[name]} in {TRAINED_ON}, whose circuits the package's networks were trained on: {train}"
            )


def _circuit_numbers(machine: LayoutMachine) -> dict[str, object]:
    """Parameters that decide the flows, by their paths in a file."""
    parts = {"tank": machine.tank} | {f"{c.pump_path}": c.pump for c in machine.circuits}
    valves = {f"functions.{f.name}.valve": f.valve for f in machine.functions}
    return {
        f"{part}.{name}": value for part, values in (parts | valves).items() for name, value in values._asdict().items()
    }
