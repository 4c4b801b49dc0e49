"""What sensors read of a random operator's work on the exact machine, as a log to identify from and as rows to learn networks from."""

from typing import Any

import numpy as np

from polydraulic import units
from polydraulic.elementary import sincos
from polydraulic.identification.machine.machine_log import Known, by_port
from polydraulic.machine.actuator import lever_arm
from polydraulic.machine.drives import Motor, prepare_drive
from polydraulic.measure.bench.sensors import Reading, Sensor
from polydraulic.measure.smoothing import differentiate
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import random_operator
from polydraulic.simulation.runs import simulate
from polydraulic.tables import Table
from polydraulic.thesis.excavator import LINKS
from polydraulic.thesis.measured.conditions import Conditions

RASTER = 0.02  # s, of all sensors
RANGES = {
    "m": units.to_si(0.564, "in"),
    "Pa": units.to_si(5000.0, "psi"),
    "m3/s": units.to_si(171.5, "in3/s"),
    "rad": 1.5,
}
STROKE = 0.8  # V, of the test runs
_WINDOW = 0.2  # s, of derivatives


def sensor_readings(machine: LayoutMachine, conditions: Conditions) -> dict[str, np.ndarray]:
    """What sensors read of a random operator's work, in SI, NaN where one is silent; time and the levers' voltages are known."""
    c = conditions
    scenario = random_operator(c.operator, 60.0 * c.minutes, limit=STROKE * c.stroke)
    run = simulate(machine, "exact", scenario, raster=RASTER)
    quantities = ["spool"] * c.spool_sensors + ["p_a", "p_b"] * c.pressure_sensors
    quantities += ["q_in", *["q_out"] * c.outlet_sensors] if c.flow_sensors else ["angle"]
    read = {"time": run["time"]} | {f"{link}.voltage": run[f"{link}.voltage"] for link in LINKS}
    for place, column in enumerate(f"{link}.{name}" for link in LINKS for name in quantities):
        unit = run.unit(column)
        sensor = Sensor(
            column, column, unit, RASTER, noise=c.noise * RANGES[unit], dropout=c.dropout, dropout_length=0.5
        )
        read[column] = Reading(sensor, np.random.default_rng([c.operator, place])).of(run)[1]
    if c.flow_sensors and not c.outlet_sensors:
        read |= {f"{link}.q_out": _outlet_flow(machine, link, read) for link in LINKS}
    return read


def log_of_readings(read: dict[str, np.ndarray]) -> Table:
    """As a log to identify from, which declares where a sensor is silent."""
    return Table(read, {}).partial()


def rows_for_networks(machine: LayoutMachine, read: dict[str, np.ndarray]) -> Table:
    """As rows to learn networks from, in which all sensors read something, by port; flows from joint angles where flows are not measured."""
    if not any(name.endswith(".q_in") for name in read):
        for link in LINKS:
            read = read | _flows(machine, link, read)
    return by_port(Known.of(machine), log_of_readings(read).whole(list(read)))


def _flows(machine: LayoutMachine, link: str, read: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Flows at a link's ports from its angle: volume for a radian times rate; the oil's compression is left out."""
    time, angle = read["time"], read[f"{link}.angle"]
    known = np.isfinite(angle)
    filled = np.interp(time, time[known], angle[known])
    rate = np.where(known, differentiate(filled, RASTER, _WINDOW), np.nan)
    drive = _drive(machine, link)
    if isinstance(drive, Motor):
        a = b = drive.displacement * rate
    else:
        speed = rate * [lever_arm(sincos(x), drive) for x in filled.tolist()]
        a, b = drive.area_a * speed, drive.area_b * speed
    forward = read[f"{link}.spool"] > 0.0
    return {f"{link}.q_in": np.where(forward, a, -b), f"{link}.q_out": np.where(forward, b, -a)}


def _drive(machine: LayoutMachine, link: str) -> Any:
    f = machine.function(link)
    return prepare_drive(f, machine.link(f.moves))


def _outlet_flow(machine: LayoutMachine, link: str, read: dict[str, np.ndarray]) -> np.ndarray:
    """Flow out of an actuator from the one into it, by the ratio of its areas; the oil's compression is left out."""
    drive = _drive(machine, link)
    if isinstance(drive, Motor):
        return read[f"{link}.q_in"]
    ratio = drive.area_b / drive.area_a
    spool = read[f"{link}.spool"]
    return np.where(np.isnan(spool), np.nan, read[f"{link}.q_in"] * np.where(spool > 0.0, ratio, 1.0 / ratio))
