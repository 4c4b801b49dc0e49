"""The module of a machine's layout."""

from types import ModuleType

from polydraulic.flow.layout.text_module import loaded
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.text import layout_text


def layout_module(machine: LayoutMachine, *, flow: str = "exact", force: bool = False) -> ModuleType:
    """Module of the kernels of a machine's layout, with a force at the tip or without; see `layout_text`."""
    return loaded(layout_text(machine, flow=flow, force=force))
