"""Many machines side by side: values as rows of 64 lanes, one machine per lane, for loops that become vector instructions.

A block of machines is one flat array, row after row; the first rows are those of a recorded step, scratch follows. Row numbers
and `LANES` are constants, so that the compiler sees which places differ. Parameters are one named tuple for the
whole block, or rows of their own where the machines differ: `at` gives the named tuple of a lane in both cases.
"""

from typing import Any

from numba import types
from numba.extending import overload

from polydraulic._kernel import INLINED_OPTIONS
from polydraulic.flow.layout.text_module import written_name

LANES = 64


def at(own: Any, shared: Any, lane: Any) -> Any:
    """Parameters of a lane.

    Parameters
    ----------
    own : None or flat array of rows
        None where all machines of the block share their parameters; else every number of the named tuple, in the order of
        `leaves`, one row a number.
    shared : nested named tuple of floats and bools
        The parameters that are shared, or an example of their form.
    lane : int
    """
    return shared if own is None else _filled(shared, iter(own.reshape(-1, LANES)[:, lane].tolist()))


def _filled(form: Any, numbers: Any) -> Any:
    if isinstance(form, tuple):
        return type(form)(*(_filled(part, numbers) for part in form))
    return next(numbers) != 0.0 if isinstance(form, bool) else next(numbers)


def leaves(parameters: Any) -> list[float]:
    """All numbers of a nested named tuple, in order."""
    found: list[float] = []
    for part in parameters:
        if isinstance(part, tuple):
            found += leaves(part)
        else:
            found.append(part)
    return found


@overload(at, jit_options=INLINED_OPTIONS)
def _at_compiled(own: Any, shared: Any, lane: Any) -> Any:
    # numba wants the signature of `at`, annotations included
    names: dict[str, Any] = {"Any": Any}
    text = "shared" if isinstance(own, types.NoneType) else _expression(shared, 0, names)[0]
    exec(f"def chosen(own: Any, shared: Any, lane: Any) -> Any:\n    return {text}", names)
    return names["chosen"]


def _expression(form: Any, row: int, names: dict[str, Any]) -> tuple[str, int]:
    """Source of a call that builds a named tuple from rows, and the next row."""
    if not isinstance(form, types.BaseNamedTuple):
        value = f"own[{row * LANES} + lane]"
        return (f"{value} != 0.0" if isinstance(form, types.Boolean) else value), row + 1
    names[written_name(form.instance_class)] = form.instance_class
    parts = []
    for part in form.types:
        text, row = _expression(part, row, names)
        parts.append(text)
    return f"{written_name(form.instance_class)}({', '.join(parts)})", row
