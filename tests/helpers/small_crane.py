"""A small crane in a few lines: a slewing motor and a boom cylinder in series on one pump, a telescope on another."""

from polydraulic.parameters.layout.parts import Effects

CRANE = """
title = "Small crane"
gravity = {value = 9.81, unit = "m/s2", source = "standard"}
tip = {link = "arm", at.x = {value = 1.5, unit = "m", source = "made up"}}

[tank]
return_pressure = {value = 3, unit = "bar", source = "made up"}
floor = {value = 0, unit = "bar", source = "made up"}

[links.column]
parent = "ground"
joint = "revolute"
axis = "z"
mass = {value = 300, unit = "kg", source = "made up"}
cg.z = {value = 0.6, unit = "m", source = "made up"}
inertia.zz = {value = 40, unit = "kg m2", source = "made up"}

[links.boom]
parent = "column"
joint = "revolute"
axis = "-y"
at.x = {value = 0.1, unit = "m", source = "made up"}
at.z = {value = 1.5, unit = "m", source = "made up"}
mass = {value = 250, unit = "kg", source = "made up"}
cg.x = {value = 1.4, unit = "m", source = "made up"}
cg.z = {value = 0.05, unit = "m", source = "made up"}
inertia.xx = {value = 4, unit = "kg m2", source = "made up"}
inertia.yy = {value = 160, unit = "kg m2", source = "made up"}
inertia.zz = {value = 161, unit = "kg m2", source = "made up"}

[links.arm]
parent = "boom"
joint = "prismatic"
axis = "x"
at.x = {value = 1.8, unit = "m", source = "made up"}
mass = {value = 120, unit = "kg", source = "made up"}
cg.x = {value = 0.6, unit = "m", source = "made up"}
inertia.xx = {value = 2, unit = "kg m2", source = "made up"}
inertia.yy = {value = 40, unit = "kg m2", source = "made up"}
inertia.zz = {value = 40, unit = "kg m2", source = "made up"}

[functions.slew]
moves = "column"
actuator = "motor"
motor.displacement = {value = 80, unit = "cm3/rev", source = "made up"}
motor.gear_ratio = {value = 60, unit = "1", source = "made up"}
FRICTION(400, N m)
stops.low = {value = -200, unit = "deg", source = "made up"}
stops.high = {value = 200, unit = "deg", source = "made up"}
initial.angle = {value = 10, unit = "deg", source = "made up"}
COMMON

[functions.lift]
moves = "boom"
actuator = "cylinder"
cylinder.number = {value = 1, unit = "1", source = "made up"}
cylinder.bore = {value = 90, unit = "mm", source = "made up"}
cylinder.rod = {value = 50, unit = "mm", source = "made up"}
base.x = {value = 0.15, unit = "m", source = "made up"}
base.z = {value = 0.5, unit = "m", source = "made up"}
rod_pin.x = {value = 0.7, unit = "m", source = "made up"}
rod_pin.z = {value = -0.1, unit = "m", source = "made up"}
FRICTION(300, N m)
stops.low = {value = -20, unit = "deg", source = "made up"}
stops.high = {value = 70, unit = "deg", source = "made up"}
initial.angle = {value = 20, unit = "deg", source = "made up"}
COMMON

[functions.extend]
moves = "arm"
actuator = "ram"
cylinder.number = {value = 1, unit = "1", source = "made up"}
cylinder.bore = {value = 60, unit = "mm", source = "made up"}
cylinder.rod = {value = 40, unit = "mm", source = "made up"}
FRICTION(500, N)
stops.low = {value = 0, unit = "m", source = "made up"}
stops.high = {value = 1.4, unit = "m", source = "made up"}
initial.position = {value = 0.3, unit = "m", source = "made up"}
COMMON

[circuits.main]
kind = "series"
functions = ["slew", "lift"]
pump.flow = {value = 40, unit = "L/min", source = "made up"}
PUMP

[circuits.second]
kind = "series"
functions = ["extend"]
pump.flow = {value = 20, unit = "gpm", source = "made up"}
PUMP
"""
_COMMON = """initial.p_a = {value = 10, unit = "bar", source = "made up"}
initial.p_b = {value = 10, unit = "bar", source = "made up"}
pilot.gain = {value = 8, unit = "mm/V", source = "made up"}
pilot.time_constant = {value = 0.1, unit = "s", source = "made up"}
pilot.dead_time = {value = 0.02, unit = "s", source = "made up"}
valve.knots = {value = [0, 1, 4, 8], unit = "mm", source = "made up"}
valve.inlet = {value = [0, 0, 6, 20], unit = "l/min/bar^0.5", source = "made up"}
valve.bypass = {value = [30, 14, 2, 0], unit = "l/min/bar^0.5", source = "made up"}
valve.outlet_positive = {value = [0, 0, 5, 16], unit = "l/min/bar^0.5", source = "made up"}
valve.outlet_negative = {value = [0, 0, 3, 9], unit = "l/min/bar^0.5", source = "made up"}
line.compliance_a = {value = 0.002, unit = "l/bar", source = "made up"}
line.compliance_b = {value = 0.002, unit = "l/bar", source = "made up"}
line.leakage = {value = 0.005, unit = "l/min/bar", source = "made up"}
line.relief = {value = 280, unit = "bar", source = "made up"}"""
_PUMP = """pump.relief = {value = 250, unit = "bar", source = "made up"}
pump.torque_limit_enabled = {value = true, source = "made up"}
pump.torque_limit_start = {value = 120, unit = "bar", source = "made up"}
pump.torque_limit_exponent = {value = 1, unit = "1", source = "made up"}"""


def _friction(dry: float, unit: str) -> str:
    damping, speed = ("N m s", "rad/s") if unit == "N m" else ("N s/m", "m/s")
    numbers = (
        ("coulomb", dry, unit),
        ("static", 1.5 * dry, unit),
        ("viscous", 3.0 * dry, damping),
        ("smoothing", 0.02, speed),
    )
    return "\n".join(
        f'friction.{key} = {{value = {value}, unit = "{of}", source = "made up"}}'
        for key, value, of in (*numbers, ("stribeck", 0.05, speed))
    )


def crane_text() -> str:
    """The crane as a TOML file."""
    text = CRANE.replace("COMMON", _COMMON).replace("PUMP", _PUMP)
    for dry, unit in ((400, "N m"), (300, "N m"), (500, "N")):
        text = text.replace(f"FRICTION({dry}, {unit})", _friction(dry, unit))
    return text.lstrip()


def write_crane(folder, old: str = "", new: str = "", name: str = "crane.toml"):
    """Write the crane's file, with one text in it replaced, which must be there; returns the path."""
    text = crane_text()
    assert old in text
    path = folder / name
    path.write_text(text.replace(old, new) if old else text, encoding="utf-8")
    return path


_CROSSOVER = """[circuits.main]
kind = "crossover"
functions = ["extend", "slew", "lift"]
giving.flow = {value = 20, unit = "gpm", source = "made up"}
GIVING
taking.flow = {value = 40, unit = "L/min", source = "made up"}
TAKING
crossover.conductance = {value = [0, 1, 6, 12], unit = "l/min/bar^0.5", source = "made up"}
crossover.opening_pressure = {value = 1.5, unit = "bar", source = "made up"}
"""


def crossover_crane_text() -> str:
    """The crane with both pumps joined: that of the telescope also feeds the boom."""
    text, circuits = crane_text(), _CROSSOVER
    for part in ("giving", "taking"):
        circuits = circuits.replace(part.upper(), _PUMP.replace("pump.", f"{part}."))
    return text[: text.index("[circuits.main]")] + circuits


def write_crossover_crane(folder, old: str = "", new: str = ""):
    """Write that crane's file, with one text in it replaced, which must be there; returns the path."""
    text = crossover_crane_text()
    assert old in text
    path = folder / "crossover_crane.toml"
    path.write_text(text.replace(old, new) if old else text, encoding="utf-8")
    return path


_EFFECTS = """
friction.sticks = {value = true, source = "made up"}
backlash = {value = 0.3, unit = "UNIT", source = "made up"}
valve.hysteresis = {value = 0.3, unit = "mm", source = "made up"}
valve.flow_force.spring_rate = {value = 30, unit = "N/mm", source = "made up"}
valve.flow_force.density = {value = 870, unit = "kg/m3", source = "made up"}
valve.flow_force.jet_angle = {value = 69, unit = "deg", source = "made up"}
"""


def crane_text_with_effects() -> str:
    """The crane with every effect that a function may have, of all its functions."""
    text = crane_text()
    for f, unit in (("slew", "deg"), ("lift", "deg"), ("extend", "mm")):
        text = text.replace(f"[functions.{f}]", f"[functions.{f}]{_EFFECTS.replace('UNIT', unit).rstrip()}")
    return text


def with_effects(machine, **effects):
    """The machine with these effects, as fields of `Effects`, in all its functions and no others."""
    return machine._replace(functions=tuple(f._replace(effects=Effects(**effects)) for f in machine.functions))
