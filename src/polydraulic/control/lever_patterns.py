"""Which stick moves which function, and which way: the patterns ISO 10968 and SAE J1177, for machines of any layout.

A machine file says what a function is to whoever holds the levers (its `role`), the joint's axis says which way is up, out or right. In all
machines a positive voltage moves a joint towards positive positions.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.parameters.layout.parts import ROLES, LinkParameters, MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.simulation.input_check import full_lever

STICKS = ("left_x", "left_y", "right_x", "right_y", "extra_x", "extra_y")  # positive to the right, and forward
_MOVES = {  # role: what its joint does, and what a positive position of a joint about z, -y or along an axis is
    "swing": ("swing left", "swing right"),
    "boom": ("boom up", "boom down"),
    "stick": ("stick out", "stick in"),
    "bucket": ("bucket dump", "bucket curl"),
    "front_bucket": ("bucket roll back", "bucket dump"),
    "extension": ("extend", "retract"),
    "auxiliary": ("forward", "back"),
}
_ISO = {  # role: stick, and whether its positive side is the first of the moves above
    "swing": ("left_x", False),
    "stick": ("left_y", True),
    "bucket": ("right_x", True),
    "front_bucket": ("right_x", False),
    "boom": ("right_y", False),
    "extension": ("extra_y", True),
    "auxiliary": ("extra_x", True),
}
_PATTERNS = {"iso": _ISO, "sae": _ISO | {"boom": ("left_y", False), "stick": ("right_y", True)}}
PATTERNS = tuple(_PATTERNS)


class LeverAxis(NamedTuple):
    """What one side-to-side or back-and-forth motion of a stick does.

    Attributes
    ----------
    stick : str
        One of `STICKS`.
    function : str
        Of the machine.
    sign : int
        1 where the positive side (right, forward) gives a positive voltage, -1 where it gives a negative one.
    positive, negative : str
        What the machine does on either side, for a label: ``boom down``, ``boom up``.
    """

    stick: str
    function: str
    sign: int
    positive: str
    negative: str


class LeverPattern(NamedTuple):
    """How sticks move a machine, joint by joint.

    Attributes
    ----------
    name : str
        ``iso`` or ``sae``.
    axes : tuple of LeverAxis
        In the order of the machine's functions.
    full : (n_function,) array, V
        What a stick at its end gives, with its sign.
    places : (n_function,) array of int
        Places in `STICKS`.
    dead_zone : float
        Share of a stick's way around its centre that does nothing.
    """

    name: str
    axes: tuple[LeverAxis, ...]
    full: np.ndarray
    places: np.ndarray
    dead_zone: float

    def voltages(self, sticks: Any) -> np.ndarray:
        """Voltages of the levers for where the sticks are.

        Parameters
        ----------
        sticks : (6,) array, or mapping from name to position
            From -1 to 1, positive to the right and forward, in the order of `STICKS`; those that a mapping leaves out are centred. What is
            beyond an end counts as the end.

        Returns
        -------
        (n_function,) array, V
            In the order of the machine's functions; behind the dead zone they rise in proportion.

        Raises
        ------
        InputError
            Sticks that there are not, or positions that are no numbers.
        """
        at = _positions(sticks)[self.places]
        beyond = np.clip((np.abs(at) - self.dead_zone) / (1.0 - self.dead_zone), 0.0, 1.0)
        return np.asarray(np.sign(at) * beyond * self.full)


def lever_pattern(machine: LayoutMachine | str | Path, name: str, *, dead_zone: float = 0.05) -> LeverPattern:
    """The pattern of a machine's levers.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    name : str
        ``iso`` (right stick: boom and bucket, left: swing and stick) or ``sae`` (boom and stick change places).
    dead_zone : float
        Share of a stick's way around its centre that does nothing, below 0.9.

    Returns
    -------
    LeverPattern

    Raises
    ------
    InputError
        Another pattern, a machine that does not say what its functions are, or two functions on one stick.

    Examples
    --------
    >>> pattern = lever_pattern("excavator_22t", "iso")
    >>> pattern.axes[1].stick, pattern.axes[1].positive
    ('right_y', 'boom down')
    >>> round(float(pattern.voltages({"right_y": -1.0})[1]), 6)
    0.8
    """
    if name not in _PATTERNS:
        raise InputError(f"pattern {briefly(name)}: must be one of {list(_PATTERNS)}")
    if not (isinstance(dead_zone, int | float) and 0.0 <= dead_zone < 0.9):
        raise InputError(f"dead_zone = {briefly(dead_zone)}: must be a share of the stick's way, from 0 to below 0.9")
    found = as_machine(machine)
    wrong = [line for f in found.functions for line in _trouble(f, found.link(f.moves))]
    if wrong:
        raise InputError("levers cannot be told what to move: " + "; ".join(wrong))
    axes = tuple(_axis(f, found.link(f.moves), _PATTERNS[name]) for f in found.functions)
    for k, axis in enumerate(axes):
        shared = [other.function for other in axes[:k] if other.stick == axis.stick]
        if shared:
            raise InputError(
                f"functions {shared[0]} and {axis.function} would both be moved by {axis.stick}; give one of them another role, "
                f"of {list(ROLES)}"
            )
    full = np.array([a.sign * full_lever(f) for a, f in zip(axes, found.functions, strict=True)])
    places = np.array([STICKS.index(a.stick) for a in axes])
    return LeverPattern(name, axes, full, places, float(dead_zone))


def _axis(f: MachineFunction, link: LinkParameters, pattern: Mapping[str, tuple[str, bool]]) -> LeverAxis:
    stick, first = pattern[f.role]
    one, other = _MOVES[f.role]
    if f.role == "auxiliary":
        one, other = f"{f.name} {one}", f"{f.name} {other}"
    sign = (1 if first else -1) * _towards_first(f, link)
    return LeverAxis(stick, f.name, sign, *((one, other) if first else (other, one)))


def _towards_first(f: MachineFunction, link: LinkParameters) -> int:
    """1 where a positive position is to the left, up, out or along an axis, -1 where it is the other way."""
    if f.role == "auxiliary":
        return 1
    negated = link.axis.startswith("-")
    upward = negated if link.axis.endswith("y") and link.joint == "revolute" else not negated
    return 1 if upward else -1


def _trouble(f: MachineFunction, link: LinkParameters) -> list[str]:
    """What keeps a function from being put on a stick."""
    where = f"functions.{f.name}"
    if not f.role:
        return [f'{where} does not say what it is: write role = "..." there, one of {list(ROLES)}']
    if f.role == "auxiliary":
        return []
    joint, axes = {"swing": ("revolute", "z"), "extension": ("prismatic", "xyz")}.get(f.role, ("revolute", "y"))
    if link.joint == joint and link.axis[-1] in axes:
        return []
    needed = "along which something extends" if joint == "prismatic" else f"about {axes} or -{axes}"
    is_now = f"{link.joint}, {'about' if link.joint == 'revolute' else 'along'} {link.axis}"
    return [f"{where}.role = {f.role!r}: needs a {joint} joint {needed}; that of {link.name} is {is_now}"]


def _positions(sticks: Any) -> np.ndarray:
    if isinstance(sticks, Mapping):
        for name in sticks:
            if name not in STICKS:
                raise InputError(f"no stick {briefly(name)}; there are {list(STICKS)}")
        sticks = [sticks.get(name, 0.0) for name in STICKS]
    try:
        found = np.asarray(sticks, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (len(STICKS),) or not np.isfinite(found).all():
        raise InputError(
            f"sticks = {briefly(sticks)}: must be {len(STICKS)} numbers from -1 to 1, in the order {', '.join(STICKS)}"
        )
    return found
