"""`prepare`: a machine and a step size -> one flat set of precomputed floats, as the kernels want it."""

from collections.abc import Collection
from math import isfinite
from typing import NamedTuple

from polydraulic.errors import InputError
from polydraulic.machine.actuator import Triangle, motor_displacement, prepare_cylinder
from polydraulic.machine.hose import LineStep, prepare_line
from polydraulic.machine.linkage import Held, Linkage, prepare_linkage
from polydraulic.machine.pilot import PilotStep, prepare_pilot
from polydraulic.parameters.schema import LINKS, Arm, Friction, Machine, Stops


class SwingPlant(NamedTuple):
    """The swing's parts without its valve, which belongs to the flow model."""

    pilot: PilotStep
    line: LineStep
    displacement: float  # m3/rad
    friction: Friction
    stops: Stops


class ArmPlant(NamedTuple):
    """Parts of boom or stick without the valve."""

    pilot: PilotStep
    line: LineStep
    cylinder: Triangle
    friction: Friction
    stops: Stops


class Plant(NamedTuple):
    """Everything but pumps and valves, for one step size."""

    dt: float
    swing: SwingPlant
    boom: ArmPlant
    stick: ArmPlant
    linkage: Linkage
    locked: Held


def check_time_step(dt: float) -> None:
    """Raise InputError unless `dt` is a positive, finite time in s."""
    if not (isfinite(dt) and dt > 0.0):
        raise InputError(f"dt = {dt} s: the time step must be positive and finite, for example 0.005")


def prepare(machine: Machine, dt: float, locked: Collection[str] = ()) -> Plant:
    """Precompute all of a `machine` that does not change during a run.

    Parameters
    ----------
    machine : Machine
    dt : float, s
    locked : collection of str
        Links whose joints are held.

    Raises
    ------
    InputError
        If `dt` is not a positive time.
    """
    check_time_step(dt)

    def arm(link: Arm, direction: float) -> ArmPlant:
        return ArmPlant(
            pilot=prepare_pilot(link.pilot, machine.spool.knots[-1], dt),
            line=prepare_line(link.line, machine.tank, dt),
            cylinder=prepare_cylinder(link.cylinder, direction),
            friction=link.friction,
            stops=link.stops,
        )

    swing = machine.swing
    return Plant(
        dt=dt,
        swing=SwingPlant(
            pilot=prepare_pilot(swing.pilot, machine.spool.knots[-1], dt),
            line=prepare_line(swing.line, machine.tank, dt),
            displacement=motor_displacement(swing.motor),
            friction=swing.friction,
            stops=swing.stops,
        ),
        boom=arm(machine.boom, 1.0),
        stick=arm(machine.stick, -1.0),
        linkage=prepare_linkage(machine),
        locked=Held(*(link in locked for link in LINKS)),
    )
