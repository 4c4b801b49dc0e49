"""The study that the thesis asked for: how much data of what quality buys what accuracy.

A random operator works on the exact machine, friction and end stops included; sensors read it; networks are learnt from what they
read, neither orifice areas nor pump pressures among it; the networks go into the machine and are judged by operators whom they
never saw.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from joblib import Parallel, cpu_count, delayed

from polydraulic import units
from polydraulic.elementary import sincos
from polydraulic.flow.dispatch import build_flow
from polydraulic.identification.machine.machine_learning import learn, tasks_of
from polydraulic.identification.machine.machine_log import Known, by_port
from polydraulic.machine.actuator import lever_arm
from polydraulic.machine.drives import Motor, prepare_drive
from polydraulic.measure.bench.sensors import Reading, Sensor
from polydraulic.measure.smoothing import differentiate
from polydraulic.networks.model.model import Model
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import load_scenario, random_operator
from polydraulic.simulation.layout.flow_points import sample_flow
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import LINKS, with_pumps
from polydraulic.thesis.three_links import SCENARIOS

RASTER = 0.02  # s, of all sensors
RANGES = {
    "m": units.to_si(0.564, "in"),
    "Pa": units.to_si(5000.0, "psi"),
    "m3/s": units.to_si(171.5, "in3/s"),
    "rad": 1.5,
}
JUDGES = tuple(range(4000, 4010))  # seeds of the operators who judge
JUDGE_SECONDS, STROKE = 60.0, 0.8  # V
_WINDOW = 0.2  # s, of derivatives


class Conditions(NamedTuple):
    """Under which a machine is measured.

    Attributes
    ----------
    minutes : float
        Of operation.
    noise : float
        Standard deviation of every sensor, as a share of its range.
    stroke : float
        Share of the full joystick travel that the operator uses.
    dropout : float
        Share of the time in which a sensor gives nothing.
    flow_sensors : bool
        Without them flows are reconstructed from joint angles.
    limited : bool
        Whether the pumps have a torque limit.
    friction : float
        Of all joints, as a multiple of the machine's; the judges' machine has the same.
    outlet_sensors : bool
        Without those of the flows out of actuators, these follow from the flows in by the ratio of areas.
    operator : int
        Seed of the one who works.
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


USUAL = Conditions()
# One condition at a time; the first entry of each is what it is compared over.
SWEEPS: dict[str, list[Conditions]] = {
    "operator": [USUAL._replace(operator=operator) for operator in (1000, 1100, 1200)],
    "minutes": [USUAL._replace(minutes=minutes) for minutes in (2.0, 5.0, 10.0, 30.0)],
    "noise": [USUAL._replace(noise=noise) for noise in (0.0, 0.001, 0.003, 0.01, 0.03)],
    "stroke": [USUAL._replace(stroke=stroke) for stroke in (0.6, 0.8, 1.0)],
    "dropout": [USUAL._replace(dropout=dropout) for dropout in (0.0, 0.05, 0.2)],
    "flow sensors": [USUAL._replace(flow_sensors=has) for has in (True, False)],
    "outlet sensors": [USUAL._replace(outlet_sensors=has) for has in (True, False)],
    "torque limit": [USUAL._replace(limited=limited) for limited in (False, True)],
    "friction": [USUAL._replace(friction=friction) for friction in (0.0, 1.0, 5.0)],
    "friction without flow sensors": [
        USUAL._replace(friction=friction, flow_sensors=False) for friction in (0.0, 1.0, 5.0)
    ],
}


class Outcome(NamedTuple):
    """What networks learnt from measurements reach.

    Attributes
    ----------
    rows : int
        That were left to learn from.
    flow_rms : dict from link to rms error of its input flow in in3/s, at the states that the judges pass through
    median, worst : float
        Of the largest end-effector errors in m of the operators who judge.
    scenarios : dict from name to largest end-effector error in m
    """

    rows: int
    flow_rms: dict[str, float]
    median: float
    worst: float
    scenarios: dict[str, float]


def outcomes(lab: Lab, conditions: Sequence[Conditions]) -> list[Outcome]:
    """Measure, learn and judge under each of some conditions, on all processors; kept by the lab, each as soon as it is there."""
    keys = {c: f"measured {_name(c)}" for c in conditions}
    missing = [c for c, key in keys.items() if not lab.computed.has_data(key)]
    n_jobs = min(len(missing), cpu_count()) or 1
    made = Parallel(n_jobs=n_jobs, return_as="generator")(delayed(_made)(lab.machine, c) for c in missing)
    for number, c in enumerate(missing, 1):
        lab.say(f"learn from measurements, {number} of {len(missing)}: {conditions_in_words(c)}")
        lab.computed.data(keys[c], lambda: next(made))
    return [Outcome(*lab.computed.data(keys[c], list)) for c in conditions]


def _made(machine: LayoutMachine, conditions: Conditions) -> list[Any]:
    machine = _machine(machine, conditions)
    log = measured(machine, conditions)
    return [
        len(log),
        *_judged(
            machine, [model for (model,) in learn([(task,) for task in tasks_of(machine, Known.of(machine), log)])]
        ),
    ]


def conditions_in_words(conditions: Conditions) -> str:
    """Conditions in words."""
    c = conditions
    words = [f"{c.minutes:g} min", f"sensor noise {100.0 * c.noise:g} %", f"joystick travel {100.0 * c.stroke:g} %"]
    words += [f"sensors silent {100.0 * c.dropout:g} % of the time"] if c.dropout else []
    words += [] if c.flow_sensors else ["no flow sensors"]
    words += [] if c.outlet_sensors else ["no outlet-flow sensors"]
    words += ["pumps with a torque limit"] if c.limited else []
    words += [f"{c.friction:g} times the friction" if c.friction else "no friction"] if c.friction != 1.0 else []
    words += [f"logged from operator {c.operator}"] if c.operator != USUAL.operator else []
    return ", ".join(words)


def _name(conditions: Conditions) -> str:
    return " ".join(f"{value:g}" if isinstance(value, float) else str(int(value)) for value in conditions)


def _machine(machine: LayoutMachine, conditions: Conditions) -> LayoutMachine:
    rubbing = []
    for f in machine.functions:
        torques = {name: conditions.friction * getattr(f.friction, name) for name in ("coulomb", "static", "viscous")}
        rubbing.append(f._replace(friction=f.friction._replace(**torques)))
    return with_pumps(machine._replace(functions=tuple(rubbing)), torque_limit_enabled=conditions.limited)


def measured(machine: LayoutMachine, conditions: Conditions) -> Table:
    """What sensors read of a random operator's work, and what follows from it; rows in which a sensor is silent are gone."""
    scenario = random_operator(conditions.operator, 60.0 * conditions.minutes, limit=STROKE * conditions.stroke)
    run = simulate(machine, "exact", scenario, raster=RASTER)
    flows = ["q_in", *(["q_out"] if conditions.outlet_sensors else [])] if conditions.flow_sensors else ["angle"]
    quantities = ["spool", "p_a", "p_b", *flows]
    read = {"time": run["time"]}
    for place, column in enumerate(f"{link}.{name}" for link in LINKS for name in quantities):
        unit = run.unit(column)
        sensor = Sensor(
            column, column, unit, RASTER, noise=conditions.noise * RANGES[unit], dropout=conditions.dropout, dropout_length=0.5
        )  # fmt: skip
        read[column] = Reading(sensor, np.random.default_rng([conditions.operator, place])).of(run)[1]
    if not conditions.flow_sensors:
        for link in LINKS:
            read |= _flows(machine, link, read)
    elif not conditions.outlet_sensors:
        for link in LINKS:
            read[f"{link}.q_out"] = _outlet_flow(machine, link, read)
    heard = np.all(np.isfinite(np.column_stack(list(read.values()))), axis=1)
    return by_port(Known.of(machine), Table({name: values[heard] for name, values in read.items()}, {}))


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
    return read[f"{link}.q_in"] * np.where(read[f"{link}.spool"] > 0.0, ratio, 1.0 / ratio)


def _judged(machine: LayoutMachine, models: list[Model]) -> list[Any]:
    """Errors of networks where operators work: of flows at the states of their exact runs, and of the end-effector."""
    flow = build_flow("polynomial", machine, models=models)
    away, squares = [], []
    for seed in JUDGES:
        scenario = random_operator(seed, JUDGE_SECONDS)
        exact = simulate(machine, "exact", scenario)
        away.append(float(effector_distance(exact, simulate(machine, flow, scenario)).max()))
        spool, p_in, p_out = (exact.matrix([f"{link}.{name}" for link in LINKS]) for name in ("spool", "p_in", "p_out"))
        error = sample_flow(machine, flow, spool, p_in, p_out).q_in - exact.matrix([f"{link}.q_in" for link in LINKS])
        squares.append(np.mean(error**2, axis=0))
    rms = units.from_si(np.sqrt(np.mean(squares, axis=0)), "in3/s")
    scenarios = {}
    for name in SCENARIOS:
        exact, learnt = (simulate(machine, model, load_scenario(name)) for model in ("exact", flow))
        scenarios[name] = float(effector_distance(exact, learnt).max())
    return [dict(zip(LINKS, rms.tolist(), strict=True)), float(np.median(away)), max(away), scenarios]
