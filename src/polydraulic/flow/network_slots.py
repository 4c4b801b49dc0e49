"""What networks are called, and read, to take their places in the circuits (SI units).

The true pump pressure is the least of those that the pump's modes would give alone: constant flow, relief valve open, torque
limit. All flows rise with it, so that a flow is the least of its modes, too, and a mode may have a network of its own, free
of the kinks between modes. ``LINK.q_in`` without an ending may hold constant flow alone, or all modes.
"""

from collections.abc import Sequence

from polydraulic.errors import InputError
from polydraulic.networks.model.model import Model, Variable

Place = tuple[Variable, tuple[Variable, ...]]  # output and inputs


def travel(link: str) -> Variable:
    """Distance of a link's spool from its centre."""
    return Variable(f"{link}.travel", "m")


def p_in(link: str) -> Variable:
    """Pressure at a link's pressurised port."""
    return Variable(f"{link}.p_in", "Pa")


def q_in(link: str, mode: str = "") -> Variable:
    """Flow into a link's pressurised port."""
    return Variable(f"{link}.q_in{mode}", "m3/s")


def k_in(link: str) -> Place:
    """Conductance of a link's inlet: with the relief valve open, its flow is k_in sqrt(P_relief - P_i)."""
    return Variable(f"{link}.k_in", "m3/s/Pa^0.5"), (travel(link),)


def k_out(link: str) -> Variable:
    """Conductance of a link's outlet."""
    return Variable(f"{link}.k_out", "m3/s/Pa^0.5")


RELIEF, LIMITED = "_relief", "_limited"  # endings of names: relief valve open; torque limit
SHUT = "_shut"  # check valve of the next valve shut


def choose_model(models: Sequence[Model], *alternatives: Place) -> Model:
    """Return the model of an output, if it reads what the circuit offers in the units of the circuit.

    Parameters
    ----------
    models : sequence of Model
    *alternatives : (output, inputs)
        What it may be.
    """
    outputs = sorted({output.name for output, _ in alternatives})
    found = [model for model in models if model.output.name in outputs]
    if len(found) != 1:
        given = [model.output.name for model in models]
        raise InputError(
            f"the flow model needs one model of {' or '.join(outputs)}; given are {given}: fit it or add its file"
        )
    names = tuple(variable.name for variable in found[0].inputs)
    fitting = [
        (output, inputs)
        for output, inputs in alternatives
        if output.name == found[0].output.name and names == tuple(variable.name for variable in inputs)
    ]
    if not fitting:
        needed = " or ".join(str(tuple(v.name for v in i)) for o, i in alternatives if o.name == found[0].output.name)
        raise InputError(
            f"the model of {found[0].output.name!r} reads {names}; the circuit needs one of {needed}, in this order"
        )
    output, inputs = fitting[0]
    for variable, need in zip((found[0].output, *found[0].inputs), (output, *inputs), strict=True):
        if variable.unit not in ("", need.unit):
            raise InputError(
                f"the model of {output.name!r} has {variable}; the circuit computes in SI: fit it on {need}"
            )
    return found[0]
