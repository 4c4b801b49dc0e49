"""A first machine file: another machine's numbers, with a comment on how to get one's own."""

import re

_HEAD = """\
# A machine of your own, begun from {like}. Every number is {{ value, unit, source }}; any unit of the field is understood.
#
# What matters most, in this order: pins of cylinders and bores (drawing, or a tape measure), pump flow and relief settings (data
# sheet, test port), masses and centres of gravity (data sheet; the volume of steel is a good estimate), then the valves. Orifice
# conductances are on no data sheet: keep those below, scaled to your pump's flow, until a log of the machine gives better ones.
# What may be left as an estimate says so in its comment. `polydraulic machine check FILE` lists what is wrong or unusual.
#
# Frames: x forward, y to the left, z upward while all joints are at zero. A link's frame has its origin in its joint.
# Coordinates that are left out are zero; what is left out everywhere costs no computing time.
#
# A function may have more than stands below; without these lines it has not:
#   friction.sticks = {{ value = true, source = "dry friction holds the joint, instead of being smoothed" }}
#   backlash = {{ value = 0.1, unit = "deg", source = "how far the link can be moved while its actuator stands" }}
#   valve.hysteresis = {{ value = 0.2, unit = "mm", source = "how far the spool is driven back before the orifices follow" }}
#   valve.flow_force.spring_rate = {{ value = 25, unit = "N/mm", source = "of the spring that centres the spool" }}
#   valve.flow_force.density = {{ value = 870, unit = "kg/m3", source = "of the oil" }}
#   valve.flow_force.jet_angle = {{ value = 69, unit = "deg", source = "of the jets, at sharp edges" }}
#
# A file may say what the machine stands on, for tipping and lift charts; the mechanics do without:
#   [chassis]
#   mass = {{ value = 7500, unit = "kg", source = "of all that no joint moves" }}
#   cg.z = {{ value = 0.5, unit = "m", source = "its centre of gravity" }}
#   tracks.gauge = {{ value = 2.38, unit = "m", source = "between the centre lines of the tracks" }}
#   tracks.length = {{ value = 3.65, unit = "m", source = "from idler to sprocket" }}
#   contacts.left.y = {{ value = 1.8, unit = "m", source = "in place of tracks: a point for each wheel or outrigger" }}
#   slope.pitch = {{ value = 5, unit = "deg", source = "how the ground rises along x; roll: along y" }}

"""
_HINTS = {
    "at.x": "where this link's joint is, in the frame of its parent: drawing, or measured from pin to pin",
    "mass": "weigh it, or volume of steel times 7850 kg/m3; 10 % off moves a static pressure by about as much",
    "cg.x": "centre of gravity from the joint: lift the link at one end and weigh it there, or about 45 % of its length",
    "inertia.xx": "about the centre of gravity; m L^2 / 12 of a bar of length L will do as an estimate",
    "base.x": "the cylinder's base pin, in the frame of the parent link",
    "rod_pin.x": "the cylinder's rod pin, in the frame of the link that it moves",
    "hinge.x": "where the rocker of the bucket linkage turns, in the frame of the parent link",
    "knee.x": "where rocker, coupler and rod meet while the bucket's joint is at zero, in the frame of the parent link",
    "pin.x": "where the coupler holds the bucket, in the bucket's frame",
    "gain": "travel of the spool per volt of the joystick; full lever should give full travel",
    "time_constant": "63 % of a step of the lever: film the spool, or 0.1 to 0.3 s as an estimate",
    "dead_time": "from the lever's motion to the first pressure change; 0 as an estimate",
    "knots": "travel at which the tables below have their values: deadband, where the bypass closes, full travel",
    "inlet": "from pump to actuator; full opening should pass the pump's flow at 10 to 20 ba",
    "bypass": "from pump onward: wide open at the centre, shut from the knot on at which the bypass closes",
    "outlet_positive": "from actuator to tank while the spool is positive; keeps a load from falling",
    "compliance_a": "oil volume of line and actuator side / 1.5e9 Pa, and twice to five times that with hoses; an estimate will do",
    "leakage": "0 for cylinders; for motors a few per cent of the flow at full pressure",
    "relief": "setting of the relief valve: data sheet, or the gauge at a stalled actuato",
    "displacement": "volume of the motor per revolution: its nameplate",
    "gear_ratio": "revolutions of the motor per revolution of the link: data sheet, or count teeth",
    "bore": "inner diameter of the cylinder: data sheet, or outer diameter less 2 x 10 mm",
    "coulomb": "friction at the joint: pressure difference at slow, unloaded motion times area and lever arm; an estimate will do",
    "viscous": "how fast it may fall or coast; an estimate will do, and too little makes the machine oscillate for long",
    "low": "end stops of the joint, from its zero",
    "angle": "where the joint stands at the start",
    "flow": "displacement of the pump times engine speed: data sheet",
    "conductance": "of the crossover, over the travel of the spool that it feeds: flow at a pressure drop, divided by the root of the drop; an estimate will do",
    "opening_pressure": "of the crossover's check valve: data sheet, or 0.3 to 1 bar as an estimate",
    "tracks.gauge": "between the centre lines of the tracks, over which it tips to the side: data sheet",
    "tracks.length": "between the last wheels that carry, over which it tips forward: data sheet",
    "contacts.front_left.x": "where a wheel or an outrigger carries, in the ground's frame: drawing, or a tape measure",
    "torque_limit_start": "pressure above which the pump delivers less, so that the engine does not stall",
}


def skeleton(text: str, like: str) -> str:
    """Text of a machine file to begin with.

    Parameters
    ----------
    text : str
        File of the machine to begin from.
    like : str
        What that machine is called.
    """
    said: set[str] = set()
    lines = []
    for line in text.split("\n"):
        key = re.match(r"([\w.]+) = \{", line)
        if key and key[1] in _HINTS and key[1] not in said:
            said.add(key[1])
            lines.append(f"# {_HINTS[key[1]]}")
        lines.append(line)
    body = "\n".join(lines)
    return _HEAD.format(like=like) + re.sub(r"\A(?:#.*\n)+\n*", "", body)
