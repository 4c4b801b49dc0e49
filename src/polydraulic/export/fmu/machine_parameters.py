"""Numbers of a machine that a step reads as they are, so that an importer may change them."""

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

from polydraulic.export.layout import layout_parts
from polydraulic.flow.dispatch import layout_flow
from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.quantity import Quantity
from polydraulic.parameters.values import leaves_of


class MachineParameter(NamedTuple):
    """A number of a machine that a step reads as it is.

    Attributes
    ----------
    name : str
        Its path in the machine, such as ``functions.boom.line.relief``.
    value : float
    quantity : Quantity
    places : list of tuple of str
        Its paths in `Prepared`.
    """

    name: str
    value: float
    quantity: Quantity
    places: list[tuple[str, ...]]


def direct_parameters(
    machine: LayoutMachine, flow: str | LayoutFlow, *, dt: float = 5e-3, locked: Collection[str] = ()
) -> list[MachineParameter]:
    """Parameters that a step reads as they are; the others enter precomputed numbers, and stay as exported.

    Found by trying: a parameter is direct if all numbers that change with it are equal to it before and after. Networks and tables are
    made for the pumps as they are, and take no other values.

    Parameters
    ----------
    machine : LayoutMachine
    flow : str or flow model
    dt : float, s
    locked : collection of str
    """
    made = layout_flow(flow, machine).kernels in ("networks", "lookup")
    before = dict(_leaves(_numbers(machine, dt, locked)))
    found = []
    for path, quantity in _quantities(machine):
        smooths = path[-1] == "smoothing" and machine.function(path[1]).effects.sticks  # which nothing reads
        if (
            path[-1].startswith("torque_limit") or smooths
        ):  # without a limit they do nothing, with one they enter `log_least` too
            continue
        value = _at(machine, path)
        after = dict(_leaves(_numbers(_replaced(machine, path, _other(value)), dt, locked)))
        places = [place for place, number in after.items() if before[place] != number]
        if made and any(place[0] == "valves" for place in places):
            continue
        if places and all(before[place] == value and after[place] == _other(value) for place in places):
            found.append(MachineParameter(".".join(path), value, quantity, places))
    return found


def _numbers(machine: LayoutMachine, dt: float, locked: Collection[str]) -> Any:
    return layout_parts(machine, "exact", dt=dt, locked=locked).numbers


def _quantities(machine: LayoutMachine) -> Iterator[tuple[tuple[str, ...], Quantity]]:
    """Paths and quantities of the single numbers of a machine's parts."""
    parts: list[tuple[tuple[str, ...], Any]] = [(("tank",), machine.tank)]
    for f in machine.functions:
        of = {"pilot": f.pilot, "line": f.line, "friction": f.friction, "stops": f.stops, "initial": f.initial}
        parts += [(("functions", f.name, key), part) for key, part in of.items()]
    parts += [(("circuits", c.name, "pump"), c.pump) for c in machine.circuits]
    for where, part in parts:
        for path, leaf in leaves_of(part.__class__).items():
            if leaf.quantity is not None and not leaf.size:
                yield (*where, path), leaf.quantity


def _other(value: float) -> float:
    return value * 1.001 if value else 1e-3


def _at(tree: Any, path: tuple[str, ...]) -> float:
    for name in path:
        tree = _part(tree, name)
    return float(tree)


def _part(tree: Any, name: str) -> Any:
    """A field of a named tuple, or the member of that name of a plain one."""
    return getattr(tree, name) if hasattr(tree, "_fields") else next(part for part in tree if part.name == name)


def _replaced(tree: Any, path: tuple[str, ...], value: float) -> Any:
    new = value if len(path) == 1 else _replaced(_part(tree, path[0]), path[1:], value)
    if hasattr(tree, "_fields"):
        return tree._replace(**{path[0]: new})
    return tuple(new if part.name == path[0] else part for part in tree)


def _leaves(tree: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    if isinstance(tree, tuple):
        for name, part in zip(tree._fields, tree, strict=True):  # type: ignore[attr-defined]
            yield from _leaves(part, (*path, name))
    else:
        yield path, tree
