"""A machine of any layout: links, functions and circuits as one, and other values in their places."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from polydraulic.parameters.layout.chassis import Chassis
from polydraulic.parameters.layout.parts import Crossover, LinkParameters, MachineFunction, Point, SupplyCircuit
from polydraulic.parameters.layout.values import MachineNumber, numbers_of, replaced_layout
from polydraulic.parameters.schema import Tank


class LayoutMachine(NamedTuple):
    """A machine of any layout, SI; functions stand in the order of the links that they move."""

    title: str
    gravity: float
    tank: Tank
    links: tuple[LinkParameters, ...]
    functions: tuple[MachineFunction, ...]
    circuits: tuple[SupplyCircuit, ...]
    tip: tuple[str, Point]  # a link, and a point in its frame
    crossovers: tuple[Crossover, ...] = ()
    chassis: Chassis | None = None

    def function(self, name: str) -> MachineFunction:
        """The function of that name."""
        return next(f for f in self.functions if f.name == name)

    def link(self, name: str) -> LinkParameters:
        """The link of that name."""
        return next(link for link in self.links if link.name == name)

    def circuit(self, name: str) -> SupplyCircuit:
        """The circuit of that name."""
        return next(c for c in self.circuits if c.name == name)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the functions, in their order."""
        return tuple(f.name for f in self.functions)

    @property
    def numbers(self) -> tuple[MachineNumber, ...]:
        """Every number of the machine: its path, value in SI, unit and range, in the order of the parts."""
        return numbers_of(self)

    def with_values(self, values: Mapping[str, float | bool | Sequence[float]]) -> "LayoutMachine":
        """Return a copy with other values.

        Parameters
        ----------
        values : mapping from path to value in SI
            Paths are those of a machine file: ``links.boom.mass``, ``circuits.main.pump.flow``. A table,
            ``functions.boom.valve.inlet``, takes all its numbers, and may have more or fewer than before if all tables of the valve
            have as many; ``functions.boom.valve.inlet[3]`` is one of them. Values are put in their places in the order of the mapping.

        Returns
        -------
        LayoutMachine

        Raises
        ------
        InputError
            Unknown paths, values out of their range, values that do not go together: all of them in one message.

        Examples
        --------
        >>> from polydraulic import load_machine
        >>> heavy = load_machine("wheel_loader").with_values({"links.bucket.mass": 900, "gravity": 9.79})
        >>> heavy.link("bucket").mass, heavy.gravity
        (900.0, 9.79)
        """
        return replaced_layout(self, values)


def position_column(machine: LayoutMachine, f: MachineFunction) -> str:
    """Column of logs and runs with the position of a function's joint: ``NAME.angle`` in rad, or ``NAME.position`` in m of one that slides."""
    return f"{f.name}.{'position' if machine.link(f.moves).joint == 'prismatic' else 'angle'}"


def position_columns(machine: LayoutMachine) -> list[str]:
    """Those of all functions, in their order."""
    return [position_column(machine, f) for f in machine.functions]
