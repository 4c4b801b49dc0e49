"""Parts that machines of all layouts have, every number with its SI unit and the range it may lie in, declared once.

Named tuples are immutable, typed, and understood by numba as they are. The loader, the error messages and the documentation read unit and
range from the annotations.
"""

from typing import Annotated, NamedTuple

from polydraulic.parameters.quantity import Quantity

Length = Annotated[float, Quantity("m", above=0.0)]
Coordinate = Annotated[float, Quantity("m")]
Angle = Annotated[float, Quantity("rad")]
Pressure = Annotated[float, Quantity("Pa", low=0.0)]
PositivePressure = Annotated[float, Quantity("Pa", above=0.0)]
Flow = Annotated[float, Quantity("m3/s", above=0.0)]
Torque = Annotated[float, Quantity("N m", low=0.0)]
Speed = Annotated[float, Quantity("rad/s", above=0.0)]
Compliance = Annotated[float, Quantity("m3/Pa", above=0.0)]


class Tank(NamedTuple):
    """Return line, and the pressure below which make-up valves let no line fall."""

    return_pressure: Pressure
    floor: Pressure


class Pilot(NamedTuple):
    """Pilot valve: tau dx/dt + x = clip(gain v, +-travel), after a dead time."""

    gain: Annotated[float, Quantity("m/V", above=0.0)]
    time_constant: Annotated[float, Quantity("s", above=0.0)]
    dead_time: Annotated[float, Quantity("s", low=0.0)]


class Line(NamedTuple):
    """The two hoses of an actuator; A is pressurised for a positive spool. Leakage is from A to B, external leakage from each to the tank."""

    compliance_a: Compliance
    compliance_b: Compliance
    leakage: Annotated[float, Quantity("m3/s/Pa", low=0.0)]
    relief: PositivePressure
    external_leakage: Annotated[float, Quantity("m3/s/Pa", low=0.0)] = 0.0


class SwingMotor(NamedTuple):
    """Hydraulic motor behind a gear."""

    displacement: Annotated[float, Quantity("m3/rad", above=0.0)]
    gear_ratio: Annotated[float, Quantity("1", above=0.0)]


class Friction(NamedTuple):
    """Joint friction: (coulomb + (static - coulomb) exp(-(w/stribeck)^2)) tanh(w/smoothing) + viscous w."""

    coulomb: Torque
    static: Torque
    viscous: Annotated[float, Quantity("N m s", low=0.0)]
    smoothing: Speed
    stribeck: Speed


class Stops(NamedTuple):
    """Inelastic end stops of a joint."""

    low: Angle
    high: Angle


class Initial(NamedTuple):
    """State at the start; spools are centred and joints at rest."""

    angle: Angle
    p_a: Pressure
    p_b: Pressure
