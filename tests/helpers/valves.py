"""Orifices of a machine's valves at spool displacements, by NumPy; its pumps; and the machine with other parts."""

import numpy as np

from polydraulic.machine.pump import limited_pump
from polydraulic.machine.valve import Orifices


def orifices(x, valve):
    """Conductances at a spool displacement in m."""
    outlet = valve.outlet_positive if x >= 0.0 else valve.outlet_negative
    return Orifices(*(float(np.interp(abs(x), valve.knots, curve)) for curve in (valve.inlet, valve.bypass, outlet)))


def orifice_slopes(x, valve):
    """Slopes of the conductances over the displacement, on the segment behind a knot."""
    k = int(np.searchsorted(valve.knots, abs(x), side="right")) - 1
    outlet = valve.outlet_positive if x >= 0.0 else valve.outlet_negative
    if k + 1 >= len(valve.knots):
        return Orifices(0.0, 0.0, 0.0)
    sign, width = (1.0 if x >= 0.0 else -1.0), valve.knots[k + 1] - valve.knots[k]
    return Orifices(*(sign * (curve[k + 1] - curve[k]) / width for curve in (valve.inlet, valve.bypass, outlet)))


def circuit_pump(machine, circuit, *, relief=None, **values):
    """The pump of a circuit, with other values."""
    pump = machine.circuit(circuit).pump._replace(**values)
    return limited_pump(pump.flow, pump.relief if relief is None else relief, machine.tank.return_pressure, pump)


def changed(machine, name, **parts):
    """The machine with other parts of one function; a dict changes some values of the part that it is given for."""
    found = machine.function(name)
    new = {key: getattr(found, key)._replace(**p) if isinstance(p, dict) else p for key, p in parts.items()}
    return machine._replace(functions=tuple(f._replace(**new) if f is found else f for f in machine.functions))
