"""What a machine consists of: every parameter with its SI unit and the range it may lie in, declared once.

The tree follows the machine: `Machine` -> link (`swing`, `boom`, `stick`) -> part (`pilot`, `valve`, `line`, ...).
Named tuples are immutable, typed, and understood by numba as they are. The loader, the error messages and the
documentation read unit and range from the annotations.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple

from polydraulic.parameters.quantity import Quantity
from polydraulic.parameters.values import replaced

LINKS = ("swing", "boom", "stick")
CIRCUITS = {"boom": ("boom",), "series": ("swing", "stick")}  # links that a pump feeds
N_KNOT = 6


Knots = tuple[float, float, float, float, float, float]

Length = Annotated[float, Quantity("m", above=0.0)]
Coordinate = Annotated[float, Quantity("m")]
Angle = Annotated[float, Quantity("rad")]
Mass = Annotated[float, Quantity("kg", above=0.0)]
Inertia = Annotated[float, Quantity("kg m2", above=0.0)]
Pressure = Annotated[float, Quantity("Pa", low=0.0)]
PositivePressure = Annotated[float, Quantity("Pa", above=0.0)]
Flow = Annotated[float, Quantity("m3/s", above=0.0)]
Compliance = Annotated[float, Quantity("m3/Pa", above=0.0)]
Torque = Annotated[float, Quantity("N m", low=0.0)]
Speed = Annotated[float, Quantity("rad/s", above=0.0)]
Conductances = Annotated[Knots, Quantity("m3/s/Pa^0.5", low=0.0)]


class Pumps(NamedTuple):
    """Two pumps: one for the boom, one for swing and stick in series; one relief setting."""

    boom_flow: Flow
    series_flow: Flow
    relief: PositivePressure
    torque_limit_enabled: bool
    torque_limit_start: PositivePressure
    torque_limit_exponent: Annotated[float, Quantity("1", above=0.0, high=2.0)]


class Tank(NamedTuple):
    """Return line, and the pressure below which make-up valves let no line fall."""

    return_pressure: Pressure
    floor: Pressure


class Spool(NamedTuple):
    """Geometry common to the three main-valve spools; `knots` are the breakpoints of the orifice tables."""

    knots: Annotated[Knots, Quantity("m", low=0.0)]
    deadband: Length
    bypass_closed: Length


class Pilot(NamedTuple):
    """Pilot valve: tau dx/dt + x = clip(gain v, +-travel), after a dead time."""

    gain: Annotated[float, Quantity("m/V", above=0.0)]
    time_constant: Annotated[float, Quantity("s", above=0.0)]
    dead_time: Annotated[float, Quantity("s", low=0.0)]


class Valve(NamedTuple):
    """Orifice conductances K a(abs(x)) at the spool's knots, linear between: Q = K a sqrt(drop)."""

    inlet: Conductances
    bypass: Conductances
    outlet_positive: Conductances
    outlet_negative: Conductances


class Line(NamedTuple):
    """The two hoses of an actuator; A is pressurised for a positive spool."""

    compliance_a: Compliance
    compliance_b: Compliance
    leakage: Annotated[float, Quantity("m3/s/Pa", low=0.0)]
    relief: PositivePressure


class Cylinder(NamedTuple):
    """Equal cylinders between two pins; the included angle of the triangle is offset +- joint angle."""

    number: Annotated[float, Quantity("1", low=1.0)]
    bore: Length
    rod: Length
    r_base: Length
    r_link: Length
    angle_offset: Angle


class SwingMotor(NamedTuple):
    """Hydraulic motor behind a gear."""

    displacement: Annotated[float, Quantity("m3/rad", above=0.0)]
    gear_ratio: Annotated[float, Quantity("1", above=0.0)]


class Body(NamedTuple):
    """Rigid link: centre of gravity in polar coordinates from its joint, inertia about the centre."""

    mass: Mass
    cg: Length
    cg_angle: Angle
    inertia_transverse: Inertia
    inertia_longitudinal: Inertia


class UpperStructure(NamedTuple):
    """Inertia about the swing axis without boom and stick."""

    inertia: Inertia


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


class Swing(NamedTuple):
    """The upper structure on its ring."""

    pilot: Pilot
    valve: Valve
    line: Line
    motor: SwingMotor
    body: UpperStructure
    friction: Friction
    stops: Stops
    initial: Initial


class Arm(NamedTuple):
    """Boom or stick: a link moved by cylinders.

    A is the side that moves the joint towards positive angles: the boom's head side, the stick's rod side.
    """

    pilot: Pilot
    valve: Valve
    line: Line
    cylinder: Cylinder
    body: Body
    friction: Friction
    stops: Stops
    initial: Initial


class Geometry(NamedTuple):
    """Kinematics: boom foot at (a1, d) from the swing axis, link lengths, gravity."""

    a1: Coordinate
    d: Coordinate
    boom_length: Length
    stick_length: Length
    gravity: Annotated[float, Quantity("m/s2", low=0.0)]


class Machine(NamedTuple):
    """A whole excavator, SI."""

    pumps: Pumps
    tank: Tank
    spool: Spool
    swing: Swing
    boom: Arm
    stick: Arm
    geometry: Geometry

    def with_values(self, values: Mapping[str, float | bool | Sequence[float]]) -> "Machine":
        """Return a copy with other values.

        Parameters
        ----------
        values : mapping from path to value in SI
            Paths are those of a parameter file: ``boom.body.mass``. A table, ``boom.valve.inlet``, takes all its six numbers;
            ``boom.valve.inlet[3]`` is one of them. Values are put in their places in the order of the mapping.

        Returns
        -------
        Machine

        Raises
        ------
        InputError
            Unknown paths, values out of their range, values that do not go together: all of them in one message.

        Examples
        --------
        >>> from polydraulic import load_machine
        >>> heavy = load_machine("cat215b").with_values({"boom.body.mass": 900, "pumps.torque_limit_enabled": True})
        >>> heavy.boom.body.mass, heavy.pumps.torque_limit_enabled
        (900.0, True)
        """
        return replaced(self, values)
