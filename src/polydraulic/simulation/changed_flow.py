"""The flow model of a machine whose numbers change while it runs."""

from typing import Any

from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel, layout_flow
from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.parameters.layout.schema import LayoutMachine


def changed_flow(flow: str | FlowModel, model: LayoutFlow, before: LayoutMachine, after: LayoutMachine) -> LayoutFlow:
    """The model for the machine as it is after a change; one that is given by name is built anew.

    Parameters
    ----------
    flow : str or flow model
        As it was given.
    model : LayoutFlow
        What it was for the machine `before`.
    before, after : LayoutMachine

    Raises
    ------
    InputError
        A flow model that does not know the machine's numbers.
    """
    if valves_and_pumps(after) == valves_and_pumps(before):
        return model
    if isinstance(flow, str):
        return layout_flow(flow, after)
    if model.parts:
        raise InputError(
            f"the flow model {model.name!r} was made for the valves and pumps as they were; build the simulator with one for these, or "
            "with its name"
        )
    return model


def valves_and_pumps(machine: LayoutMachine) -> tuple[Any, ...]:
    """All that flows follow from."""
    return (
        machine.tank,
        tuple(c.pump for c in machine.circuits),
        tuple(f.valve for f in machine.functions),
        machine.crossovers,
    )
