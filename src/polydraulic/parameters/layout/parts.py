"""What a machine of any layout consists of: every parameter with its SI unit and the range it may lie in, declared once.

Links form a tree, a function moves one link through an actuator, a circuit is a pump with the valves of its functions in their order.
"""

from collections.abc import Mapping
from math import inf
from typing import Annotated, NamedTuple

from polydraulic.parameters.quantity import Quantity
from polydraulic.parameters.schema import (
    Coordinate,
    Flow,
    Friction,
    Initial,
    Length,
    Line,
    Pilot,
    PositivePressure,
    Pressure,
    Stops,
    SwingMotor,
)

MOST_LINKS, MOST_FUNCTIONS, MOST_IN_SERIES = 12, 12, 6
FEWEST_KNOTS, MOST_KNOTS = 2, 16
GROUND = "ground"
AXES = ("x", "y", "z", "-x", "-y", "-z")
COORDINATES = ("x", "y", "z")
MOMENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
JOINTS = ("revolute", "prismatic")
# of functions, for those who hold levers
ROLES = (
    "swing",
    "boom",
    "stick",
    "bucket",
    "front_bucket",
    "extension",
    "auxiliary",
)

Point = Mapping[str, float]  # coordinates that the file declares, m; the others are zero whatever the numbers are

GRAVITY = Quantity("m/s2", low=0.0, high=30.0)
POINT = Quantity("m")
MASS = Quantity("kg", low=0.0)
MOMENT = Quantity("kg m2")
CONDUCTANCE = Quantity("m3/s/Pa^0.5", low=0.0)
OPENING = Quantity("Pa", low=0.0)
TRAVEL = Quantity("m", low=0.0)
TURN = Quantity("rad", low=0.0)


class LinkParameters(NamedTuple):
    """A rigid body behind a joint.

    Attributes
    ----------
    name, parent : str
        `parent` is another link or ``ground``.
    joint : str
        ``revolute`` or ``prismatic``.
    axis : str
        Of the joint, one of `AXES`, in the parent's frame; all frames are parallel while the joints are at zero.
    at : Point
        Of the joint, in the parent's frame.
    mass : float, kg
    cg : Point
        In the link's frame, whose origin is the joint.
    inertia : mapping from one of `MOMENTS` to kg m2
        About the centre of gravity, along the axes of the link's frame.
    """

    name: str
    parent: str
    joint: str
    axis: str
    at: Point
    mass: float
    cg: Point
    inertia: Mapping[str, float]


class CylinderSize(NamedTuple):
    """Equal cylinders between a pin on the parent link and one on the link that is moved."""

    number: Annotated[float, Quantity("1", low=1.0, high=12.0)]
    bore: Length
    rod: Length


class Pins(NamedTuple):
    """Where a cylinder is held: `base` in the parent's frame, `rod` in the moved link's."""

    base: Point
    rod: Point


class FourBar(NamedTuple):
    """A bucket's linkage: the cylinder turns a rocker about `hinge`, and a coupler takes the link along.

    `base` (of the cylinder) and `hinge` lie in the parent's frame, `pin` in the moved link's; `knee` says where rocker, coupler and
    rod meet while the joint is at zero, in the parent's frame.
    """

    base: Point
    hinge: Point
    knee: Point
    pin: Point


class ValveCurves(NamedTuple):
    """Orifice conductances K a over the spool's travel, linear between the knots: Q = K a sqrt(drop)."""

    knots: tuple[float, ...]  # m
    inlet: tuple[float, ...]  # m3/s/Pa^0.5
    bypass: tuple[float, ...]
    outlet_positive: tuple[float, ...]
    outlet_negative: tuple[float, ...]


class SlideFriction(NamedTuple):
    """`Friction` of a prismatic joint: forces instead of torques."""

    coulomb: Annotated[float, Quantity("N", low=0.0)]
    static: Annotated[float, Quantity("N", low=0.0)]
    viscous: Annotated[float, Quantity("N s/m", low=0.0)]
    smoothing: Annotated[float, Quantity("m/s", above=0.0)]
    stribeck: Annotated[float, Quantity("m/s", above=0.0)]


class SlideStops(NamedTuple):
    """Inelastic end stops of a prismatic joint."""

    low: Coordinate
    high: Coordinate


class SlideInitial(NamedTuple):
    """State of a prismatic joint at the start; spools are centred and joints at rest."""

    position: Coordinate
    p_a: Pressure
    p_b: Pressure


class FlowForce(NamedTuple):
    """What the oil's jets push a spool back with, against its spring: force sqrt(2 density) cos(jet_angle) K a dp at inlet and outlet."""

    spring_rate: Annotated[float, Quantity("N/m", above=0.0)]
    density: Annotated[float, Quantity("kg/m3", above=0.0)]
    jet_angle: Annotated[float, Quantity("rad", low=0.0, high=1.5707963267948966)]


class Effects(NamedTuple):
    """Effects that a function has only if the file declares them; those that it does not declare cost nothing.

    Attributes
    ----------
    sticks : bool
        Whether dry friction holds the joint at rest, instead of being smoothed.
    backlash : float or None, rad or m
        How far the joint can move while its actuator stands.
    hysteresis : float or None, m
        How far the pilot drives the spool back before the orifices follow.
    flow_force : FlowForce or None
    """

    sticks: bool = False
    backlash: float | None = None
    hysteresis: float | None = None
    flow_force: FlowForce | None = None

    @property
    def declared(self) -> tuple[str, ...]:
        """Keys of those that are declared, as in a file below the function."""
        keys = ("friction.sticks", "backlash", "valve.hysteresis", "valve.flow_force")
        return tuple(key for key, value in zip(keys, self, strict=True) if value is not None and value is not False)


class Seen(NamedTuple):
    """How far the log went that a valve's curves were identified from; beyond, they are what was assumed before.

    Attributes
    ----------
    travel : float, m
        Largest travel of the spool, to either side.
    pressure : float, Pa
        Largest one at the pressurised port of the open valve; inf if none was measured.
    """

    travel: float
    pressure: float = inf


class MachineFunction(NamedTuple):
    """What an operator moves with one lever.

    Attributes
    ----------
    name : str
    moves : str
        The link.
    actuator : str
        ``motor``, ``cylinder``, ``four_bar`` or ``ram`` (a cylinder along a prismatic joint).
    drive : SwingMotor or CylinderSize
        Sizes of the actuator.
    pins : Pins, FourBar or None
        Where it is held.
    pilot, valve, line, friction, stops, initial
        `Friction`, `Stops` and `Initial` hold N, N s/m, m/s and m for a prismatic joint.
    effects : Effects
    role : str
        What it is to whoever holds the levers, one of `ROLES`; empty where the file says nothing and the name is none of these.
    seen : Seen or None
        Of curves that were identified.
    """

    name: str
    moves: str
    actuator: str
    drive: SwingMotor | CylinderSize
    pins: Pins | FourBar | None
    pilot: Pilot
    valve: ValveCurves
    line: Line
    friction: Friction
    stops: Stops
    initial: Initial
    effects: Effects = Effects()
    role: str = ""
    seen: Seen | None = None


class PumpParameters(NamedTuple):
    """Flow of a pump, its relief valve and torque limit: above `torque_limit_start` Q = flow (start / P)^exponent."""

    flow: Flow
    relief: PositivePressure
    torque_limit_enabled: bool
    torque_limit_start: PositivePressure
    torque_limit_exponent: Annotated[float, Quantity("1", above=0.0, high=2.0)]


class SupplyCircuit(NamedTuple):
    """A pump and the valves that it feeds: the flow that passes a valve's bypass reaches the next one.

    The two pumps of a circuit with crossover are a circuit each, called ``NAME_giving`` and ``NAME_taking``.
    """

    name: str
    kind: str
    functions: tuple[str, ...]
    pump: PumpParameters

    @property
    def pump_path(self) -> str:
        """Where the numbers of its pump stand in a file."""
        name, _, part = self.name.rpartition("_") if self.kind == "crossover" else (self.name, "", "pump")
        return f"circuits.{name}.{part}"


class CrossoverValve(NamedTuple):
    """An orifice behind a check valve: Q = conductance sqrt(drop - opening_pressure), and nothing back.

    Attributes
    ----------
    conductance : tuple of float, m3/s/Pa^0.5
        At the knots of the valve that it feeds, whose spool opens it.
    opening_pressure : float, Pa
    """

    conductance: tuple[float, ...]
    opening_pressure: float


class Crossover(NamedTuple):
    """From the pump of one circuit to the node before the last valve of another one."""

    name: str
    giving: str
    taking: str
    valve: CrossoverValve
