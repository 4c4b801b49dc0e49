"""`prepare`: a machine and a step size -> one flat set of precomputed floats, as the kernels want it."""

from math import isfinite
from typing import NamedTuple

from polydraulic.errors import InputError
from polydraulic.machine.actuator import Triangle, prepare_cylinder
from polydraulic.machine.hose import LineStep, prepare_line
from polydraulic.machine.linkage import Linkage, prepare_linkage
from polydraulic.machine.pilot import PilotStep, prepare_pilot
from polydraulic.parameters import Machine
from polydraulic.parameters.schema import Friction, Stops


class BoomPlant(NamedTuple):
    """The boom's parts without its valve, which belongs to the flow model."""

    pilot: PilotStep
    line: LineStep
    cylinder: Triangle
    friction: Friction
    stops: Stops


class Plant(NamedTuple):
    """Everything but pump and valves, for one step size."""

    dt: float
    boom: BoomPlant
    linkage: Linkage


def prepare(machine: Machine, dt: float) -> Plant:
    """Precompute all of a `machine` that does not change during a run.

    Raises
    ------
    InputError
        If `dt` is not a positive time.
    """
    if not (isfinite(dt) and dt > 0.0):
        raise InputError(f"dt = {dt} s: the time step must be positive and finite, for example 0.005")
    boom = machine.boom
    return Plant(
        dt=dt,
        boom=BoomPlant(
            pilot=prepare_pilot(boom.pilot, machine.spool, dt),
            line=prepare_line(boom.line, machine.tank, dt),
            cylinder=prepare_cylinder(boom.cylinder, direction=1.0),
            friction=boom.friction,
            stops=boom.stops,
        ),
        linkage=prepare_linkage(machine),
    )
