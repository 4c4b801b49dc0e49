"""A small crane that nobody builds, and runs of any machine that nobody simulated: joints swing between their stops."""

import numpy as np
from scipy.spatial.transform import Rotation

from polydraulic import load_machine
from polydraulic.parameters.layout.parts import LinkParameters, Pins
from polydraulic.parameters.schema import Initial, Stops
from polydraulic.tables import Table


def small_crane(slew_axis="z"):
    """A column that slews, a jib that a cylinder lifts, an extension that a ram pushes out."""
    machine = load_machine("cat215b_bucket")
    swing, boom, stick = (machine.function(name) for name in ("swing", "boom", "stick"))
    links = (
        LinkParameters(
            "column", "ground", "revolute", slew_axis, {"x": 0.4, "y": -0.1, "z": 0.2}, 250.0, {"z": 0.9}, {}
        ),
        LinkParameters("jib", "column", "revolute", "-y", {"x": 0.1, "z": 1.9}, 200.0, {"x": 1.2}, {}),
        LinkParameters("extension", "jib", "prismatic", "x", {"x": 2.4}, 80.0, {"x": 0.3}, {}),
    )
    pins = Pins(base={"x": 0.25, "z": 0.7}, rod={"x": 0.9, "z": -0.15})
    functions = (
        swing._replace(name="slew", moves="column", stops=Stops(-2.0, 2.0), initial=Initial(0.3, 0.0, 0.0)),
        boom._replace(
            name="lift", moves="jib", pins=pins, stops=Stops(-0.3, 1.2), initial=Initial(0.5, 0.0, 0.0)
        ),
        stick._replace(
            name="reach", moves="extension", actuator="ram", pins=None, stops=Stops(0.0, 1.1), initial=Initial(0.2, 0.0, 0.0)
        ),
    )  # fmt: skip
    circuits = (machine.circuits[0]._replace(name="work", functions=("slew", "lift", "reach")),)
    tip = ("extension", {"x": 0.5, "z": -0.2})
    return machine._replace(title="Small crane", links=links, functions=functions, circuits=circuits, tip=tip)


def spread(machine, rows):
    """Joint positions between the stops, each joint at its own pace, (rows, n_function); the first row is the first stop."""
    low, high = (np.clip([getattr(f.stops, end) for f in machine.functions], -3.0, 3.0) for end in ("low", "high"))
    phase = np.outer(np.linspace(0.0, 1.0, rows), np.arange(1, len(low) + 1))
    return low + (high - low) * (0.5 - 0.5 * np.cos(2.0 * np.pi * phase))


def transforms(machine, positions):
    """Turn and origin of every link by SciPy's rotations."""
    at = {"ground": (Rotation.identity(), np.zeros(3))}
    for f, q in zip(machine.functions, positions, strict=True):
        link = machine.link(f.moves)
        turn, origin = at[link.parent]
        axis = np.eye(3)["xyz".index(link.axis[-1])] * (-1.0 if link.axis[0] == "-" else 1.0)
        joint = np.array([link.at.get(c, 0.0) for c in "xyz"])
        if link.joint == "prismatic":
            at[link.name] = (turn, origin + turn.apply(joint + q * axis))
        else:
            at[link.name] = (turn * Rotation.from_rotvec(q * axis), origin + turn.apply(joint))
    return at


def point_at(machine, positions, link, point):
    """A point of a link in the ground's frame, (3,)."""
    turn, origin = transforms(machine, positions)[link]
    return origin + turn.apply([point.get(c, 0.0) for c in "xyz"])


def made_run(machine, rows=21, end=1.0, scale=1.0):
    """What `simulate` would give, with positions by `spread`."""
    positions = scale * spread(machine, rows)
    columns, units = {"time": np.linspace(0.0, end, rows)}, {"time": "s"}
    for place, f in enumerate(machine.functions):
        slides = machine.link(f.moves).joint == "prismatic"
        for name, unit in (("voltage", "V"), ("spool", "m"), ("q_in", "m3/s"), ("q_out", "m3/s"), ("p_in", "Pa")):
            columns[f"{f.name}.{name}"], units[f"{f.name}.{name}"] = np.linspace(0.0, 1.0 + place, rows), unit
        name, unit = (f"{f.name}.position", "m") if slides else (f"{f.name}.angle", "rad")
        columns[name], units[name] = positions[:, place], unit
    for circuit in machine.circuits:
        columns[f"{circuit.name}.p_pump"], units[f"{circuit.name}.p_pump"] = np.linspace(1e6, 2e6, rows), "Pa"
    tips = np.array([point_at(machine, row, *machine.tip) for row in positions])
    for name, values in zip(("x", "y", "z"), tips.T, strict=True):
        columns[f"effector.{name}"], units[f"effector.{name}"] = values, "m"
    circuits = {circuit.name: list(circuit.functions) for circuit in machine.circuits}
    return Table(columns, units, {"scenario": "made up", "circuits": circuits})
