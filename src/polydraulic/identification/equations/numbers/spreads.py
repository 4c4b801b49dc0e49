"""How far numbers may be off where nobody says so: a share of each, by its kind."""

from collections.abc import Mapping

from polydraulic.errors import InputError
from polydraulic.identification.equations.free_numbers import SPREADS
from polydraulic.parameters.layout.schema import LayoutMachine

_SHARES = SPREADS | {"gain": 0.2, "time_constant": 0.3}
_USUAL = 0.3
_DEAD_TIME = 0.05  # s: zero in most files


def spreads_of(machine: LayoutMachine, entries: Mapping[str, float]) -> dict[str, float]:
    """Standard deviation of every single number among entries of a machine file.

    Parameters
    ----------
    machine : LayoutMachine
    entries : mapping from path to float, SI
        How far an entry may be off, nan where nothing is said; a table is one entry, and its numbers that are zero stay so.

    Raises
    ------
    InputError
        An entry that the machine does not have; one that is zero, and no spread given.
    """
    found: dict[str, float] = {}
    for path, said in entries.items():
        own = [n for n in machine.numbers if n.path == path or n.path.startswith(f"{path}[")]
        if not own:
            raise InputError(f"free number {path!r}: the machine has no such number")
        for number in own:
            if number.path != path and number.value == 0.0:
                continue
            kind = number.path.rpartition(".")[2]
            usual = _DEAD_TIME if kind == "dead_time" else _SHARES.get(kind, _USUAL) * abs(number.value)
            spread = usual if said != said else said
            if spread == 0.0:
                raise InputError(f"free number {path!r} is 0: give it a spread, how far it may be off")
            found[number.path] = spread
    return found
