"""Which methods of `simulate` serve a machine of any layout, and why the others do not."""

from polydraulic.errors import InputError
from polydraulic.flow.layout.model import FORGETTING, LayoutFlow
from polydraulic.parameters.layout.schema import LayoutMachine

STEPPED = "semi-implicit"
CONTINUOUS = ("rk4", "rosenbrock", "reference")
# of effects; two methods know what spools do without flow forces in advance, the one with slopes knows no other
_SERVED = {
    "rk4": ("valve.hysteresis", "valve.flow_force"),
    "rosenbrock": ("valve.hysteresis",),
    "reference": ("valve.hysteresis", "valve.flow_force"),
}
_APART = {
    "valve.hysteresis",
    "valve.flow_force",
}  # a driver that is pushed is not known in advance, and may turn back at any time


def check_method(machine: LayoutMachine, method: str) -> None:
    """Refuse a method that does not serve a machine.

    Parameters
    ----------
    machine : LayoutMachine
    method : str
        One of those of `simulate`.

    Raises
    ------
    InputError
        Naming the effect that the method does not know, and what to do.
    """
    if method == STEPPED:
        return
    for f in machine.functions:
        for key in f.effects.declared:
            served = [STEPPED, *(one for one, keys in _SERVED.items() if key in keys)]
            if method not in served:
                raise InputError(
                    f"functions.{f.name}.{key}: method {method!r} does not know it; use {' or '.join(map(repr, served))}, or leave it out"
                )
        if method == "reference" and set(f.effects.declared) >= _APART:
            raise InputError(
                f"functions.{f.name}: method 'reference' knows valve.hysteresis and valve.flow_force, but not both of one valve; use "
                f"{STEPPED!r} or 'rk4', or leave one out"
            )


def check_flow(flow: LayoutFlow, method: str) -> None:
    """Refuse a method that does not integrate a flow model.

    Raises
    ------
    InputError
        Naming methods, or a flow model, that serve.
    """
    served = [STEPPED, *(("rk4", "reference") if flow.kernels in FORGETTING else ())]
    if flow.name != "exact" and method not in served:
        methods = " or ".join(map(repr, served))
        raise InputError(
            f"flow {flow.name!r} with method {method!r}: this method does not integrate it; use method {methods}, or flow 'exact'"
        )


def method_lines(machine: LayoutMachine) -> list[str]:
    """Lines for people: the methods that serve a machine, and the reason for each that does not."""
    refused: dict[str, str] = {}
    for method in CONTINUOUS:
        try:
            check_method(machine, method)
        except InputError as error:
            refused[method] = str(error)
    served = [STEPPED, *(method for method in CONTINUOUS if method not in refused)]
    lines = [f"methods of simulate: {', '.join(served)}"]
    if len(refused) == len(CONTINUOUS):
        what = next(iter(refused.values())).split(":")[0]
        return [f"{lines[0]} alone, since the others do not know {what}"]
    return [*lines, *(f"  not {method}: {why}" for method, why in refused.items())]
