"""A machine as it is known before it is identified: off by as much as a first guess may be."""

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine


def rough_machine(machine: LayoutMachine, rng: np.random.Generator) -> LayoutMachine:
    """What is known of a machine before.

    Of each valve that is where it opens, where its bypass closes and its full travel, with straight lines between conductances that
    are off by up to half; pumps give 5 % too much, pilots are off by 10 and 20 %.

    Parameters
    ----------
    machine : LayoutMachine
        The true one.
    rng : Generator
    """
    values: dict[str, float | tuple[float, ...]] = {}
    for f in machine.functions:
        v, where = f.valve, f"functions.{f.name}"
        knots = (0.0, v.knots[1], v.knots[-2], v.knots[-1])
        values[f"{where}.valve.knots"] = knots
        for key in ("inlet", "bypass", "outlet_positive", "outlet_negative"):
            off = rng.uniform(0.6, 1.5, 2)
            at = np.interp(knots, v.knots, getattr(v, key))
            bypass = (at[0] * off[0], at[1] * off[1], 0.0, 0.0)
            values[f"{where}.valve.{key}"] = bypass if key == "bypass" else (0.0, 0.0, at[2] * off[0], at[3] * off[1])
        values[f"{where}.pilot.gain"] = 1.1 * f.pilot.gain
        values[f"{where}.pilot.time_constant"] = 0.8 * f.pilot.time_constant
    for c in machine.circuits:
        values[f"{c.pump_path}.flow"] = 1.05 * c.pump.flow
    return machine.with_values(values)
