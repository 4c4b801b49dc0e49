"""Which stick moves which function, and which way: the two patterns of excavators, and their like for other machines.

Right and forward are positive at a stick. Both patterns have swing and bucket in common; ISO has the stick at the left hand and the boom
at the right one, SAE the other way round.
"""

from collections.abc import Mapping
from typing import NamedTuple

from polydraulic.errors import InputError
from polydraulic.parameters.layout.parts import FourBar
from polydraulic.parameters.layout.schema import LayoutMachine

LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y, FIFTH, SIXTH = range(6)


class Axis(NamedTuple):
    """Where a function's lever is: number of the axis, and the sign that its voltage has there."""

    axis: int
    sign: float


def lever_patterns(machine: LayoutMachine) -> dict[str, dict[str, Axis]]:
    """Patterns by name, each with the axis of every function.

    Raises
    ------
    InputError
        A machine with more functions than there are axes.
    """
    roles = _roles(machine)
    found: dict[str, dict[str, Axis]] = {}
    for pattern, arm in (("iso", {"boom": RIGHT_Y, "stick": LEFT_Y}), ("sae", {"boom": LEFT_Y, "stick": RIGHT_Y})):
        usual = {
            "swing": Axis(LEFT_X, -1.0),
            "boom": Axis(arm["boom"], -1.0),
            "stick": Axis(arm["stick"], 1.0),
            "bucket": Axis(RIGHT_X, 1.0 if "stick" in roles.values() else -1.0),  # dumps to the right
        }
        if "stick" not in roles.values():  # a loader: all of its arm at the right hand
            usual["boom"] = Axis(RIGHT_Y, -1.0)
        taken = {name: usual[role] for name, role in roles.items() if role in usual}
        free = [
            a for a in (FIFTH, SIXTH, LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y) if a not in {x.axis for x in taken.values()}
        ]
        others = [name for name in machine.names if name not in taken]
        if len(others) > len(free):
            raise InputError(
                f"the machine is moved by {len(machine.names)} functions; sticks have {len(free) + len(taken)} axes"
            )
        taken |= {name: Axis(axis, 1.0) for name, axis in zip(others, free, strict=False)}
        found[pattern] = {name: taken[name] for name in machine.names}
    return found


def _roles(machine: LayoutMachine) -> Mapping[str, str]:
    """What functions are for: the joint about an upright axis, the last joint that holds the tip, and the first two of the arm."""
    roles: dict[str, str] = {}
    arm: list[str] = []
    for f in machine.functions:
        link = machine.link(f.moves)
        if link.joint == "revolute" and link.axis[-1] == "z" and "swing" not in roles.values():
            roles[f.name] = "swing"
        elif isinstance(f.pins, FourBar) and machine.tip[0] == link.name:
            roles[f.name] = "bucket"
        elif link.joint == "revolute":
            arm.append(f.name)
    return roles | dict(zip(arm, ("boom", "stick"), strict=False))
