"""Under which a machine is measured."""

from typing import NamedTuple

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.thesis.excavator import with_pumps


class Conditions(NamedTuple):
    """Under which a machine is measured.

    Attributes
    ----------
    minutes : float
        Of operation.
    noise : float
        Standard deviation of every sensor, as a share of its range.
    stroke : float
        Share of the joystick travel of the test runs that the operator uses.
    dropout : float
        Share of the time in which a sensor gives nothing.
    flow_sensors : bool
        Without them there are sensors of the joint angles.
    limited : bool
        Whether the pumps have a torque limit.
    friction : float
        Of all joints, as a multiple of the machine's; the judges' machine has the same.
    outlet_sensors : bool
        Without those of the flows out of actuators, these follow from the flows in by the ratio of areas.
    operator : int
        Seed of the one who works.
    pressure_sensors, spool_sensors : bool
        Networks need both.
    """

    minutes: float = 30.0
    noise: float = 0.003
    stroke: float = 1.0
    dropout: float = 0.0
    flow_sensors: bool = True
    limited: bool = False
    friction: float = 1.0
    outlet_sensors: bool = True
    operator: int = 1000
    pressure_sensors: bool = True
    spool_sensors: bool = True


USUAL = Conditions()
NO_FLOWS = USUAL._replace(flow_sensors=False)
NO_PRESSURES = NO_FLOWS._replace(pressure_sensors=False)
COMMANDS = NO_PRESSURES._replace(spool_sensors=False)
# One condition at a time; the first entry of each is what it is compared over.
SWEEPS: dict[str, list[Conditions]] = {
    "operator": [USUAL._replace(operator=operator) for operator in (1000, 1100, 1200)],
    "minutes": [USUAL._replace(minutes=minutes) for minutes in (2.0, 5.0, 10.0, 30.0)],
    "noise": [USUAL._replace(noise=noise) for noise in (0.0, 0.001, 0.003, 0.01, 0.03)],
    "stroke": [USUAL._replace(stroke=stroke) for stroke in (0.6, 0.8, 1.0)],
    "dropout": [USUAL._replace(dropout=dropout) for dropout in (0.0, 0.05, 0.2)],
    "sensors": [USUAL, NO_FLOWS, NO_PRESSURES, COMMANDS],
    "outlet sensors": [USUAL._replace(outlet_sensors=has) for has in (True, False)],
    "torque limit": [USUAL._replace(limited=limited) for limited in (False, True)],
    "friction": [USUAL._replace(friction=friction) for friction in (0.0, 1.0, 5.0)],
    "friction without flow sensors": [NO_FLOWS._replace(friction=friction) for friction in (0.0, 1.0, 5.0)],
}


def conditions_in_words(conditions: Conditions) -> str:
    """Conditions in words."""
    c = conditions
    missing = [
        what
        for what, has in (("flow", c.flow_sensors), ("pressure", c.pressure_sensors), ("spool", c.spool_sensors))
        if not has
    ]
    words = [f"{c.minutes:g} min", f"sensor noise {100.0 * c.noise:g} %", f"joystick travel {100.0 * c.stroke:g} %"]
    words += [f"sensors silent {100.0 * c.dropout:g} % of the time"] if c.dropout else []
    words += [f"no {' or '.join(missing)} sensors"] if missing else []
    words += [] if c.outlet_sensors else ["no outlet-flow sensors"]
    words += ["pumps with a torque limit"] if c.limited else []
    words += [f"{c.friction:g} times the friction" if c.friction else "no friction"] if c.friction != 1.0 else []
    words += [f"logged from operator {c.operator}"] if c.operator != USUAL.operator else []
    return ", ".join(words)


def machine_under(machine: LayoutMachine, conditions: Conditions) -> LayoutMachine:
    """The machine that works, and is compared with: its friction and its pumps' torque limit."""
    rubbing = []
    for f in machine.functions:
        torques = {name: conditions.friction * getattr(f.friction, name) for name in ("coulomb", "static", "viscous")}
        rubbing.append(f._replace(friction=f.friction._replace(**torques)))
    return with_pumps(machine._replace(functions=tuple(rubbing)), torque_limit_enabled=conditions.limited)
