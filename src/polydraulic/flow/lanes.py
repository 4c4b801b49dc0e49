"""Many machines side by side: values as rows of 64 lanes, one machine per lane, for loops that become vector instructions.

A block of machines is one flat array, row after row; the first rows are those of a recorded step, scratch follows. Row numbers
and `LANES` are constants, so that the compiler sees which places differ. Parameters are one named tuple for the
whole block, or rows of their own where the machines differ: `at` gives the named tuple of a lane in both cases. Arrays among the
parameters are the same for all machines of a block.
"""

from typing import Any

import numpy as np
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
    shared : nested named tuple of numbers, bools and arrays
        The parameters that are shared, or an example of their form, with their arrays.
    lane : int
    """
    return shared if own is None else _filled(shared, iter(own.reshape(-1, LANES)[:, lane].tolist()))


def _filled(form: Any, numbers: Any) -> Any:
    if isinstance(form, tuple):
        return type(form)(*(_filled(part, numbers) for part in form))
    if isinstance(form, np.ndarray):
        return form
    number = next(numbers)
    return type(form)(number) if isinstance(form, int | np.integer) else number


def leaves(parameters: Any) -> list[float]:
    """All numbers of a nested named tuple, in order, but for those in arrays."""
    found: list[float] = []
    for part in parameters:
        if isinstance(part, tuple):
            found += leaves(part)
        elif not isinstance(part, np.ndarray):
            found.append(part)
    return found


def arrays_in(parameters: Any) -> list[np.ndarray]:
    """All arrays of a nested named tuple, in order."""
    if isinstance(parameters, np.ndarray):
        return [parameters]
    return [array for part in parameters for array in arrays_in(part)] if isinstance(parameters, tuple) else []


@overload(at, jit_options=INLINED_OPTIONS)
def _at_compiled(own: Any, shared: Any, lane: Any) -> Any:
    # numba wants the signature of `at`, annotations included
    names: dict[str, Any] = {"Any": Any}
    text = "shared" if isinstance(own, types.NoneType) else _expression(shared, "shared", 0, names)[0]
    exec(f"def chosen(own: Any, shared: Any, lane: Any) -> Any:\n    return {text}", names)
    return names["chosen"]


def _expression(form: Any, path: str, row: int, names: dict[str, Any]) -> tuple[str, int]:
    """Source of a call that builds a named tuple from rows, and the next row."""
    if isinstance(form, types.Array):
        return path, row
    if not isinstance(form, types.BaseNamedTuple):
        value = f"own[{row * LANES} + lane]"
        if isinstance(form, types.Boolean):
            value = f"{value} != 0.0"
        elif isinstance(form, types.Integer):
            value = f"int({value})"
        return value, row + 1
    names[written_name(form.instance_class)] = form.instance_class
    parts = []
    for name, part in zip(form.fields, form.types, strict=True):
        text, row = _expression(part, f"{path}.{name}", row, names)
        parts.append(text)
    return f"{written_name(form.instance_class)}({', '.join(parts)})", row
