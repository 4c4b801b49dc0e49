"""A machine of the older form as links, functions and circuits: the same numbers in other words."""

from math import cos, sin

from polydraulic.parameters.layout.parts import (
    CylinderSize,
    LinkParameters,
    MachineFunction,
    Pins,
    PumpParameters,
    SupplyCircuit,
    ValveCurves,
)
from polydraulic.parameters.layout.schema import LayoutMachine


def as_links(machine):
    """The layout of a `Machine`."""
    g, boom, stick = machine.geometry, machine.boom, machine.stick
    upper = dict.fromkeys(("xx", "yy", "zz"), machine.swing.body.inertia)
    links = (
        LinkParameters("swing", "ground", "revolute", "z", {}, 1.0, {}, upper),
        _body("boom", "swing", {"x": g.a1, "y": g.d}, boom.body),
        _body("stick", "boom", {"x": g.boom_length}, stick.body),
    )
    offset = boom.cylinder.angle_offset
    foot = {
        "x": g.a1 + boom.cylinder.r_base * cos(offset),
        "y": g.d,
        "z": -boom.cylinder.r_base * sin(offset),
    }
    offset = stick.cylinder.angle_offset
    middle = {"x": g.boom_length + stick.cylinder.r_base * cos(offset), "z": stick.cylinder.r_base * sin(offset)}
    pins = {
        "swing": None,
        "boom": Pins(foot, {"x": boom.cylinder.r_link}),
        "stick": Pins(middle, {"x": stick.cylinder.r_link}),
    }
    functions = tuple(_function(name, getattr(machine, name), machine.spool.knots, pins[name]) for name in pins)
    pumps = machine.pumps

    def pump(flow):
        return PumpParameters(
            flow,
            pumps.relief,
            pumps.torque_limit_enabled,
            pumps.torque_limit_start,
            pumps.torque_limit_exponent,
        )

    circuits = (
        SupplyCircuit("boom", "series", ("boom",), pump(pumps.boom_flow)),
        SupplyCircuit("series", "series", ("swing", "stick"), pump(pumps.series_flow)),
    )
    return LayoutMachine(
        "three links", g.gravity, machine.tank, links, functions, circuits, ("stick", {"x": g.stick_length})
    )


def _body(name, parent, at, body):
    inertia = {"xx": body.inertia_longitudinal, "yy": body.inertia_transverse, "zz": body.inertia_transverse}
    cg = {"x": body.cg * cos(body.cg_angle), "z": body.cg * sin(body.cg_angle)}
    return LinkParameters(name, parent, "revolute", "-y", at, body.mass, cg, inertia)


def _function(name, part, knots, pins):
    if pins is None:
        actuator, drive = "motor", part.motor
    else:
        actuator, drive = "cylinder", CylinderSize(part.cylinder.number, part.cylinder.bore, part.cylinder.rod)
    return MachineFunction(
        name, name, actuator, drive, pins, part.pilot, ValveCurves(knots, *part.valve), part.line, part.friction,
        part.stops, part.initial,
    )  # fmt: skip
