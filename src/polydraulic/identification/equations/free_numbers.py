"""Which numbers of a machine an identification may change, and how far they may be off: marked in its file, or by patterns of paths."""

from collections.abc import Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.units import read_unit

CURVES = ("inlet", "bypass", "outlet_positive", "outlet_negative")
SPREADS = {"flow": 0.1, "relief": 0.05, "torque_limit_start": 0.1}  # shares, where a file gives none
PUMPS = ("pump", "giving", "taking")  # tables of a circuit that are one, those of a crossover among them
PUMP_NUMBERS = ("flow", "relief", "torque_limit_start")
# what keeps a spool from where its pilot drives it, and where it stands below a function; a file need not declare it
EFFECTS = {"hysteresis": "valve.hysteresis", "shift": "valve.flow_force.spring_rate"}
# whether dry friction holds a joint: a switch, no number, and only where somebody asks for it
HOLDS = "friction.sticks"
_PILOT = ("gain", "time_constant", "dead_time")


class Freedom(NamedTuple):
    """What may be changed.

    Attributes
    ----------
    spreads : dict from path to float
        Of each free entry of a machine file: how far it may be off, in SI; nan where nothing is said.
    marked : bool
        Whether somebody said what is free; otherwise all that can be fitted is.
    """

    spreads: dict[str, float]
    marked: bool

    def has(self, path: str) -> bool:
        """Whether an entry is free."""
        return path in self.spreads

    def spread(self, path: str, usual: float) -> float:
        """How far an entry may be off, in SI; `usual` where nothing is said."""
        value = self.spreads.get(path, float("nan"))
        return usual if value != value else value


def entries_of(machine: LayoutMachine) -> list[str]:
    """Paths of all entries of a machine, tables as one."""
    return list(dict.fromkeys(number.path.partition("[")[0] for number in machine.numbers))


def fitted_here(path: str) -> bool:
    """Whether curves identified inside the equations of circuits, or pilots, can change an entry."""
    parts = path.split(".")
    if is_effect(path):
        return True
    if parts[0] == "circuits":
        return parts[-2] in PUMPS and parts[-1] in PUMP_NUMBERS
    return parts[0] == "functions" and (
        (parts[-2] == "valve" and parts[-1] in (*CURVES, "knots")) or (parts[-2] == "pilot" and parts[-1] in _PILOT)
    )


def is_effect(path: str) -> bool:
    """Whether an entry is what a spool does besides following its pilot."""
    return path.startswith("functions.") and path.split(".", 2)[2] in EFFECTS.values()


def freedom(machine: LayoutMachine, data: dict[str, Any], patterns: Sequence[str]) -> Freedom:
    """What may be changed.

    Parameters
    ----------
    machine : LayoutMachine
    data : dict
        Its file as it is written; empty where there is none.
    patterns : sequence of str
        Paths such as ``functions.*.valve.*``, besides what the file marks. Effects of spools that the machine does not declare, and
        whether friction holds a joint, are meant where a pattern ends as their paths do, ``functions.*.valve.hysteresis``.

    Raises
    ------
    InputError
        A pattern that fits no path.
    """
    paths = entries_of(machine)
    found = {path: spread for path, spread in _marked(data).items() if path in paths}
    effects = [f"functions.{name}.{key}" for name in machine.names for key in (*EFFECTS.values(), HOLDS)]
    for pattern in patterns:
        asked = [path for path in effects if pattern.endswith(path.rpartition(".")[2])]
        fitting = [path for path in dict.fromkeys([*paths, *asked]) if fnmatchcase(path, pattern)]
        if not fitting:
            known = list(dict.fromkeys([*paths, *effects]))
            near = get_close_matches(pattern, known, n=3, cutoff=0.4)
            said = f"near it: {', '.join(near)}" if near else f"paths are such as {', '.join(known[:3])}"
            raise InputError(f"--free {pattern!r} fits no number of the machine; {said}")
        found |= {path: found.get(path, float("nan")) for path in fitting}
    if not found:
        return Freedom({path: float("nan") for path in paths if fitted_here(path)}, False)
    return Freedom(found, True)


def _marked(tree: dict[str, Any], where: str = "") -> dict[str, float]:
    """Entries that are marked as free, with their spreads in SI."""
    found: dict[str, float] = {}
    for key, item in tree.items():
        if not isinstance(item, dict):
            continue
        if "value" not in item:
            found |= _marked(item, f"{where}{key}.")
        elif item.get("free", False):
            spread = item.get("spread")
            unit = read_unit(item["unit"])
            found[where + key] = float("nan") if spread is None else unit.to_si(float(spread)) - unit.to_si(0.0)
    return found
