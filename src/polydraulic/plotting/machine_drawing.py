"""What is drawn of a machine, whatever its form."""

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.schema import Machine
from polydraulic.plotting.drawing import Drawing
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.plotting.shapes import excavator_drawing


def machine_drawing(machine: Machine | LayoutMachine) -> Drawing:
    """Collect what is drawn of a machine.

    Parameters
    ----------
    machine : Machine or LayoutMachine
    """
    return layout_drawing(machine) if isinstance(machine, LayoutMachine) else excavator_drawing(machine)
